//! A packet in every p-th cycle: the law that is optimal for that, and what it costs. THEORY 15.
//!
//! A cycle in which nothing is sent is one over a link on which nothing arrives, so the core's own recursion takes both kinds of
//! steps: one that sends, then `p - 1` that do not. It converges to `p` costs-to-go, one for each number of cycles to the next
//! packet, and to the gains of the cycles that send.
//!
//! | file | what lives there |
//! |---|---|
//! | `recursion` | a period as one step, with its rate and its exact cost for given gains |
//! | `cheapest` | which period costs least once packets have a price |
//! | `base` | which of them a design asks for |
//! | `tables` | what a packet is worth if later ones follow the schedule |

mod base;
mod cheapest;
mod recursion;
mod tables;

use super::{
    Law, LoopProblem, Outcome, Start,
    flat::{Flat, row_major},
    iterate::{Recursion, iterate},
};
use crate::design::DeviceScalar;
use nalgebra::DMatrix;
use recursion::{Periodic, Workspaces};

pub use base::{NotScheduled, Scheduled, scheduled};
pub use cheapest::{ScheduleCost, Schedules};
pub use tables::ScheduledTrigger;

/// A packet in every p-th cycle.
#[derive(Debug, Clone)]
pub struct Schedule {
    /// Cycles from one packet to the next, `p`.
    pub period: usize,
    /// The law of the cycles that send.
    pub law: Law,
    /// Factor by which second moments change per cycle, with the state known: the p-th root of that of a period.
    pub mean_square_rate: f64,
    /// Relative residual of the fixed-point equation over a period.
    pub residual: f64,
    /// `(P, S, Y, N_t)` as the core lays them out, by cycles to the next packet, `0..p`; in the design's units.
    pub(super) values: Vec<Vec<f64>>,
    /// The problem it was solved from.
    start: Start,
}

/// The schedule with a packet in every `period`-th cycle, at least 1; `None` unless it is shown to stabilise the loop.
///
/// # Panics
/// If `period` is zero.
pub fn schedule(problem: &LoopProblem, period: usize) -> Option<Schedule> {
    assert!(period > 0, "a packet in every cycle is the most there is");
    Schedule::from_start(Start::of(problem), period)
}

impl Schedule {
    /// From a problem made ready, in whose units it is solved.
    fn from_start(start: Start, period: usize) -> Option<Self> {
        let flat = Flat::new(&start.problem);
        let mut workspaces = Workspaces::new(&start.problem, &flat.dimensions);
        let mut recursion = Periodic::new(&flat, &mut workspaces, period);
        recursion.begin(start.begun.as_ref().unwrap_or(start.cost_to_go()));
        let ending = iterate(&mut recursion, start.cost_scale(), start.runs_dry());
        if ending.outcome != Outcome::Converged {
            return None;
        }
        let mut values = recursion.values();
        let law = Law::from_gains(&start.problem, &recursion.gains(), start.problem.arrival_table());
        values.iter_mut().for_each(|value| start.coordinates.restore_value(value, &flat.dimensions));
        Some(Self {
            period,
            law: start.coordinates.restore_law(&law),
            mean_square_rate: ending.mean_square_rate.powf((period as f64).recip()),
            residual: ending.residual,
            values,
            start,
        })
    }

    /// Mean-square rate per cycle with the law's numbers rounded to `scalar`, as they are emitted; `r` is exact.
    pub fn emitted_rate(&self, scalar: DeviceScalar) -> f64 {
        if scalar == DeviceScalar::F64 {
            return self.mean_square_rate;
        }
        let law = self.start.coordinates.express_law(&self.law.rounded_to(scalar));
        let flat = Flat::new(&self.start.problem);
        let mut workspaces = Workspaces::new(&self.start.problem, &flat.dimensions);
        let mut recursion = Periodic::new(&flat, &mut workspaces, self.period);
        recursion.set_gains(&law.by_rows());
        recursion.rate().powf((self.period as f64).recip())
    }

    /// `P` with `ahead` cycles to go to the next packet, `0..p`, `nx x nx`: the cost-to-go of the state when nothing is in flight.
    ///
    /// # Panics
    /// If `ahead` is not below the period.
    pub fn cost_to_go(&self, ahead: usize) -> DMatrix<f64> {
        let states = self.law.lx.ncols();
        DMatrix::from_row_slice(states, states, &self.values[ahead][..states * states])
    }

    /// Long-run average cost per cycle if the state is known, without that of packets: the mean of `tr(P W)` over the period.
    pub fn control_cost(&self, process_noise: &DMatrix<f64>) -> f64 {
        let noise = row_major(process_noise);
        let of_noise = |value: &Vec<f64>| noise.iter().zip(value).map(|(w, p)| w * p).sum::<f64>();
        self.values.iter().map(of_noise).sum::<f64>() / self.period as f64
    }

    /// `Pi = Q + A' P A - P`, `nx x nx`, over a cycle that sends: what a squared error of the estimate costs whenever a packet is
    /// made from it, once a period. In the cycles between nothing is made of the estimate.
    pub fn error_weight(&self, problem: &LoopProblem) -> DMatrix<f64> {
        let (a, after) = (&problem.a, self.cost_to_go(self.period - 1));
        &problem.q + a.transpose() * after * a - self.cost_to_go(0)
    }
}
