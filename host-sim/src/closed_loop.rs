//! One run of the loop: sensor, link, controller, link, actuator, plant. Thesis 3.1.
//!
//! The ends, [`crate::ends`], are the core's and share nothing but encoded frames. Cycle `k`: the sensor samples `y_k` (not in cycle 0,
//! where the controller knows the initial mean) and sends it; the controller takes what has arrived, acknowledgements of
//! cycle `k-1` and earlier among it, and sends `U_k`; the actuator takes what has arrived and applies its input. An
//! acknowledgement with a delay of 0 is there before the next cycle, as an instant one is always.

mod record;

pub use record::{Arrival, CycleRecord, Snapshot};

use crate::{
    contender::Contender,
    ends::{CoreEnds, Ends, frame_capacity},
    fitted::Fitted,
    lent::Lent,
    network::Network,
    plant::PlantRun,
};
use gain_gen::design::Acknowledgement;
use record::Arrivals;
use slqg::{
    Scalar, Tick,
    wire::{self, Measurement},
};

/// State beyond this many times its initial or noise scale counts as diverged.
const DIVERGED: f64 = 1e6;

/// What one run came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunResult {
    /// Stage costs over the run and the terminal one at its end, as in [`crate::objective`]. Without the cost of sending.
    pub cost: f64,
    /// Whether the state left 1e6 times its initial or noise scale.
    pub diverged: bool,
    /// Cycles after which the state had left, for good, what inputs within their limits bring back, or had diverged.
    pub lost_after: Option<usize>,
    /// Control frames sent.
    pub sent: usize,
    /// Sum over cycles of the age of what was applied; an empty buffer counts as the sequence length.
    pub age_sum: usize,
    /// Frames that either end refused.
    pub rejected: u64,
}

/// Which run to do.
#[derive(Debug, Clone, Copy)]
pub struct RunPlan {
    /// Cycles, `K`.
    pub steps: usize,
    /// Seed of the whole simulation.
    pub seed: u64,
    /// Number of the run, which picks its random numbers.
    pub run: u64,
}

/// Runs the loop once over the contender's links; `record` is called with every cycle.
///
/// # Panics
/// As [`run_over`].
pub fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    fitted: &Fitted<T, NX, NU, NY>,
    contender: &Contender,
    plan: RunPlan,
    record: impl FnMut(Snapshot<'_, T, NX, NU>),
) -> RunResult {
    let mut network = Network::new(contender, fitted.carrier(), plan.seed, plan.run);
    run_over(fitted, contender, plan, &mut network, record)
}

/// Runs the loop once over `network`, on which nothing is under way; `record` is called with every cycle.
///
/// # Panics
/// If the fitted controller's tables are no gains, which [`Fitted::design`] tells beforehand.
pub fn run_over<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    fitted: &Fitted<T, NX, NU, NY>,
    contender: &Contender,
    plan: RunPlan,
    network: &mut Network<T, NU, NY>,
    record: impl FnMut(Snapshot<'_, T, NX, NU>),
) -> RunResult {
    let mut memory = Lent::for_ends(fitted).expect("checked before the first run");
    let mut ends = CoreEnds::new(fitted, contender, &mut memory);
    let Ok(result) = run_ends(fitted, contender, plan, network, &mut ends, record);
    result
}

/// Runs the loop once with these ends over `network`, on which nothing is under way; `record` is called with every cycle.
///
/// # Errors
/// If an end stops.
pub(crate) fn run_ends<T: Scalar, const NX: usize, const NU: usize, const NY: usize, X: Ends<T, NX, NU>>(
    fitted: &Fitted<T, NX, NU, NY>,
    contender: &Contender,
    plan: RunPlan,
    network: &mut Network<T, NU, NY>,
    ends: &mut X,
    mut record: impl FnMut(Snapshot<'_, T, NX, NU>),
) -> Result<RunResult, X::Error> {
    let RunPlan { steps, seed, run } = plan;
    let mut plant = PlantRun::new(&fitted.plant, seed, run);
    let scale = fitted.plant.scale();
    let mut frame = vec![0; frame_capacity::<T>(NU, NY)];
    let mut arrivals = Arrivals::new(contender);
    let mut result =
        RunResult { cost: 0.0, diverged: false, lost_after: None, sent: 0, age_sum: 0, rejected: 0 };

    for cycle in 0..steps {
        let tick = Tick(cycle as u32);
        ends.begin(cycle)?;
        let measurement_frame = (cycle > 0).then(|| {
            let output = fitted.sent(&plant.measure());
            let bytes = wire::encode_measurement(&Measurement { tick, output }, &mut frame)
                .expect("the buffer holds every frame");
            network.send_measurement(bytes)
        });
        arrivals.taken.clear();
        network.to_controller(|packet| {
            arrivals.note::<T, NU, NY>(packet);
            ends.to_controller(packet);
        });
        let sequence = ends.control(cycle, network.channel_states())?;
        let control_frame = network.send_control(sequence);
        result.sent += usize::from(control_frame.is_some());

        network.to_actuator(|packet| {
            arrivals.note::<T, NU, NY>(packet);
            ends.to_actuator(packet);
        });
        let (applied, acknowledgement) = ends.play()?;
        let fate = network.send_acknowledgement(acknowledgement);

        let input = applied.input.map(|value| value.widen());
        let state = *plant.state();
        let stage_cost = fitted.objective.stage(cycle, &state, &input);
        result.cost += stage_cost;
        result.age_sum += applied.age.steps().unwrap_or(contender.laws[0].length);
        record(Snapshot {
            state: &state,
            estimate: ends.estimate(),
            input: &input,
            stage_cost,
            tuning: ends.tuning(),
            tracked: fitted.objective.tracked(cycle, &state),
            age: applied.age.steps(),
            control_frame,
            measurement_frame,
            acknowledgement_frame: fate.filter(|_| contender.acknowledgement != Acknowledgement::None),
            arrivals: &arrivals.taken,
        });
        plant.step(&input);
        let size = plant.state().norm();
        result.diverged |= size.is_nan() || size > DIVERGED * scale;
        let is_lost = result.diverged || fitted.recovery.is_beyond(plant.state());
        result.lost_after = is_lost.then(|| result.lost_after.unwrap_or(cycle + 1));
        network.next_cycle();
    }
    result.cost += fitted.objective.terminal(steps, plant.state());
    result.rejected = ends.rejected();
    Ok(result)
}
