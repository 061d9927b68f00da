//! What a design's trigger takes later packets to follow, where that is not a packet in every cycle.

use super::super::LoopProblem;
use super::{Schedule, ScheduledTrigger, Schedules, schedule};
use crate::design::{Base, Design, Rule};
use nalgebra::DMatrix;

/// Part that a schedule to count on may cost more than the cheapest. The cheapest is near the rarest packets that keep the loop
/// together: seen from there every error is dear, and the trigger sends in haste. A little shorter ones serve better; this much was found on the
/// pendulum, at three prices and with ten lengths (`docs/evaluation.md`).
const TOLERANCE: f64 = 0.15;

/// A schedule that a loop runs on, or that its trigger counts on.
#[derive(Debug, Clone)]
pub struct Scheduled {
    /// The schedule, with the law of the loop.
    pub schedule: Schedule,
    /// What decides between its packets; `None` where the clock alone does.
    pub trigger: Option<ScheduledTrigger>,
}

/// No law with a packet in every `period`-th cycle was shown to stabilise the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotScheduled {
    /// Cycles between packets; `None`: with no period.
    pub period: Option<usize>,
}

/// That of the design, whose estimate has an error of the covariance `error`, `nx x nx`. `None` where later packets are taken to be
/// sent in every cycle, and where the design sends always.
///
/// # Errors
/// There is none.
pub fn scheduled(
    design: &Design,
    problem: &LoopProblem,
    error: &DMatrix<f64>,
) -> Result<Option<Scheduled>, NotScheduled> {
    let Some(event) = design.event.filter(|event| event.may_pause()) else { return Ok(None) };
    let noise = &design.plant.process_noise;
    let schedule = match event.base {
        Base::Every(period) => schedule(problem, period).ok_or(NotScheduled { period: Some(period) })?,
        Base::Auto => {
            let found = Schedules::of(problem, event.send_cost, noise, error);
            let found = found.ok_or(NotScheduled { period: None })?;
            match event.rule {
                Rule::Schedule => found.cheapest,
                Rule::Worth => {
                    let period = found.shortest_within(TOLERANCE);
                    schedule(problem, period).ok_or(NotScheduled { period: Some(period) })?
                }
            }
        }
    };
    if event.rule == Rule::Worth && schedule.period == 1 {
        return Ok(None);
    }
    let trigger = (event.rule == Rule::Worth).then(|| schedule.trigger(problem, noise, error));
    Ok(Some(Scheduled { schedule, trigger }))
}
