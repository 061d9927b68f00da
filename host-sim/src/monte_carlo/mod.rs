//! Many runs in parallel. What they say together is in `summary`.

mod summary;

use crate::{
    adaptation::{Adaptation, RunWindows},
    closed_loop::{self, RunPlan, RunResult, Snapshot},
    contender::Contender,
    fitted::{Fitted, Unfit},
    losses::Losses,
    network::Network,
    size_class::{InSizeClass, TooLarge, dispatch},
};
use gain_gen::design::Design;
use rayon::prelude::*;
use slqg::Scalar;
use std::ops::Range;

pub use summary::{Outcome, Summary, summarise, total_costs};

/// How much to simulate.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Runs per controller.
    pub runs: usize,
    /// Cycles per run.
    pub steps: usize,
    /// Seed; the same seed gives the same numbers.
    pub seed: u64,
}

/// Why a loop cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum CannotSimulate {
    /// It fits no size class.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// Its numbers do not fit its scalar.
    #[error("controller.scalar: {0}; compute in f64")]
    Unfit(#[from] Unfit),
}

/// Simulates one contender in the size class it is dispatched to.
#[derive(Clone, Copy)]
pub struct Simulate<'a> {
    /// The loop.
    pub design: &'a Design,
    /// The controller.
    pub contender: &'a Contender,
    /// How much.
    pub plan: Plan,
    /// Called, from any thread, when a run is done.
    pub done: &'a (dyn Fn() + Sync),
}

/// Simulates some runs of one contender, one after the other, and keeps what each came to.
///
/// The numbers of the runs pick their random numbers, so it does not matter with which others a run is simulated.
#[derive(Debug, Clone)]
pub struct SimulateRuns<'a> {
    /// The loop.
    pub design: &'a Design,
    /// The controller.
    pub contender: &'a Contender,
    /// Cycles per run.
    pub steps: usize,
    /// Seed; the same seed gives the same numbers.
    pub seed: u64,
    /// Numbers of the runs.
    pub runs: Range<u64>,
}

impl InSizeClass for SimulateRuns<'_> {
    type Output = Result<Vec<RunResult>, Unfit>;

    fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Self::Output {
        let Self { design, contender, steps, seed, runs } = self;
        let fitted = Fitted::<T, NX, NU, NY>::new(design, contender);
        fitted.design()?;
        Ok(runs
            .map(|run| closed_loop::run(&fitted, contender, RunPlan { steps, seed, run }, |_| ()))
            .collect())
    }
}

impl Simulate<'_> {
    /// What it came to.
    ///
    /// Compiled here once: in every crate that dispatches by itself, all size classes are compiled again.
    ///
    /// # Errors
    /// If no size class holds the design, or its numbers do not fit its scalar.
    pub fn outcome(self) -> Result<Outcome, CannotSimulate> {
        Ok(dispatch(self.design, self)??)
    }
}

impl InSizeClass for Simulate<'_> {
    type Output = Result<Outcome, Unfit>;

    fn run<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(self) -> Self::Output {
        let Plan { runs, steps, seed } = self.plan;
        let fitted = Fitted::<T, NX, NU, NY>::new(self.design, self.contender);
        fitted.design()?;
        let tracked = self.design.tracking.as_ref().map_or(0, |tracking| tracking.outputs());
        // Collected in the order of the runs, so that sums do not depend on the threads.
        let length = self.contender.laws[0].length;
        let runs: Vec<(RunResult, Vec<u64>, Option<RunWindows>)> = {
            let all = (0..runs as u64).into_par_iter().map(|run| {
                let plan = RunPlan { steps, seed, run };
                let mut ages = vec![0; length + 1];
                let mut windows = RunWindows::new(self.contender, steps);
                let mut cycle = 0;
                let result = closed_loop::run(&fitted, self.contender, plan, |snapshot| {
                    ages[snapshot.age.unwrap_or(length)] += 1;
                    if let Some(windows) = &mut windows {
                        windows.add(cycle, snapshot.stage_cost, snapshot.tuning.as_ref());
                    }
                    cycle += 1;
                });
                (self.done)();
                (result, ages, windows)
            });
            all.collect()
        };
        let results: Vec<RunResult> = runs.iter().map(|(result, ..)| *result).collect();
        let windows: Vec<RunWindows> = runs.iter().filter_map(|(.., windows)| windows.clone()).collect();
        let mut first_run = Vec::with_capacity(steps);
        let keep = |snapshot: Snapshot<'_, T, NX, NU>| {
            let mut cycle = snapshot.to_record();
            cycle.state.truncate(self.design.plant.states());
            cycle.estimate.truncate(self.design.plant.states());
            cycle.deviation.truncate(self.design.plant.states());
            cycle.input.truncate(self.design.plant.inputs());
            cycle.tracked.truncate(tracked);
            first_run.push(cycle);
        };
        let bus = {
            let mut network = Network::new(self.contender, fitted.carrier(), seed, 0);
            closed_loop::run_over(
                &fitted,
                self.contender,
                RunPlan { steps, seed, run: 0 },
                &mut network,
                keep,
            );
            network.into_bus()
        };
        for (cycle, record) in first_run.iter_mut().enumerate() {
            record.learn_fates(bus.as_ref(), cycle);
        }
        let costs: Vec<f64> = results.iter().map(|result| result.cost).collect();
        let priced = total_costs(self.contender, &results);
        let limits = &self.design.controller.input_limits;
        let losses = limits.as_ref().map(|_| Losses::of(&results, steps, self.design.plant.sample_time));
        let summary = summarise(self.contender.kind, length, steps, &results, priced.as_deref());
        Ok(Outcome {
            summary: Summary { adaptation: Adaptation::of(&windows), losses, ..summary },
            total_costs: priced.unwrap_or_else(|| costs.clone()),
            costs,
            ages: (0..=length).map(|age| runs.iter().map(|(_, ages, _)| ages[age]).sum()).collect(),
            first_run,
            bus,
        })
    }
}
