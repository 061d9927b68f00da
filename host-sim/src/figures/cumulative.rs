//! Mean cost per step up to each step, `C_{0..k} / k`, over many runs: thesis Figure 3.10.
//!
//! Gains of lengths that cannot stabilise the loop have no steady state; as in the thesis each length has the time-varying
//! gains of a task that ends with the run.

use super::example;
use crate::{
    closed_loop::{RunPlan, run},
    contender::{Contender, Kind},
    fitted::Fitted,
    output::{
        charts::{Curve, Start, against, in_units},
        columns::{aligned, figure},
    },
    size_class::{InSizeClass, dispatch},
};
use gain_gen::design::{Design, DeviceScalar};
use rayon::prelude::*;
use slqg::Scalar;

/// Cycles per run, as in the thesis.
pub const STEPS: usize = 50;
/// Lengths: 3 is the critical one.
pub const LENGTHS: [usize; 4] = [1, 2, 3, 4];
/// Runs that are added up before they are added to the others: sums do not depend on the threads.
const CHUNK: u64 = 500;

/// Mean of `C_{0..k} / k` for k = 1..=[`STEPS`], by length.
#[derive(Debug, Clone, PartialEq)]
pub struct CostPerStep {
    /// One row of means for each of [`LENGTHS`].
    pub means: Vec<Vec<f64>>,
    /// Runs of each.
    pub runs: u64,
}

struct Cumulative<'a, D> {
    design: &'a Design,
    contender: &'a Contender,
    seed: u64,
    runs: u64,
    done: D,
}

impl<D: Fn() + Sync> InSizeClass for Cumulative<'_, D> {
    type Output = Vec<f64>;

    fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Vec<f64> {
        let fitted = Fitted::<T, NX, NU, NY>::new(self.design, self.contender);
        let chunk = |chunk: u64| {
            let mut sums = vec![0.0; STEPS];
            for number in chunk * CHUNK..((chunk + 1) * CHUNK).min(self.runs) {
                let (mut cost, mut cycle) = (0.0, 0);
                let plan = RunPlan { steps: STEPS, seed: self.seed, run: number };
                run(&fitted, self.contender, plan, |snapshot| {
                    cost += fitted.objective.stage(cycle, snapshot.state, snapshot.input);
                    cycle += 1;
                    sums[cycle - 1] += cost / cycle as f64;
                });
                (self.done)();
            }
            sums
        };
        let chunks: Vec<Vec<f64>> = (0..self.runs.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
        let mut means = vec![0.0; STEPS];
        for sums in chunks {
            means.iter_mut().zip(sums).for_each(|(mean, sum)| *mean += sum / self.runs as f64);
        }
        means
    }
}

/// Simulates all lengths; `done` is called when a run is.
pub fn simulate(runs: u64, seed: u64, done: impl Fn() + Sync) -> CostPerStep {
    let mut design = example!("critical");
    // Costs of a loop that is not stable outgrow single precision.
    design.controller.scalar = DeviceScalar::F64;
    let means = LENGTHS.map(|length| {
        design.set_sequence_length(length);
        let contender = Contender::new(Kind::SlqgTask, &design, STEPS).expect("a task always has gains");
        dispatch(&design, Cumulative { design: &design, contender: &contender, seed, runs, done: &done })
            .expect("two states fit the simulator")
    });
    CostPerStep { means: means.to_vec(), runs }
}

impl CostPerStep {
    /// The means over the steps as SVG, one curve per length.
    pub fn picture(&self) -> String {
        let curves = LENGTHS.iter().zip(&self.means).map(|(length, means)| Curve {
            name: format!("N = {length}"),
            points: (1..).zip(means).map(|(step, mean)| (step, *mean, 0.0)).collect(),
            is_level: false,
        });
        let curves: Vec<Curve> = curves.collect();
        in_units(&against(("step k", 10), "mean cost per step up to k", Start::AtLeast, &curves))
    }

    /// The means as a table, one row per step.
    pub fn table(&self) -> String {
        let header = std::iter::once("k".to_string()).chain(LENGTHS.map(|length| format!("N = {length}")));
        let mut rows = vec![header.collect::<Vec<_>>()];
        rows.extend((0..STEPS).map(|step| {
            let means = self.means.iter().map(|means| figure(Some(means[step])));
            std::iter::once((step + 1).to_string()).chain(means).collect()
        }));
        aligned(&rows, 0)
    }
}
