//! The rows of an experiment that are missing, simulated in parallel and handed on in the order of the file.

use super::{experiment::Experiment, layout::Chunk, row::Entry};
use crate::{
    contender::Contender,
    monte_carlo::{CannotSimulate, SimulateRuns, total_costs},
    size_class::dispatch,
};
use gain_gen::design::Design;
use rayon::prelude::*;
use std::{collections::BTreeMap, sync::mpsc, thread};

/// A case with what simulating it takes.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The loop.
    pub design: Design,
    /// The controller.
    pub contender: Contender,
}

impl Prepared {
    /// Says no before anything is simulated.
    ///
    /// # Errors
    /// The case cannot be simulated.
    pub fn check(&self) -> Result<(), CannotSimulate> {
        // There, stacks have room for the largest class.
        self.simulate(1, 0, 0..0).map(drop)
    }

    fn simulate(
        &self,
        steps: usize,
        seed: u64,
        runs: std::ops::Range<u64>,
    ) -> Result<Vec<Entry>, CannotSimulate> {
        let Self { design, contender } = self;
        let results = dispatch(design, SimulateRuns { design, contender, steps, seed, runs })??;
        let priced = total_costs(contender, &results);
        let entry =
            |(number, &result)| Entry { result, total_cost: priced.as_ref().map(|costs| costs[number]) };
        Ok(results.iter().enumerate().map(entry).collect())
    }
}

/// Simulates what is missing after `done` rows. `keep` gets every chunk, in the order of the file: the case, the number of
/// the first run, and the entries. The first error of `keep` ends the simulation.
///
/// # Errors
/// Those of `keep`.
///
/// # Panics
/// If a case fails its [`Prepared::check`].
pub fn simulate<E>(
    experiment: &Experiment,
    prepared: &[Prepared],
    done: usize,
    mut keep: impl FnMut(usize, u64, Vec<Entry>) -> Result<(), E>,
) -> Result<(), E> {
    let (send, received) = mpsc::channel();
    let one = move |(number, chunk): (usize, Chunk)| {
        let entries = prepared[chunk.case]
            .simulate(experiment.steps, experiment.seed, chunk.runs.clone())
            .expect("checked before");
        // Nobody listens any more: there is nothing to simulate for.
        send.send((number, chunk, entries)).ok()
    };
    thread::scope(|scope| {
        scope.spawn(move || {
            // In the order of the file, near enough: little is lost when the process ends.
            let chunks = experiment.chunks_after(done).enumerate().par_bridge();
            chunks.try_for_each(one)
        });
        let mut early = BTreeMap::new();
        let mut next = 0;
        for (number, chunk, entries) in received {
            early.insert(number, (chunk, entries));
            while let Some((chunk, entries)) = early.remove(&next) {
                keep(chunk.case, chunk.runs.start, entries)?;
                next += 1;
            }
        }
        Ok(())
    })
}
