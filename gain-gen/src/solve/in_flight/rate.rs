//! The mean-square rate of a law: how much the map of THEORY 5 stretches what it stretches most.

use super::super::{
    Law, LoopProblem, NetworkFree, Start,
    evaluation::solve_like,
    flat::Flat,
    krylov::norm,
    radius::radius,
    spectral::{BEYOND, NEAR_ONE, RESOLVENT, dominant, largest_real_near_one},
    sums::Sums,
};
use super::{InFlightRecursion, recursion};
use crate::extended::widened;
use nalgebra::DMatrix;
use slqg::{DefaultInput, synthesis::Dimensions};

/// Most steps that the search for the rate takes in one.
const LONGEST_STRIDE: usize = 16;
/// Part of `x^T x` in what lasts without a network: every mode of the plant shows in it.
const SEED: f64 = 1e-3;
/// Plain applications before the rate is looked for: cheaper than a basis vector each, and what decays fast needs none.
const FILTER: usize = 8;
/// Part of what lasts without a network in the direction from which the rate is looked for, beside one that is known to be
/// forgotten last: what this one misses is found to the digits of the rate less these.
const BESIDE: f64 = 1e-4;
/// Squarings after which a loop's power shows what lasts: 2^6 cycles.
const SQUARINGS: usize = 6;

impl InFlightRecursion<'_, '_> {
    /// The mean-square rate with the gains at hand; keeps the cost-to-go that is forgotten last.
    pub(super) fn find_rate(&mut self) -> f64 {
        let Dimensions { states, length, default_input, .. } = self.problem.dimensions;
        if self.synthesis.gains().iter().all(|gain| *gain == 0.0) && default_input == DefaultInput::Zero {
            // Nothing is ever applied.
            return radius(&widened(&DMatrix::from_row_slice(states, states, self.problem.a))).powi(2);
        }
        let stride = (length / 4).clamp(1, LONGEST_STRIDE);
        // Inside the cone of costs, where the rate is an eigenvalue: near what lasts without a network, and near what lasted
        // longest so far.
        let mut start = vec![0.0; self.problem.dimensions.value_len()];
        start[..states * states].copy_from_slice(self.lasting.as_slice());
        if let Some(slowest) = self.slowest.take().or_else(|| self.moved()) {
            start.iter_mut().zip(slowest).for_each(|(start, slowest)| *start = BESIDE * *start + slowest);
        }
        let found = self.with_map(|map, _| dominant(&start, FILTER, [1, stride, stride], map));
        let rate = if found.is_clear() { found.radius } else { self.rate_near_one(&start, found.radius) };
        self.slowest = Some(found.direction);
        rate
    }

    /// The rate where many eigenvalues are about as large as `found`: the one that is real and nearest to a number beyond them
    /// all.
    fn rate_near_one(&mut self, start: &[f64], found: f64) -> f64 {
        let states = self.problem.dimensions.states;
        let growth = if found < NEAR_ONE { BEYOND * found } else { 1.0 };
        let sums = self.free.as_ref().and_then(|free| free.discounted(growth));
        let nearest = largest_real_near_one(start, |residual| {
            self.with_map(|map, _| {
                let alike = |value: &mut [f64]| alike(&sums, states, value);
                solve_like(residual, norm(residual), RESOLVENT, alike, |value| {
                    map(value);
                    value.iter_mut().for_each(|entry| *entry /= growth);
                })
            })
        });
        nearest.map_or(found, |nearest| growth * nearest)
    }

    /// How the cost-to-go has changed since it was remembered, scaled to length 1; `None` if it has not.
    fn moved(&self) -> Option<Vec<f64>> {
        let mut moved = self.synthesis.value().to_vec();
        let remembered = self.remembered.as_ref()?;
        moved.iter_mut().zip(remembered).for_each(|(now, before)| *now -= before);
        let length = norm(&moved);
        (length > 0.0 && length.is_finite()).then(|| moved.iter().map(|entry| entry / length).collect())
    }
}

/// Makes of `value` about the cost-to-go whose step takes it off, by the costs of a loop that is alike.
pub(super) fn alike(sums: &Option<Sums>, states: usize, value: &mut [f64]) {
    if let Some(sums) = sums {
        sums.add_to(states, value);
    }
}

/// `x^T x` some cycles later without a network, scaled, and a little of what it is now.
pub(super) fn lasting(problem: &LoopProblem, free: Option<&NetworkFree>) -> DMatrix<f64> {
    let one = DMatrix::identity(problem.a.nrows(), problem.a.nrows());
    let Some(free) = free else { return one };
    let mut power = &problem.a + &problem.b * &free.gain;
    for _ in 0..SQUARINGS {
        power = &power * &power;
        let size = power.amax();
        if size == 0.0 || !size.is_finite() {
            return one;
        }
        power /= size;
    }
    let later = power.tr_mul(&power);
    &later / later.amax() + one * SEED
}

/// Mean-square rate of a law like the one that `start` was solved for, made with the link's own arrival probabilities, both in the
/// design's units. THEORY 5. `cost` is about its cost-to-go, `nx x nx`, and `slowest` the whole one that it forgets last.
pub(in super::super) fn rate_of(
    start: &Start,
    law: &Law,
    cost: &DMatrix<f64>,
    slowest: Option<&Vec<f64>>,
) -> f64 {
    let start = start.measured_by_given(cost);
    let law = start.coordinates.express_law(law);
    let flat = Flat::new(&start.problem);
    let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
    let mut recursion = recursion(&start, &flat, &mut workspace);
    recursion.synthesis.set_gains(&law.by_rows());
    recursion.slowest = slowest.map(|slowest| {
        let mut slowest = slowest.clone();
        start.coordinates.express_value(&mut slowest, &flat.dimensions);
        let length = norm(&slowest);
        slowest.iter_mut().for_each(|entry| *entry /= length);
        slowest
    });
    recursion.find_rate()
}
