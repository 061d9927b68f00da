//! Controllers for a link that becomes another one during a run: one that finds out, and one that is told.

use super::{Contender, ContenderError, Kind};
use gain_gen::{
    design::{Acknowledgement, Design, Link},
    solve::{Law, LoopProblem, Method, solve},
};

/// Slices of a solution that a device is taken to do in a cycle: of the pendulum's with four inputs a sequence they take a
/// Cortex-M4F at 25 MHz 13 ms of 20.
pub const DEFAULT_SLICES: usize = 16;

/// The link to the actuator becomes another one.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// What it becomes. Packets under way keep the fate they had.
    pub link: Link,
    /// From this cycle on.
    pub cycle: usize,
}

/// What a controller is given that tunes itself, beside the law to begin with.
#[derive(Debug, Clone)]
pub struct TuningBasis {
    /// The loop it was designed for.
    pub problem: LoopProblem,
}

/// The law for the link as it will be.
#[derive(Debug, Clone)]
pub struct LawToCome {
    /// The law.
    pub law: Law,
    /// Probability that a sequence arrives in the cycle it is sent in.
    pub arrives_at_once: f64,
}

/// Whether a controller can tune itself to the link of this design.
pub(super) fn can_be_tuned(design: &Design) -> Result<(), ContenderError> {
    let (with, reason) = if design.event.is_some() {
        ("[event]", "the tables that say what sending is worth would stay those of the old link")
    } else if design.tracking.is_some() {
        ("[tracking]", "preview gains would stay those of the old link")
    } else if design.network.acknowledgement == Acknowledgement::None {
        ("network.acknowledgement = \"none\"", "what it knows of the link it knows from acknowledgements")
    } else {
        return Ok(());
    };
    Err(ContenderError::TunesAlone { with, reason })
}

impl Contender {
    /// Puts it on a link that will change, of which `slqg-told` alone is told.
    ///
    /// # Errors
    /// A link is on a bus, whose traffic decides what becomes of packets; or the loop cannot be stabilised once it has
    /// changed, and the controller should know how.
    pub fn meet(&mut self, change: Change, design: &Design) -> Result<(), ContenderError> {
        if self.kind == Kind::Lqg {
            // It sits at the plant.
            return Ok(());
        }
        if change.link.is_on_bus() || self.actuator_link.is_on_bus() {
            return Err(ContenderError::ChangesOnBus);
        }
        if self.kind == Kind::SlqgTold {
            let problem = LoopProblem { link: change.link.delays.clone(), ..LoopProblem::of(design) };
            let solution = solve(&problem, Method::InFlight);
            if !solution.is_stabilising() {
                return Err(self.unstable());
            }
            let arrives_at_once = problem.arrives_at_once();
            self.to_come = Some(LawToCome { law: solution.law, arrives_at_once });
        }
        self.change = Some(change);
        Ok(())
    }
}
