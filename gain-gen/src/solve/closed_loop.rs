//! The thesis' loop with given gains: how its second moments evolve, and how fast they shrink.
//!
//! Dense, and for any gains and any transitions of the age: what certificates and margins rest on.

use super::{
    LoopProblem, ModeChain, Start,
    evaluation::solve_like,
    krylov::norm,
    modes::{Mode, modes},
    spectral::{BEYOND, FILTER, NEAR_ONE, RESOLVENT, SPACES, dominant, largest_real_near_one},
    sums::{StateLoop, Sums},
};
use nalgebra::DMatrix;

/// `sum_j p(i, j) parts[j]`, row `i` of the transition matrix.
pub(super) fn expect<'p>(
    transitions: &DMatrix<f64>,
    from: usize,
    parts: impl Iterator<Item = &'p DMatrix<f64>>,
) -> DMatrix<f64> {
    let mut terms = parts.enumerate().map(|(to, part)| (transitions[(from, to)], part));
    let (probability, first) = terms.next().expect("there are at least two modes");
    let mut sum = first * probability;
    for (probability, part) in terms.filter(|&(probability, _)| probability > 0.0) {
        sum.zip_apply(part, |entry, term| *entry += probability * term);
    }
    sum
}

/// Steps that the search for the rate takes in one. A step costs less than making a direction orthogonal to all found
/// before, and several at once leave fewer directions: most are packets that fade within a sequence.
const STRIDE: usize = 16;

/// The loop with one gain per mode of the network: thesis (3.29) with `U = L(j) xi`.
#[derive(Clone, Copy)]
pub(crate) struct ClosedLoop<'a> {
    /// The loop at every age, `N + 1`.
    pub(crate) modes: &'a [Mode],
    /// The modes that there are, and how they follow each other.
    pub(crate) chain: &'a ModeChain,
    /// `L(j)`, `(N nu) x n` each, one for each mode of the chain.
    pub(crate) gains: &'a [DMatrix<f64>],
}

impl ClosedLoop<'_> {
    /// Size of the augmented state, `n`.
    pub(crate) fn size(&self) -> usize {
        self.modes[0].a.nrows()
    }

    /// Expected costs a step earlier: `sum_i p(j,i) (A(i)+B(i)L(j))^T X(i) (A(i)+B(i)L(j))` for every mode `j`, the right
    /// side of thesis (3.36). Symmetric `X(0), X(1), ..` one after the other, `n x n` each.
    ///
    /// Multiplied out, so that products of `n x n` matrices are taken once a mode and not once a pair of modes.
    pub(crate) fn apply(&self, from: &[f64], to: &mut [f64]) {
        to.copy_from_slice(from);
        self.apply_to(to);
    }

    /// The same in place.
    fn apply_to(&self, costs: &mut [f64]) {
        let size = self.size();
        let matrices =
            costs.chunks_exact(size * size).map(|cost| DMatrix::from_column_slice(size, size, cost));
        let ages = self.chain.ages.iter();
        let parts: Vec<_> = ages.zip(matrices).map(|(&age, cost)| self.modes[age].backward(&cost)).collect();
        let transitions = &self.chain.transitions;
        for ((mode, gain), out) in self.gains.iter().enumerate().zip(costs.chunks_exact_mut(size * size)) {
            let state = expect(transitions, mode, parts.iter().map(|part| &part.state));
            let coupling = expect(transitions, mode, parts.iter().map(|part| &part.coupling));
            let sequence = expect(transitions, mode, parts.iter().map(|part| &part.sequence));
            let half = state * 0.5 + (coupling + gain.tr_mul(&(sequence * 0.5))) * gain;
            out.copy_from_slice((&half + half.transpose()).as_slice());
        }
    }

    /// Expected cost of one step from each mode: `sum_i p(j,i) (Q(i) + L(j)^T R(i) L(j))`, laid out as for
    /// [`ClosedLoop::apply`].
    pub(crate) fn stage(&self) -> Vec<f64> {
        let of_ages = || self.chain.ages.iter().map(|&age| &self.modes[age]);
        let stages = self.gains.iter().enumerate().flat_map(|(mode, gain)| {
            let state = expect(&self.chain.transitions, mode, of_ages().map(|mode| &mode.q));
            let sequence = expect(&self.chain.transitions, mode, of_ages().map(|mode| &mode.r));
            let stage = state + gain.tr_mul(&(sequence * gain));
            stage.as_slice().to_vec()
        });
        stages.collect()
    }

    /// Spectral radius of [`ClosedLoop::apply`]: the mean-square rate, below 1 iff the loop is mean-square stable.
    pub(crate) fn rate(&self) -> f64 {
        let one = DMatrix::<f64>::identity(self.size(), self.size()).as_slice().repeat(self.gains.len());
        let found = dominant(&one, FILTER, [STRIDE; SPACES], |costs| self.apply_to(costs));
        if found.is_clear() {
            return found.radius;
        }
        // Many eigenvalues are about as large. The rate is the one that is real and nearest to a number beyond them all.
        let growth = if found.radius < NEAR_ONE { BEYOND * found.radius } else { 1.0 };
        let sums = self.alike().discounted(growth);
        let nearest = largest_real_near_one(&one, |residual| {
            let alike = |costs: &mut [f64]| self.spread(&sums, costs);
            solve_like(residual, norm(residual), RESOLVENT, alike, |costs| {
                self.apply_to(costs);
                costs.iter_mut().for_each(|entry| *entry /= growth);
            })
        });
        nearest.map_or(found.radius, |nearest| growth * nearest)
    }

    /// The loop of the state alone, with the first input of a sequence applied at once.
    fn alike(&self) -> StateLoop {
        let plant = &self.modes[0];
        let (states, inputs) = plant.plant;
        let gain = self.gains[0].view((0, 0), (inputs, states));
        StateLoop::of(plant.a.view((0, 0), (states, states)) + plant.b.view((0, 0), (states, inputs)) * gain)
    }

    /// Makes of `costs` about those whose step takes them off: what the state's part comes to, the same for every mode.
    fn spread(&self, alike: &Option<Sums>, costs: &mut [f64]) {
        let (size, (states, _)) = (self.size(), self.modes[0].plant);
        let Some(sums) = alike else { return };
        let mut mean = DMatrix::<f64>::zeros(states, states);
        for (share, stage) in self.chain.shares().iter().zip(costs.chunks_exact(size * size)) {
            let stage = DMatrix::from_column_slice(size, size, stage);
            mean += stage.view((0, 0), (states, states)) * *share;
        }
        let more = sums.total(mean.clone()) - mean;
        for cost in costs.chunks_exact_mut(size * size) {
            for column in 0..states {
                for row in 0..states {
                    cost[column * size + row] += more[(row, column)];
                }
            }
        }
    }
}

/// Mean-square rate of the problem's plant and link with the gains `L(j)`, `j = 0..=N`, of [`super::Solution::mode_gains`].
///
/// The gains need not be made for this problem: that is how margins are found. Dense, so slow for long sequences.
///
/// # Panics
/// If the gains do not have the problem's dimensions.
pub fn mean_square_rate(problem: &LoopProblem, gains: &[DMatrix<f64>]) -> f64 {
    let start = Start::of(problem);
    let gains: Vec<_> = gains.iter().map(|gain| start.coordinates.express_gain(gain)).collect();
    let chain = ModeChain::independent(&problem.link, problem.length);
    ClosedLoop { modes: &modes(&start.problem), chain: &chain, gains: &gains }.rate()
}
