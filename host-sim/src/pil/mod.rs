//! Processor in the loop: controller and actuator run on boards in an emulator, plant and links in the simulator.
//!
//! | file | what lives there |
//! |---|---|
//! | `emulator` | a board in QEMU, and the line to it |
//! | `files` | where lines and logs are, and which of them stay |
//! | `remote` | a node on a board: frames to it and from it |
//! | `sealed` | sensor, clock and host of nodes whose frames are sealed |
//! | `frames` | frames of a size class to those of the design's own dimensions and back |
//! | `ends` | both nodes as ends of the loop, with a twin in this process |
//! | `difference` | the first thing in which board and simulator differ |
//! | `replacement` | gains that are replaced while the loop runs |
//! | `restart` | nodes that are killed and come back |
//! | `images` | the programs for a design, built |
//! | `outcome` | what a run came to |
//! | `telling` | the same in words and as JSON |
//!
//! The loop is [`crate::closed_loop`]'s, the same as without boards.

mod difference;
mod emulator;
mod ends;
mod files;
mod frames;
mod images;
mod outcome;
mod remote;
mod replacement;
mod restart;
mod sealed;
mod telling;

use crate::{
    closed_loop::{RunPlan, run, run_ends},
    contender::Contender,
    ends::CoreEnds,
    fitted::{Fitted, Unfit},
    lent::Lent,
    network::Network,
    size_class::InSizeClass,
};
use ends::{BoardEnds, Boards};
use frames::Dimensions;
use gain_gen::{
    design::{Authentication, Design},
    emit::design_id,
};
use slqg::{Scalar, controller::Law};

pub use difference::Difference;
pub use emulator::{Board, NoEmulator, Setup, Transport, find_emulator};
pub use files::{Files, NoFiles};
pub use images::{NoImages, Request, build};
pub use outcome::{Instructions, Outcome, Recovery};
pub use remote::{NodeFailure, name};
pub use replacement::{Replacement, Unsendable};
pub use restart::{Misplaced, NoRestart, Restart, at_random, in_order};

/// Seed of the restarts and of the loop, cycles, and which boards.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Cycles.
    pub cycles: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Boards of the controller and of the actuator.
    pub setups: [Setup; 2],
    /// Nodes that are killed, [in order](in_order).
    pub restarts: Vec<Restart>,
}

/// Why there is no outcome.
#[derive(Debug, thiserror::Error)]
pub enum PilError {
    /// The design does not fit the scalar.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// A node has stopped.
    #[error(transparent)]
    Node(#[from] NodeFailure),
}

/// One run of the loop with its ends on boards, and the same run without.
#[derive(Debug)]
pub struct Pil<'a, P> {
    /// The loop.
    pub design: &'a Design,
    /// Its controller: one whose frames are the core's alone.
    pub contender: &'a Contender,
    /// What is done.
    pub plan: &'a Plan,
    /// Gains that the controller gets on the way: as a blob, and the design and controller that they are of.
    pub replacement: Option<(&'a Replacement, &'a Design, &'a Contender)>,
    /// For lines and logs.
    pub files: &'a Files,
    /// Called after every cycle.
    pub done: P,
}

impl<P: Fn() + Sync> InSizeClass for Pil<'_, P> {
    type Output = Result<Outcome, PilError>;

    fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Self::Output {
        self.with::<T, NX, NU, NY>()
    }
}

impl<P: Fn() + Sync> Pil<'_, P> {
    fn with<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
        &self,
    ) -> Result<Outcome, PilError> {
        let Self { design, contender, plan, files, done, replacement } = self;
        let fitted = Fitted::<T, NX, NU, NY>::new(design, contender);
        fitted.design()?;
        let other = replacement.map(|(_, design, contender)| Fitted::<T, NX, NU, NY>::new(design, contender));
        let law = match &other {
            // A blob does not tell `q(0)`.
            Some(other) => {
                Some(Law { arrives_at_once: fitted.design()?.arrives_at_once, ..other.design()?.law() })
            }
            None => None,
        };
        let run_plan = RunPlan { steps: plan.cycles, seed: plan.seed, run: 0 };
        let mut undisturbed = Vec::with_capacity(plan.cycles);
        let host = run(&fitted, contender, run_plan, |snapshot| undisturbed.push(*snapshot.state));

        let boards = Boards {
            setups: &plan.setups,
            files,
            restarts: &plan.restarts,
            replacement: replacement.map(|(replacement, ..)| replacement).zip(law),
            dimensions: Dimensions {
                scalar: T::BYTES.into(),
                inputs: [design.plant.inputs(), NU],
                outputs: [design.plant.outputs(), NY],
            },
            tracked: design.tracking.as_ref().map_or(0, |tracking| tracking.outputs()),
            sealed: (design.authentication == Authentication::Cmac).then(|| design_id(design)),
        };
        let mut memory = Lent::for_ends(&fitted)?;
        let twin = CoreEnds::new(&fitted, contender, &mut memory);
        let mut ends = BoardEnds::start(&fitted, twin, boards)?;
        let mut network = Network::new(contender, fitted.carrier(), plan.seed, 0);
        let mut states = Vec::with_capacity(plan.cycles);
        let mut all_finite = true;
        let result = run_ends(&fitted, contender, run_plan, &mut network, &mut ends, |snapshot| {
            states.push(*snapshot.state);
            all_finite &= snapshot.input.iter().all(|value| value.is_finite());
            done();
        })?;
        let status = ends.status()?;
        Ok(Outcome {
            name: design.name.clone(),
            sequence_length: contender.laws[0].length,
            cycles: plan.cycles,
            seed: plan.seed,
            board: plan.setups[0].board,
            transport: plan.setups[0].transport,
            host_cost: host.cost,
            board_cost: result.cost,
            diverged: result.diverged,
            all_finite,
            sent: result.sent,
            difference: ends.difference.take(),
            replaced: ends.replaced(),
            tuned: std::mem::take(&mut ends.tuned),
            recoveries: outcome::recoveries(&plan.restarts, &undisturbed, &states),
            instructions: plan.setups[0]
                .counts
                .then(|| Instructions::of(&ends.durations, plan.setups[0].board)),
            controller: status[0],
            actuator: status[1],
        })
    }
}
