//! Gains for a link whose quality comes and goes, for a controller that knows more or less of it, and what each costs.
//!
//! The thesis' coupled recursion takes any chain of modes. Over ages together with the channel's states it is optimal for
//! a controller that learns both one cycle late; over ages alone, with the transitions they have on average, for one that
//! sees the ages only; over independent packets with the average delays for one that takes no notice. All three are put
//! on the true chain, so that their costs can be compared. The law for the device is in `channel_law`.

use super::{
    ClosedLoop, LoopProblem, Method, ModeChain, Outcome, Start, TooManyModes, coupled::CoupledRecursion,
    evaluation::solve_correction, iterate::iterate, modes::modes, solve,
};
use crate::design::MarkovLink;
use nalgebra::DMatrix;

/// Relative accuracy of the cost of given gains.
const COST_TOLERANCE: f64 = 1e-12;

/// What the controller is given of the network besides its packets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knowledge {
    /// The average delay distribution: packets are taken as independent.
    Average,
    /// How ages follow each other on average.
    Ages,
    /// The state of the channel, one cycle late.
    Channel,
}

impl Knowledge {
    /// From little to much.
    pub const ALL: [Self; 3] = [Self::Average, Self::Ages, Self::Channel];

    /// As in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Average => "average",
            Self::Ages => "ages",
            Self::Channel => "channel",
        }
    }
}

/// Gains on the true chain of age and channel, and how the loop does with them.
#[derive(Debug, Clone)]
pub struct OnChannel {
    /// What the gains were designed with.
    pub knowledge: Knowledge,
    /// `L(j)` for each mode of the chain, `(N nu) x n`, over `[x; rho]` (hold: and the default input).
    pub gains: Vec<DMatrix<f64>>,
    /// Spectral radius of the second moments; below 1 iff mean-square stable.
    pub mean_square_rate: f64,
    /// Long-run average cost per step if the state is known; infinite if the loop is not mean-square stable.
    pub control_cost: f64,
}

/// The three designs over one channel.
#[derive(Debug, Clone)]
pub struct Correlated {
    /// Ages together with the channel's states.
    pub chain: ModeChain,
    /// In the order of [`Knowledge::ALL`]; a design that cannot be stabilised by its own model is missing.
    pub designs: Vec<OnChannel>,
}

/// Designs for `channel` with each kind of knowledge. The problem's own link does not matter. `process_noise`: `W`, `nx x nx`.
///
/// # Errors
/// The channel has too many states for this sequence length.
pub fn correlated(
    problem: &LoopProblem,
    channel: &MarkovLink,
    process_noise: &DMatrix<f64>,
) -> Result<Correlated, TooManyModes> {
    let chain = ModeChain::with_channel(channel, problem.length)?;
    let average = LoopProblem { link: channel.average().clone(), ..problem.clone() };
    let start = Start::of(problem);
    let designs = Knowledge::ALL.into_iter().filter_map(|knowledge| {
        let by_age = |gains: &[DMatrix<f64>]| chain.ages.iter().map(|&age| gains[age].clone()).collect();
        let gains = match knowledge {
            Knowledge::Average => {
                let solution = solve(&average, Method::Coupled);
                solution.is_stabilising().then(|| by_age(&solution.mode_gains()))?
            }
            Knowledge::Ages => by_age(&settle_over(chain.lumped(), &start)?),
            Knowledge::Channel => settle_over(chain.clone(), &start)?,
        };
        Some(on_channel(&start, &chain, process_noise, knowledge, gains))
    });
    let designs = designs.collect();
    Ok(Correlated { chain, designs })
}

impl Correlated {
    /// The design with this knowledge, if there is one.
    pub fn with(&self, knowledge: Knowledge) -> Option<&OnChannel> {
        self.designs.iter().find(|design| design.knowledge == knowledge)
    }
}

/// The gains of the recursion over a chain at its fixed point; `None` if none stabilise the loop.
fn settle_over(chain: ModeChain, start: &Start) -> Option<Vec<DMatrix<f64>>> {
    let mut recursion = CoupledRecursion::over(chain, &start.problem, start.cost_to_go());
    let ending = iterate(&mut recursion, start.cost_scale(), false);
    let mut gains = (ending.outcome == Outcome::Converged).then_some(recursion.gains)?;
    gains.iter_mut().for_each(|gain| start.coordinates.restore_gain(gain));
    Some(gains)
}

fn on_channel(
    start: &Start,
    chain: &ModeChain,
    process_noise: &DMatrix<f64>,
    knowledge: Knowledge,
    gains: Vec<DMatrix<f64>>,
) -> OnChannel {
    let modes = modes(&start.problem);
    let expressed: Vec<_> = gains.iter().map(|gain| start.coordinates.express_gain(gain)).collect();
    let closed = ClosedLoop { modes: &modes, chain, gains: &expressed };
    let mean_square_rate = closed.rate();
    let control_cost = match mean_square_rate < 1.0 {
        true => long_run_cost(&closed, &start.coordinates.express_covariance(process_noise)),
        false => f64::INFINITY,
    };
    OnChannel { knowledge, gains, mean_square_rate, control_cost }
}

/// `sum_j share(j) sum_i p(j,i) tr(K(i) W)` with the cost `K` of keeping the gains for ever.
fn long_run_cost(closed: &ClosedLoop<'_>, process_noise: &DMatrix<f64>) -> f64 {
    let size = closed.size();
    let stage = closed.stage();
    let length = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>().sqrt();
    let scale = length(&stage);
    let Some(cost) = solve_correction(&stage, scale, COST_TOLERANCE, |from, to| closed.apply(from, to))
    else {
        return f64::INFINITY;
    };
    let states = process_noise.nrows();
    let of_mode: Vec<f64> = cost
        .chunks_exact(size * size)
        .map(|cost| {
            let cost = DMatrix::from_column_slice(size, size, cost);
            cost.view((0, 0), (states, states)).component_mul(process_noise).sum()
        })
        .collect();
    // The noise of a step is met by the mode after it; shares are stationary, so that is the share again.
    closed.chain.shares().iter().zip(of_mode).map(|(share, cost)| share * cost).sum()
}
