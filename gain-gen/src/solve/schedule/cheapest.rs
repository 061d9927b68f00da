//! Which period costs least: what the loop costs more with rarer packets against what they cost.

use super::super::{LoopProblem, Start};
use super::Schedule;
use crate::design::LONGEST_PERIOD;
use nalgebra::DMatrix;

/// What a schedule costs per cycle in the long run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduleCost {
    /// Cycles from one packet to the next.
    pub period: usize,
    /// With the state known, without packets.
    pub control: f64,
    /// What errors of the estimate add.
    pub estimation: f64,
    /// Packets.
    pub packets: f64,
    /// Factor by which second moments change per cycle, with the state known.
    pub mean_square_rate: f64,
}

impl ScheduleCost {
    /// Of everything together.
    pub fn total(&self) -> f64 {
        self.control + self.estimation + self.packets
    }
}

/// Every schedule that was looked at, and the cheapest.
#[derive(Debug, Clone)]
pub struct Schedules {
    /// Those that are shown to stabilise the loop, by their period.
    pub costs: Vec<ScheduleCost>,
    /// The one that costs least; of several the shortest.
    pub cheapest: Schedule,
}

impl Schedules {
    /// The shortest period whose schedule costs at most `tolerance` times more than the cheapest.
    pub fn shortest_within(&self, tolerance: f64) -> usize {
        let most = (1.0 + tolerance) * self.cheapest_cost().total();
        let found = self.costs.iter().find(|cost| cost.total() <= most);
        found.map_or(self.cheapest.period, |cost| cost.period)
    }

    /// What the cheapest costs.
    ///
    /// # Panics
    /// If `costs` has lost it.
    pub fn cheapest_cost(&self) -> ScheduleCost {
        let is_cheapest = |cost: &&ScheduleCost| cost.period == self.cheapest.period;
        *self.costs.iter().find(is_cheapest).expect("the cheapest is one of them")
    }

    /// For packets of `send_cost` each, a process noise, `nx x nx`, and an error of the estimate with this covariance, `nx x nx`.
    /// `None` if no schedule is shown to stabilise the loop.
    ///
    /// Longer periods are looked at until the loop alone costs more than the cheapest schedule, as many times in a row as a
    /// sequence has inputs.
    pub fn of(
        problem: &LoopProblem,
        send_cost: f64,
        process_noise: &DMatrix<f64>,
        error: &DMatrix<f64>,
    ) -> Option<Self> {
        let mut found: Option<(Self, f64)> = None;
        let mut start = Start::of(problem);
        let mut too_long = 0;
        for period in 1..=LONGEST_PERIOD {
            if too_long > problem.length {
                break;
            }
            too_long += 1;
            let Some(schedule) = Schedule::from_start(start.clone(), period) else { continue };
            // Rarer packets make the state more expensive: units follow.
            start = schedule.start.measured_by_given(&schedule.cost_to_go(period - 1));
            let cost = ScheduleCost {
                period,
                control: schedule.control_cost(process_noise),
                estimation: schedule.error_weight(problem).component_mul(error).sum().max(0.0)
                    / period as f64,
                packets: send_cost / period as f64,
                mean_square_rate: schedule.mean_square_rate,
            };
            match &mut found {
                Some((schedules, least)) => {
                    schedules.costs.push(cost);
                    if cost.control <= *least {
                        too_long = 0;
                    }
                    if cost.total() < *least {
                        (schedules.cheapest, *least) = (schedule, cost.total());
                    }
                }
                None => {
                    found = Some((Self { costs: vec![cost], cheapest: schedule }, cost.total()));
                    too_long = 0;
                }
            }
        }
        found.map(|(schedules, _)| schedules)
    }
}
