//! From a plant, a cost and a link to steady-state gains, by either of two solvers.
//!
//! | file | what lives there |
//! |---|---|
//! | `in_flight` | the project's own form: the core's recursion iterated to its fixed point |
//! | `coupled` | the thesis' recursion over actuator modes: the reference |
//! | `channel_in_flight` | the project's own form over a channel that comes and goes, known one cycle late |
//! | `channel_law` | its law in the form the device computes |
//! | `correlated` | the same over a channel that comes and goes, for controllers that know more or less of it |
//! | `modes` | the thesis' model of the loop, one set of matrices for each age of the buffer |
//! | `closed_loop` | that model with given gains: evolution of second moments |
//! | `finite_horizon` | time-varying gains for a task that ends |
//! | `tracking` | what a reference adds: preview gains, set points, the feedforward of a task |
//! | `trigger` | what sending a packet is worth, as tables |
//! | `seldom_acknowledged` | the law where acknowledgements come late or are lost |
//! | `unacknowledged` | the law for a loop without acknowledgements, and its exact cost |
//! | `schedule` | a packet in every p-th cycle, and which p costs least |
//! | `rollout` | the same worth from the thesis' matrices for one history of decisions: the reference |
//! | `network_free` | the problem without its network, to the last digit: where both recursions start |
//! | `coordinates` | units that come from the data, in which everything is computed |
//! | `refined` | the same with the network, where rounding adds up |
//! | `flat` | a problem as the core takes it |
//! | `iterate` | when an iteration has converged, and when it never will; the same for both |
//! | `krylov` | Arnoldi's process, on which the next two stand |
//! | `spectral` | spectral radius of a linear map: the mean-square rate |
//! | `radius` | spectral radius of a matrix, to the last digits |
//! | `emitted` | the law with its numbers rounded for the device |
//! | `evaluation` | fixed point of an affine map: the cost of given gains |
//! | `applied` | how large the inputs are that the loop applies |
//! | `sums` | the same for a loop that is a single matrix |
//! | `acceleration` | steps of an iteration combined, so that fewer do |
//! | `age_chain` | the transition matrix of the actuator's age |
//! | `mode_chain` | what the controller may know of the network: ages, and states of a channel |
//! | `law` | gains in both forms, and the way from one to the other |
//!
//! Conditions that need no gains (how long sequences must at least be) are in [`crate::stability`].

mod acceleration;
mod age_chain;
mod applied;
mod channel_in_flight;
mod channel_law;
mod closed_loop;
mod coordinates;
mod correlated;
mod coupled;
mod critical_length;
mod emitted;
mod evaluation;
mod finite_horizon;
mod flat;
mod in_flight;
mod iterate;
mod krylov;
mod law;
mod mode_chain;
mod modes;
mod network_free;
mod radius;
mod refined;
mod rollout;
mod schedule;
mod seldom_acknowledged;
mod spectral;
mod sums;
mod tracking;
mod trigger;
mod unacknowledged;

use crate::stability;
use coordinates::Coordinates;
use nalgebra::DMatrix;
use network_free::{NetworkFree, network_free};
use std::borrow::Cow;

pub use crate::problem::LoopProblem;
pub use age_chain::age_transitions;
pub use applied::applied_costs;
pub use channel_in_flight::{ChannelSolution, solve_channel};
pub use channel_law::ChannelLaw;
pub(crate) use closed_loop::ClosedLoop;
pub use closed_loop::mean_square_rate;
pub use correlated::{Correlated, Knowledge, OnChannel, correlated};
pub use coupled::{finite_horizon_reference, tracking_reference};
pub(crate) use critical_length::critical_length;
pub(crate) use emitted::emitted_rate;
pub(crate) use evaluation::solve_correction;
pub use finite_horizon::{FiniteHorizon, finite_horizon, tracking_task};
pub(crate) use flat::row_major;
pub use iterate::Outcome;
pub use law::{Law, mode_weights};
pub use mode_chain::{ModeChain, TooManyModes};
pub(crate) use modes::{Mode, modes};
pub(crate) use radius::rough_radius;
pub use rollout::{Rollout, ScheduleReference, Situation};
pub use schedule::{
    NotScheduled, Schedule, ScheduleCost, Scheduled, ScheduledTrigger, Schedules, schedule, scheduled,
};
pub(crate) use spectral::spectral_radius;
pub use tracking::{
    LONGEST_PREVIEW, PreviewGains, PreviewTooLong, Tracked, TrackedTask, preview_gains, set_point_gains,
};
pub use trigger::{TriggerTables, trigger_tables};
pub(crate) use unacknowledged::{LONGEST_TRIED, if_linear, shortest_unacknowledged};
pub use unacknowledged::{Unacknowledged, unacknowledged};

/// Which recursion computes the gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The in-flight recursion, THEORY 4.
    InFlight,
    /// The coupled recursion over the actuator's modes, thesis (3.31), (3.32).
    Coupled,
}

impl Method {
    /// As on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::InFlight => "in-flight",
            Self::Coupled => "coupled",
        }
    }
}

/// Gains, and what is known about them.
#[derive(Debug, Clone)]
pub struct Solution {
    /// How the iteration ended. Gains of one that did not converge are those of its last step.
    pub outcome: Outcome,
    /// Backward steps taken.
    pub iterations: usize,
    /// Steps that started from the exact cost of the gains before: policy iterations.
    pub policy_iterations: usize,
    /// Relative residual of the fixed-point equation at the last step.
    pub residual: f64,
    /// Spectral radius of the closed loop's second moments with these gains; below 1 iff mean-square stable. THEORY 5.
    pub mean_square_rate: f64,
    /// How far the gains may be off, relative to the largest of their row: an estimate of the forward error for the plant
    /// as given, no residual. Infinite for gains that have not converged.
    pub gain_error: f64,
    /// The law in the in-flight form.
    pub law: Law,
    /// Gains per mode as the coupled recursion found them; the in-flight one needs none.
    coupled_gains: Option<Vec<DMatrix<f64>>>,
    /// The whole cost-to-go `(P, S, Y, N_t)` as the core lays it out; the coupled recursion has none.
    value: Option<Vec<f64>>,
    /// A cost-to-go that the loop forgets last, as far as it is known.
    slowest: Option<Vec<f64>>,
    /// The problem it was solved from.
    start: Start,
    /// `P`, `nx x nx`.
    pub cost_to_go: DMatrix<f64>,
    /// Weight in the law of the one that knows no age, 0 to 1: [`Solution::for_acknowledgements`].
    pub unknown_weight: f64,
}

impl Solution {
    /// Whether these are the optimal gains and the loop is mean-square stable with them.
    pub fn is_stabilising(&self) -> bool {
        self.outcome == Outcome::Converged
    }

    /// `L(i)` over `[x; rho]` (hold: and the default input) for the acknowledged age `i = 0..=N`, thesis (3.31).
    ///
    /// For the in-flight solver they are spelled out from the law: `O(N^4)` numbers that no device needs.
    pub fn mode_gains(&self) -> Cow<'_, [DMatrix<f64>]> {
        match &self.coupled_gains {
            Some(gains) => Cow::Borrowed(gains),
            None => Cow::Owned(self.law.mode_gains()),
        }
    }

    /// One of the [`Solution::mode_gains`].
    pub fn mode_gain(&self, age: usize) -> Cow<'_, DMatrix<f64>> {
        match &self.coupled_gains {
            Some(gains) => Cow::Borrowed(&gains[age]),
            None => Cow::Owned(self.law.mode_gain(age)),
        }
    }

    /// Long-run average cost per step if the state is known: `tr(P W)`. THEORY 5.
    pub fn control_cost(&self, process_noise: &DMatrix<f64>) -> f64 {
        self.cost_to_go.component_mul(process_noise).sum()
    }
}

/// Solves in balanced coordinates, from the solution without a network where there is one.
pub fn solve(problem: &LoopProblem, method: Method) -> Solution {
    Start::of(problem).solve(method)
}

/// `P` for the problem, as [`solve`] finds it, where nobody asks how fast the loop forgets.
pub(crate) fn settled_cost(problem: &LoopProblem) -> DMatrix<f64> {
    let start = Start::of(problem);
    match &start.free {
        Some(free) if problem.is_network_free() => start.coordinates.cost(&free.cost_to_go),
        _ => start.solve(Method::InFlight).cost_to_go,
    }
}

/// A problem made ready to be solved.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    /// Where `problem` is expressed.
    coordinates: Coordinates,
    /// The problem in these coordinates.
    problem: LoopProblem,
    /// Its solution without a network; `None` if there is none, or it was not found.
    free: Option<NetworkFree>,
    /// A cost-to-go of the state to go on from, `nx x nx`.
    begun: Option<DMatrix<f64>>,
    /// Largest modulus of the eigenvalues of `A`.
    open_loop_modulus: f64,
}

impl Start {
    /// Solves it.
    pub(crate) fn solve(&self, method: Method) -> Solution {
        match method {
            Method::InFlight => in_flight::solve(self),
            Method::Coupled => {
                self.coordinates.restore(coupled::solve(self), &flat::dimensions(&self.problem))
            }
        }
    }

    /// The same in units in which states and inputs cost alike by the cost-to-go `cost`, `nx x nx`, from which it starts then.
    fn measured_by(&self, cost: &DMatrix<f64>) -> Self {
        let price = &self.problem.r + self.problem.b.tr_mul(&(cost * &self.problem.b));
        let here = Coordinates::given(&self.problem);
        let relative = here.by_cost(cost, &price);
        let (states, inputs) = relative.relative_to(&here);
        Self {
            coordinates: self.coordinates.then(&relative),
            problem: relative.express(&self.problem),
            free: self.free.clone().map(|free| free.in_units(&states, &inputs)),
            begun: Some(relative.express_cost(cost)),
            open_loop_modulus: self.open_loop_modulus,
        }
    }

    /// The same for a cost-to-go in the design's units.
    fn measured_by_given(&self, cost: &DMatrix<f64>) -> Self {
        self.measured_by(&self.coordinates.express_cost(cost))
    }

    /// Whether the in-flight recursion converges. Where the weights see every mode that does not decay, as those of a design do,
    /// its gains then stabilise the loop; their rate is not computed.
    pub(crate) fn converges(&self) -> bool {
        in_flight::converges(self)
    }

    /// The same with sequences of `length` inputs, of which neither units nor the solution without a network know.
    pub(crate) fn with_length(&self, length: usize) -> Self {
        Self {
            coordinates: self.coordinates.clone(),
            problem: self.problem.with_length(length),
            free: self.free.clone(),
            begun: None,
            open_loop_modulus: self.open_loop_modulus,
        }
    }

    /// `problem` made ready.
    pub(crate) fn of(problem: &LoopProblem) -> Self {
        let coordinates = Coordinates::of(problem);
        let balanced = coordinates.express(problem);
        let open_loop_modulus = stability::open_loop_modulus(&problem.a);
        let Some(free) = network_free(&balanced) else {
            return Self { problem: balanced, coordinates, free: None, begun: None, open_loop_modulus };
        };
        // Now that it is known what a state and an input cost, units in which all cost the same.
        let price = &balanced.r + balanced.b.tr_mul(&(&free.cost_to_go * &balanced.b));
        let by_cost = coordinates.by_cost(&free.cost_to_go, &price);
        let (states, inputs) = by_cost.relative_to(&coordinates);
        let free = free.in_units(&states, &inputs);
        Self {
            problem: by_cost.express(problem),
            coordinates: by_cost,
            free: Some(free),
            begun: None,
            open_loop_modulus,
        }
    }

    /// Theorem 3.4 b): whether the buffer runs dry so often that no controller can stabilise the plant.
    fn runs_dry(&self) -> bool {
        stability::dry_growth_of(&self.problem, self.open_loop_modulus) > 1.0
    }

    /// Largest modulus of the eigenvalues of `A`, from [`stability::open_loop_modulus`].
    pub(crate) fn open_loop_modulus(&self) -> f64 {
        self.open_loop_modulus
    }

    /// The cost-to-go of the state to start from, `nx x nx`: never above what the network makes of it.
    fn cost_to_go(&self) -> &DMatrix<f64> {
        self.free.as_ref().map_or(&self.problem.q, |free| &free.cost_to_go)
    }

    /// The scale below which a cost-to-go is still dominated by what there is without a network.
    fn cost_scale(&self) -> f64 {
        let effect = self.problem.b.norm_squared().max(f64::MIN_POSITIVE);
        self.cost_to_go().trace() + self.problem.r.trace() / effect
    }
}
