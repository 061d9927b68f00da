//! Loops without acknowledgements: the linear law of least exact cost, with covariances that no data change. THEORY 14.
//!
//! | file | what lives there |
//! |---|---|
//! | `loop_data` | the loop's data in the coordinates it is solved in |
//! | `sent` | what a packet does, whenever it arrives |
//! | `jump` | the loop over one cycle, for every law |
//! | `closed` | the same with one law |
//! | `steady` | its steady state and exact cost |
//! | `descent` | the law that makes the cost least |
//! | `certainty` | a law that is nearly the best, to begin with |
//! | `homotopy` | a law that stabilises, where that one does not |

mod certainty;
mod closed;
mod descent;
mod homotopy;
mod jump;
mod loop_data;
mod sent;
mod steady;

use super::{Coordinates, Law, LoopProblem, Method, Solution, Start, settled_cost, solve};
use crate::design::{DelayDistribution, Design, DeviceScalar, Plant};
use certainty::certain;
use descent::descend;
use homotopy::stabilising;
use jump::Jump;
use loop_data::LoopData;
use nalgebra::DMatrix;
use slqg::{DefaultInput, estimator::Merging};
use steady::Steady;

/// Longest sequences for which a law is looked for that the design does not ask for.
pub(crate) const LONGEST_TRIED: usize = 12;
/// Times that law and filter are found, each for the other. What is left then is a filter that is told a little less or more than it
/// should be, in a loop whose cost is exact all the same.
const ROUNDS: usize = 24;
/// Change of the input's covariance between two of them that counts as none.
const SAME: f64 = 1e-8;
/// Part of its distance from 1 by which the rate may grow where the cost falls.
const SLOWER: f64 = 0.1;
/// Decrease of the logarithm of the cost, per step, that counts as none; and where a law is only to be near the best.
const SETTLED: f64 = 1e-11;
const NEARLY_SETTLED: f64 = 1e-5;

/// The law for a loop without acknowledgements, and what is known of the loop with it.
#[derive(Debug, Clone)]
pub struct Unacknowledged {
    /// `U = Lx xhat + M vbar`, where `vbar` is the mean over all ages.
    pub law: Law,
    /// Gain of the filter, `nx x ny`, once measurements come one after the other.
    pub filter_gain: DMatrix<f64>,
    /// Covariance of the input about its mean, `nu x nu`: what the filter is told.
    pub input_covariance: DMatrix<f64>,
    /// Average cost of a cycle in the long run: exact, if measurements come as [`Unacknowledged::hears`] says.
    pub cost: f64,
    /// Factor by which second moments change per cycle.
    pub rate: f64,
    /// The same with the numbers that are emitted.
    pub emitted_rate: f64,
    /// Probability that the controller knows the newest measurement, and all before: such that the newest one known is as old, in
    /// the mean, as over the sensor's link; 1 where no law is found for that.
    pub hears: f64,
    /// Factor by which second moments change with measurements as late, in the mean, as over the sensor's link, where no law is found
    /// for such.
    pub late_rate: Option<f64>,
    /// Whether the cost and the rate are those of the loop as it runs: all measurements come at once.
    pub is_exact: bool,
    /// Whether the cost is the least that a law in `vbar` has with this filter, up to rounding; otherwise it is close to that.
    pub is_least: bool,
}

impl Unacknowledged {
    /// Process noise as the filter is told it, `W + B Sigma B'`, `nx x nx`.
    pub fn filter_noise(&self, plant: &Plant) -> DMatrix<f64> {
        &plant.process_noise + &plant.b * &self.input_covariance * plant.b.transpose()
    }

    /// Average cost of a cycle with another law and the same filter; `None` if second moments grow.
    pub fn cost_with(&self, design: &Design, law: &Law) -> Option<f64> {
        let problem = LoopProblem::of(design);
        let coordinates = &Start::of(&problem).coordinates;
        let data = data(design, &problem, coordinates);
        let jump = Jump::new(&data, &coordinates.express_filter_gain(&self.filter_gain));
        Some(jump.steady(&joined(&coordinates.express_law(law)), None)?.cost)
    }
}

/// The law of a loop whose estimator is the linear one; `None` for others, and as [`unacknowledged`].
pub(crate) fn if_linear(
    design: &Design,
    problem: &LoopProblem,
    acknowledged: &Solution,
) -> Option<Unacknowledged> {
    match design.estimator() {
        Merging::Linear => unacknowledged(design, problem, acknowledged),
        Merging::Single | Merging::Imm | Merging::Gpb2 => None,
    }
}

/// Finds the law, starting from the one with acknowledgements; `None` if no stabilising one is found.
pub fn unacknowledged(
    design: &Design,
    problem: &LoopProblem,
    acknowledged: &Solution,
) -> Option<Unacknowledged> {
    if !acknowledged.is_stabilising() {
        // Who knows less does no better.
        return None;
    }
    let coordinates = &acknowledged.start.coordinates;
    let settings = &design.controller;
    let mut data = data(design, problem, coordinates);
    let as_late = data.hears;
    let is_exact = as_late >= 1.0;
    let first = stable(&mut data, acknowledged)?;
    let first_rate = rate(&data, &first);
    // Where the descent does not come to an end, what it was to improve stays.
    let best = settle(&data, Some(&first), |jump, law| {
        let found = descend(jump, law?, None, SETTLED)?;
        (found.promised <= SETTLED).then_some((found.law, found.steady))
    });
    // What no noise of the design reaches costs nothing, and must decay all the same.
    let best = best.map(|best| (rate(&data, &best), best));
    let best = best.filter(|(rate, _)| *rate <= first_rate + SLOWER * (1.0 - first_rate));
    let is_least = best.is_some();
    let (rate, Settled { law, steady, gain, covariance }) = best.unwrap_or((first_rate, first));
    let late_rate = (data.hears > as_late).then(|| {
        let late = LoopData { hears: as_late, ..data.clone() };
        Jump::new(&late, &gain).rate(&law)
    });
    let jump = Jump::new(&data, &gain);
    let law = coordinates.restore_law(&apart(&law, problem, &acknowledged.law.arrival));
    let emitted_rate = match settings.scalar {
        DeviceScalar::F64 => rate,
        DeviceScalar::F32 => jump.rate(&joined(&coordinates.express_law(&law.rounded_to(DeviceScalar::F32)))),
    };
    Some(Unacknowledged {
        input_covariance: coordinates.restore_input_covariance(&covariance),
        filter_gain: coordinates.restore_filter_gain(&gain),
        law,
        cost: steady.cost,
        rate,
        emitted_rate,
        hears: data.hears,
        late_rate,
        is_exact,
        is_least,
    })
}

/// A law close to the best for a loop without acknowledgements, starting from the one with instant ones; `None` as [`unacknowledged`].
/// It depends on nothing but the problem, where laws of least cost are many.
pub(super) fn law_for_none(design: &Design, problem: &LoopProblem, acknowledged: &Solution) -> Option<Law> {
    let coordinates = &acknowledged.start.coordinates;
    let mut data = data(design, problem, coordinates);
    let found = as_heard(&mut data, nearly_best)?;
    Some(coordinates.restore_law(&apart(&found.law, problem, &acknowledged.law.arrival)))
}

/// A law with which second moments stay bounded, close to the best where the Riccati equation has it.
fn stable(data: &mut LoopData, acknowledged: &Solution) -> Option<Settled> {
    as_heard(data, |data| nearly_best(data).or_else(|| led_to(data, acknowledged)))
}

/// What is `found` for measurements as they come, and otherwise for measurements that come at once: what those that come together are late
/// by is more than what these are, and so is what is asked of the law.
fn as_heard(data: &mut LoopData, found: impl Fn(&LoopData) -> Option<Settled>) -> Option<Settled> {
    let first = found(data);
    if first.is_some() || data.hears >= 1.0 {
        return first;
    }
    data.hears = 1.0;
    found(data)
}

/// The solution of the Riccati equation, with the filter that goes with it.
fn nearly_best(data: &LoopData) -> Option<Settled> {
    settle(data, None, certain).filter(|found| rate(data, found) < 1.0)
}

/// A law that the descent leads to from the one for known ages, through loops that are discounted.
fn led_to(data: &LoopData, acknowledged: &Solution) -> Option<Settled> {
    let start = joined(&acknowledged.start.coordinates.express_law(&acknowledged.law));
    let (law, covariance) = stabilising(data, start)?;
    let gain = filter_gain(data, &covariance);
    let steady = Jump::new(data, &gain).steady(&law, None)?;
    let led = Settled { law, steady, gain, covariance };
    let better = settle(data, Some(&led), |jump, law| {
        let found = descend(jump, law?, None, NEARLY_SETTLED)?;
        Some((found.law, found.steady))
    });
    Some(better.filter(|better| rate(data, better) < 1.0).unwrap_or(led))
}

/// Factor by which second moments change per cycle.
fn rate(data: &LoopData, settled: &Settled) -> f64 {
    Jump::new(data, &settled.gain).rate(&settled.law)
}

fn data(design: &Design, problem: &LoopProblem, coordinates: &Coordinates) -> LoopData {
    let (plant, buffer) = (&design.plant, design.controller.measurement_buffer);
    LoopData {
        problem: coordinates.express(problem),
        c: coordinates.express_output(&plant.c),
        process_noise: coordinates.express_covariance(&plant.process_noise),
        measurement_noise: plant.measurement_noise.clone(),
        hears: share_known(&design.network.sensor_to_controller.delays, buffer),
    }
}

/// The shortest sequences, longer than the design's, for which a law is found.
pub(crate) fn shortest_unacknowledged(design: &Design) -> Option<usize> {
    let problem = LoopProblem::of(design);
    (problem.length + 1..=LONGEST_TRIED).find(|&length| {
        let longer = problem.with_length(length);
        let acknowledged = solve(&longer, Method::InFlight);
        let coordinates = &acknowledged.start.coordinates;
        acknowledged.is_stabilising()
            && stable(&mut data(design, &longer, coordinates), &acknowledged).is_some()
    })
}

/// A law and the filter that it goes with.
struct Settled {
    law: DMatrix<f64>,
    steady: Steady,
    gain: DMatrix<f64>,
    covariance: DMatrix<f64>,
}

/// A law for the filter that is told how its inputs vary, found by `improved`: each for the other, in turn.
fn settle(
    data: &LoopData,
    start: Option<&Settled>,
    improved: impl Fn(&Jump<'_>, Option<&DMatrix<f64>>) -> Option<(DMatrix<f64>, Steady)>,
) -> Option<Settled> {
    let inputs = data.problem.b.ncols();
    let mut covariance =
        start.map_or_else(|| DMatrix::zeros(inputs, inputs), |start| start.covariance.clone());
    let mut law = start.map(|start| start.law.clone());
    for round in 1..=ROUNDS {
        let gain = filter_gain(data, &covariance);
        let jump = Jump::new(data, &gain);
        let (found, steady) = improved(&jump, law.as_ref())?;
        let now = jump.closed(&found).input_covariance(&steady.moments);
        let is_same = (&now - &covariance).norm() <= SAME * now.norm();
        if is_same || round == ROUNDS {
            return Some(Settled { law: found, steady, gain, covariance });
        }
        (covariance, law) = (now, Some(found));
    }
    None
}

/// `[Lx M]`.
fn joined(law: &Law) -> DMatrix<f64> {
    let (states, flight) = (law.lx.ncols(), law.m.ncols());
    let mut joined = DMatrix::zeros(law.lx.nrows(), states + flight);
    joined.columns_mut(0, states).copy_from(&law.lx);
    joined.columns_mut(states, flight).copy_from(&law.m);
    joined
}

fn apart(joined: &DMatrix<f64>, problem: &LoopProblem, arrival: &[f64]) -> Law {
    let states = problem.a.nrows();
    Law {
        length: problem.length,
        default_input: problem.default_input,
        lx: joined.columns(0, states).into_owned(),
        m: joined.columns(states, joined.ncols() - states).into_owned(),
        arrival: arrival.to_vec(),
    }
}

/// Gain of the steady-state Kalman filter that is told the mean of the input and `covariance` about it, `nx x ny`.
fn filter_gain(data: &LoopData, covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let (b, c) = (&data.problem.b, &data.c);
    let mirrored = LoopProblem {
        a: data.problem.a.transpose(),
        b: c.transpose(),
        q: &data.process_noise + b * covariance * b.transpose(),
        r: data.measurement_noise.clone(),
        link: DelayDistribution::new(vec![1.0]).expect("1 is a probability"),
        length: 1,
        default_input: DefaultInput::Zero,
    };
    let prior = settled_cost(&mirrored);
    let seen = c * &prior;
    let innovation = &seen * c.transpose() + &data.measurement_noise;
    innovation.cholesky().map_or_else(
        || DMatrix::zeros(c.ncols(), c.nrows()),
        |innovation| innovation.solve(&seen).transpose(),
    )
}

/// Probability that the newest of what is sent over `link` is known, if it and all before come together, with the mean age that the
/// newest one known has over it. What is later than `buffer` cycles does not count.
pub(super) fn share_known(link: &DelayDistribution, buffer: usize) -> f64 {
    let last = link.largest_delay().min(buffer);
    let mut none_newer = 1.0;
    let mut age = 0.0;
    for delay in 0..=last {
        none_newer *= 1.0 - link.arrival(delay);
        age += none_newer;
    }
    let arrival = link.arrival(last);
    // Older ones come with the same probability each.
    let rest = if arrival > 0.0 { none_newer * (1.0 - arrival) / arrival } else { f64::INFINITY };
    1.0 / (1.0 + age + rest)
}
