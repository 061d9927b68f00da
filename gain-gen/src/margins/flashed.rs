//! Margins of the loop as flashed: gains, table and filter as designed, outputs measured.
//!
//! **Links.** While the plant is the model, the error of the estimate depends on the measurements that arrive and on noise,
//! not on what was applied: acknowledgements are instant, so that is known. The loop is then stable if and only if the
//! loop whose state is known is and the error's covariance stays bounded, and each link has a margin of its own: the one
//! to the actuator that of the loop with its state known, the one from the sensor up to `q_crit`.
//!
//! **Plant.** Around another plant the error of the estimate is driven by the state and by what is applied, and the rate is
//! that of both together, `loop_rate`. Where the sensor's link has one delay and loses nothing it is exact. Otherwise it is
//! one of a chain that tells apart as many uncertain arrivals as the refinement says, doubled in states until the margin
//! does not move; by how much it still moved is told with it.

use super::arrivals::Arrivals;
use super::change::{Change, Dynamics, continuous_plant, entries};
use super::loop_rate::LoopAsRun;
use super::search::{WIDTH, boundary, boundary_near, is_stable};
use super::state_known::StateKnown;
use crate::design::{Acknowledgement, Behaviour, Design, Plant};
use crate::estimation::arrival_limit;
use crate::solve::{LoopProblem, Solution};
use crate::units::Units;
use rayon::prelude::*;
use std::cell::RefCell;

/// Largest distance from 1 at which a factor on an entry, or on `B` upwards, is tried.
pub const LARGEST_FACTOR: f64 = 100.0;
/// Largest factor on the sample time that is tried, and the inverse of the least.
pub const LARGEST_SAMPLE_TIME: f64 = 10.0;
/// First distance from 1 that is tried.
const FIRST: f64 = 0.03;
/// Factor between the distances tried.
const FURTHER: f64 = 1.4;
/// Uncertain arrivals told apart: at first, and more in each refinement.
const ARRIVALS: (usize, usize) = (2, 2);
/// A margin that moves less than this part of its distance from 1 in a refinement is not refined further.
const SETTLED: f64 = 1e-3;
/// Width to which a margin is narrowed where the rate is an estimate.
const ESTIMATED_WIDTH: f64 = 3e-5;
/// Multiplications in one step of the rate's search at most; a refinement that takes more is not done.
const MOST_WORK: usize = 3_000_000;
/// The same over all entries of the plant together, for the first chain.
const MOST_ENTRIES: usize = 6_000_000;

/// The largest share that is not all.
const ALL_BUT_ONE: f64 = 1.0 - f64::EPSILON / 2.0;
/// Difference between bounds on a probability that is rounding.
const SAME_LIMIT: f64 = 1e-6;

/// Why there are no margins of the flashed loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotGiven {
    /// Not every age is known in time.
    #[error(
        "acknowledgements are not instant, so what the filter knows of the inputs applied depends on the inputs themselves"
    )]
    Acknowledgement,
    /// The law is one for a loop without acknowledgements.
    #[error("they are not known of a law that is made for a loop without acknowledgements")]
    Unacknowledged,
    /// Packets are not sent in every cycle.
    #[error("with an event trigger what is sent depends on the estimate")]
    EventTrigger,
    /// Packets do not meet their delays independently.
    #[error(
        "packets on the links are not independent of each other, which these figures would take them for"
    )]
    Dependent,
    /// The estimate of the rate does not show the stability that there is.
    #[error("the loop is too close to its limits to be told from an unstable one")]
    Unresolved,
    /// One step takes too long.
    #[error("the loop is too large")]
    TooLarge,
}

/// What the packets of one link bear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkMargins {
    /// Fraction of the packets that would count which may be lost in addition; 1 if all may.
    pub extra_loss: f64,
    /// Steps by which every packet may come later than designed; `None` if it does not matter whether any comes.
    pub extra_delay: Option<usize>,
}

/// Factors between which the loop is stable, from the design's on. `None`: as far as was tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Below 1.
    pub least: Option<f64>,
    /// Above 1.
    pub greatest: Option<f64>,
}

/// What one factor of the plant may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlantMargin {
    /// Of what.
    pub change: Change,
    /// With the filter.
    pub flashed: Bounds,
    /// With the state known.
    pub state_known: Bounds,
}

/// Margins of the loop with its estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct Flashed {
    /// Of the link to the actuator.
    pub control: LinkMargins,
    /// Of the link from the sensor; at least these where [`Flashed::measurement_limit_is_exact`] is false.
    pub measurements: LinkMargins,
    /// Whether the limit on arrivals is known exactly, and not only bounded from above.
    pub measurement_limit_is_exact: bool,
    /// Of `B`.
    pub input_gain: PlantMargin,
    /// Of the sample time; `None` if no continuous plant is behind the discrete one.
    pub sample_time: Option<PlantMargin>,
    /// Of every entry of `a` and `b` that is not zero; `None` if there are too many to try.
    pub entries: Option<Vec<PlantMargin>>,
    /// How far the plant's margins moved in the last refinement at most, as a part of their distance from 1; `None`: they
    /// are exact.
    pub accuracy: Option<f64>,
}

/// The margins of a design whose loop is stable, as `state_known` shows of the link to the actuator.
///
/// # Errors
/// They are not known.
pub fn flashed(design: &Design, solution: &Solution, state_known: &StateKnown) -> Result<Flashed, NotGiven> {
    check(design)?;
    let search = Search::new(design, solution)?;
    let mut changes = vec![Change::InputGain];
    if continuous_plant(&design.plant).is_some() {
        changes.push(Change::SampleTime);
    }
    let fixed = changes.len();
    let of_plant = entries(&design.plant);
    let told = of_plant.len().saturating_mul(search.chains[0].work()) <= MOST_ENTRIES;
    if told {
        changes.extend(of_plant);
    }
    let found: Vec<(PlantMargin, f64)> = changes.par_iter().map(|&change| search.margin(change)).collect();
    let margins: Vec<PlantMargin> = found.iter().map(|(margin, _)| *margin).collect();
    let moved = found.iter().map(|(_, moved)| *moved).fold(0.0, f64::max);
    let (measurements, measurement_limit_is_exact) = measurements(design);
    Ok(Flashed {
        control: LinkMargins { extra_loss: state_known.extra_loss, extra_delay: state_known.extra_delay },
        measurements,
        measurement_limit_is_exact,
        input_gain: margins[0],
        sample_time: (fixed > 1).then(|| margins[1]),
        entries: told.then(|| margins[fixed..].to_vec()),
        accuracy: (!search.is_exact).then_some(moved),
    })
}

/// What one factor of a design's plant may be, as in [`flashed`].
///
/// # Errors
/// It is not known.
///
/// # Panics
/// If the sample time changes of a plant that is no sampled one.
pub fn plant_margin(design: &Design, solution: &Solution, change: Change) -> Result<PlantMargin, NotGiven> {
    check(design)?;
    Ok(Search::new(design, solution)?.margin(change).0)
}

/// Whether the loop is one that these figures are for.
fn check(design: &Design) -> Result<(), NotGiven> {
    let network = &design.network;
    if network.acknowledgement != Acknowledgement::Instant {
        return Err(NotGiven::Acknowledgement);
    }
    if design.event.is_some() {
        return Err(NotGiven::EventTrigger);
    }
    let links = [&network.controller_to_actuator, &network.sensor_to_controller];
    if links.iter().any(|link| link.behaviour != Behaviour::Independent) {
        return Err(NotGiven::Dependent);
    }
    Ok(())
}

/// What the sensor's link bears, and whether not more.
fn measurements(design: &Design) -> (LinkMargins, bool) {
    let (plant, link) = (&design.plant, &design.network.sensor_to_controller.delays);
    let buffer = design.controller.measurement_buffer;
    let Some(limit) = arrival_limit(plant) else {
        return (LinkMargins { extra_loss: 1.0, extra_delay: None }, true);
    };
    let arrives = |late: usize| buffer.checked_sub(late).map_or(0.0, |left| link.arrival(left));
    // Some must arrive, however few.
    let extra_loss = (1.0 - limit.upper / arrives(0)).clamp(0.0, ALL_BUT_ONE);
    let extra_delay =
        (1..=buffer + 1).find(|&late| arrives(late) <= limit.upper).map_or(buffer, |late| late - 1);
    let is_exact = limit.upper - limit.lower <= SAME_LIMIT;
    (LinkMargins { extra_loss, extra_delay: Some(extra_delay) }, is_exact)
}

/// The loops in which margins of the plant are looked for.
struct Search {
    state_known: LoopAsRun,
    /// From the coarsest to the finest in which the loop is stable as designed.
    chains: Vec<LoopAsRun>,
    is_exact: bool,
}

/// Which way a factor leads away from 1.
#[derive(Clone, Copy)]
enum Way {
    Down,
    Up,
}

impl Search {
    fn new(design: &Design, solution: &Solution) -> Result<Self, NotGiven> {
        let units = Units::of(&design.plant);
        let (plant, law) = (units.plant(&design.plant), units.law(&solution.law));
        let survival = LoopProblem::of(design).survival();
        let link = &design.network.sensor_to_controller.delays;
        let mut chains = Vec::new();
        let mut is_exact = false;
        let mut uncertain = ARRIVALS.0;
        while !is_exact {
            let arrivals = Arrivals::new(link, design.controller.measurement_buffer, uncertain);
            let chain = LoopAsRun::with_filter(&plant, &law, &survival, &arrivals);
            if chain.work() > MOST_WORK {
                break;
            }
            is_exact = arrivals.is_exact;
            chains.push(chain);
            uncertain += ARRIVALS.1;
        }
        if chains.is_empty() {
            return Err(NotGiven::TooLarge);
        }
        chains.retain(|chain| is_stable(chain.rate(Change::InputGain, 1.0)));
        if chains.is_empty() {
            return Err(NotGiven::Unresolved);
        }
        Ok(Self { state_known: LoopAsRun::state_known(&plant, &law, &survival), chains, is_exact })
    }

    /// The margin, and how far it moved in the last refinement.
    fn margin(&self, change: Change) -> (PlantMargin, f64) {
        let down = Along::new(self.state_known.designed(), change, Way::Down);
        let up = Along::new(self.state_known.designed(), change, Way::Up);
        let known = |along: &Along<'_>| walked(&self.state_known, along, WIDTH).map(|at| along.factor(at));
        let state_known = Bounds { least: known(&down), greatest: known(&up) };
        let down = self.refined(&down);
        let up = self.refined(&up);
        let moved = down.1.max(up.1);
        let margin = PlantMargin {
            change,
            flashed: Bounds {
                least: down.0.map(|at| factor(change, Way::Down, at)),
                greatest: up.0.map(|at| factor(change, Way::Up, at)),
            },
            state_known,
        };
        (margin, moved)
    }

    /// The distance along the way, from chain to chain, and how far it moved in the end as a part of itself.
    fn refined(&self, along: &Along<'_>) -> (Option<f64>, f64) {
        let is_exact = self.is_exact && self.chains.len() == 1;
        let width = if is_exact { WIDTH } else { ESTIMATED_WIDTH };
        let mut at = walked(&self.chains[0], along, width);
        let mut moved = 0.0;
        for chain in &self.chains[1..] {
            let guess = at.unwrap_or(along.end);
            let next = boundary_near(guess, along.end, width, |at| along.rate(chain, at));
            moved = (next.unwrap_or(along.end) - guess).abs() / guess;
            at = next;
            if moved <= SETTLED {
                break;
            }
        }
        (at, moved)
    }
}

/// The plants along a way from the design's. Several loops are asked about the same ones.
struct Along<'p> {
    plant: &'p Plant,
    change: Change,
    way: Way,
    /// The distance at which the way ends.
    end: f64,
    /// Those of the steps in which boundaries are looked for first, as far as anybody has got.
    steps: RefCell<Vec<(f64, Option<Dynamics>)>>,
}

impl<'p> Along<'p> {
    fn new(plant: &'p Plant, change: Change, way: Way) -> Self {
        Self { plant, change, way, end: furthest(change, way), steps: RefCell::default() }
    }

    fn factor(&self, at: f64) -> f64 {
        factor(self.change, self.way, at)
    }

    /// The rate of a loop around the plant at this distance.
    fn rate(&self, around: &LoopAsRun, at: f64) -> f64 {
        if let Some((_, plant)) = self.steps.borrow().iter().find(|(step, _)| *step == at) {
            return around.rate_around(plant.as_ref());
        }
        around.rate(self.change, self.factor(at))
    }

    /// The distance of the step after the one at `at`.
    fn next(&self, at: f64) -> f64 {
        let next = if at == 0.0 { FIRST } else { (at * FURTHER).min(self.end) };
        let mut steps = self.steps.borrow_mut();
        if steps.last().is_none_or(|&(last, _)| last < next) {
            steps.push((next, self.change.plant(self.plant, self.factor(next))));
        }
        next
    }
}

/// The factor at a distance along the way.
fn factor(change: Change, way: Way, at: f64) -> f64 {
    match (change, way) {
        (Change::SampleTime, Way::Down) => (-at).exp(),
        (Change::SampleTime, Way::Up) => at.exp(),
        (_, Way::Down) => 1.0 - at,
        (_, Way::Up) => 1.0 + at,
    }
}

/// The distance at which a way ends.
fn furthest(change: Change, way: Way) -> f64 {
    match (change, way) {
        (Change::SampleTime, _) => LARGEST_SAMPLE_TIME.ln(),
        // Inputs with the wrong sign are no wrong gain.
        (Change::InputGain, Way::Down) => 1.0,
        (_, _) => LARGEST_FACTOR,
    }
}

/// The nearest boundary along the way, found step by step; `None` if there is none to its end.
fn walked(around: &LoopAsRun, along: &Along<'_>, width: f64) -> Option<f64> {
    let nominal = around.rate(along.change, 1.0);
    let rate = |at: f64| along.rate(around, at);
    let at = boundary(0.0, nominal, |at| along.next(at), along.end, width, rate);
    (at < along.end).then_some(at)
}
