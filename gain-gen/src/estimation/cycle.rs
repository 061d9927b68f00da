//! Cycles: eigenvalues of one modulus whose ratios are roots of unity, so that their modes come round together.
//!
//! Turned back by a common factor, the modes of a cycle of period `p` repeat every `p` steps of the loop: a measurement with
//! residue `r` (its step modulo `p`) sees them through the block `B_r = [C V_j exp(2 pi i k_j r / p)]`, where `V_j` are the
//! eigenvectors of the j-th eigenvalue and `k_j / p` its angle to the first, in turns. A direction that the `B_r` of all
//! residues that arrive map to zero is not seen by any of them, however many come.

use super::spectrum::Mode;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;

type Matrix = DMatrix<Complex<f64>>;

/// Orders of roots of unity that are looked for. The ratio of two eigenvalues of n x n rational numbers has a degree of at most
/// n (n-1), a root of order m that of Euler's phi(m): 16 states allow no order above 1000.
const HIGHEST_ORDER: usize = 1000;
/// Periods beyond which modes are not joined.
const LONGEST_PERIOD: usize = 10_000;
/// Residues looked at, over all steps of the search for those that may arrive.
const MOST_LOOKS: usize = 20_000;
/// A direction counts as unseen beyond doubt only where rounding is below this part of what is seen of others.
const RESOLVED: f64 = 1e-6;

/// Modes that come round together.
pub(super) struct Cycle {
    /// Each with its angle to the first, in parts of the period.
    pub modes: Vec<(Mode, usize)>,
    /// Period, `p`.
    pub period: usize,
}

/// Bounds on the number of residues that must be lost for some direction to go unseen, `l`. They differ where rounding
/// leaves it open, or there are too many sets of residues to go through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Losses {
    pub least: usize,
    pub most: usize,
}

/// Collects `modes` into cycles. A root of unity of order `m` is recognised if it lies within the uncertainty of the ratio
/// and `m^2` times that is at most `accidental`: about three times the share of all angles that are this close to one.
pub(super) fn cycles(modes: Vec<Mode>, accidental: f64) -> Vec<Cycle> {
    let mut found: Vec<Cycle> = Vec::new();
    for mode in modes {
        let mut joined = Cycle { modes: vec![(mode, 0)], period: 1 };
        let mut apart = Vec::new();
        for cycle in found {
            match cycle.turned(&joined, accidental) {
                Some((place, period)) => joined = cycle.join(joined, place, period),
                None => apart.push(cycle),
            }
        }
        apart.push(joined);
        found = apart;
    }
    found
}

/// `(n, m)` with `b / a = exp(2 pi i n / m)` within what both are uncertain by; `None` if that is no root of unity.
fn turns_between(a: &Mode, b: &Mode, accidental: f64) -> Option<(usize, usize)> {
    let ratio = b.value / a.value;
    let tolerance = a.uncertainty / a.value.norm() + b.uncertainty / b.value.norm();
    let turns = (ratio.arg() / TAU).rem_euclid(1.0);
    let is_near = |order: usize| {
        let nearest = (turns * order as f64).round();
        ((nearest / order as f64 - turns).abs() * TAU <= tolerance)
            .then_some((nearest as usize % order, order))
    };
    let has_equal_modulus = ratio.norm().ln().abs() <= tolerance;
    (1..=HIGHEST_ORDER)
        .find_map(|order| has_equal_modulus.then(|| is_near(order))?)
        .filter(|(_, order)| tolerance * (order * order) as f64 <= accidental)
}

fn least_common_multiple(a: usize, b: usize) -> usize {
    let (mut large, mut small) = (a, b);
    while small > 0 {
        (large, small) = (small, large % small);
    }
    a / large * b
}

impl Cycle {
    /// The angle of the first mode of `other` to the first here, in parts of the common period, and that period.
    fn turned(&self, other: &Self, accidental: f64) -> Option<(usize, usize)> {
        let pairs = self.modes.iter().flat_map(|here| other.modes.iter().map(move |there| (here, there)));
        pairs.into_iter().find_map(|((here, at), (there, from))| {
            let (turns, order) = turns_between(here, there, accidental)?;
            let period = least_common_multiple(least_common_multiple(self.period, other.period), order);
            let place = at * (period / self.period) + turns * (period / order) + period
                - from * (period / other.period);
            (period <= LONGEST_PERIOD).then_some((place % period, period))
        })
    }

    fn join(self, other: Self, place: usize, period: usize) -> Self {
        let (finer, others) = (period / self.period, period / other.period);
        let own = self.modes.into_iter().map(|(mode, at)| (mode, at * finer));
        let more = other.modes.into_iter().map(|(mode, at)| (mode, (place + at * others) % period));
        Self { modes: own.chain(more).collect(), period }
    }

    /// How many residues must be lost for a direction to go unseen, for outputs `c`, ny x nx, that see every mode.
    pub(super) fn losses(&self, c: &DMatrix<f64>) -> Losses {
        let period = self.period;
        let size: usize = self.modes.iter().map(|(mode, _)| mode.vectors.ncols()).sum();
        // As many measurements in a row as directions see them all, so one of these is lost.
        let few = period.div_ceil(size);
        if period == 1 {
            return Losses { least: 1, most: 1 };
        }
        let c = c.map(Complex::from);
        let mut blocks = vec![Matrix::zeros(c.nrows(), size); period];
        let (mut column, mut tolerance) = (0, f64::EPSILON * size as f64);
        for (mode, place) in &self.modes {
            let width = mode.vectors.ncols();
            let parts = (&c * &mode.vectors).svd(true, false);
            let (seen, weakest) = (parts.u.expect("asked for"), parts.singular_values.min());
            tolerance += mode.vector_uncertainty / weakest;
            // Nothing is told apart, or there is no number to tell it by.
            if width > seen.ncols() || tolerance.is_nan() || tolerance >= 1.0 {
                return Losses { least: few, most: period };
            }
            // Coordinates within the mode in which outputs see all its directions alike.
            for (residue, block) in blocks.iter_mut().enumerate() {
                let turns = (place * residue % period) as f64 / period as f64;
                block.columns_mut(column, width).copy_from(&(&seen * Complex::from_polar(1.0, TAU * turns)));
            }
            column += width;
        }
        let mut search = Search { blocks, tolerance, best: 0, looks: 0 };
        let first = search.unseen(0, &Matrix::identity(size, size));
        if first.ncols() > 0 {
            search.descend(0, &first);
        }
        let found = period - search.best;
        Losses {
            least: if search.looks < MOST_LOOKS { found.max(few) } else { few },
            most: if tolerance <= RESOLVED { found.max(few) } else { period },
        }
    }
}

/// The search for the most residues that may arrive while one direction stays unseen.
struct Search {
    blocks: Vec<Matrix>,
    tolerance: f64,
    best: usize,
    looks: usize,
}

impl Search {
    /// Goes through the sets of the residues so far, which leave the directions `unseen`, and others above `last`. By symmetry
    /// the first is 0.
    fn descend(&mut self, last: usize, unseen: &Matrix) {
        let period = self.blocks.len();
        self.looks += period;
        let is_blind: Vec<bool> =
            self.blocks.iter().map(|block| (block * unseen).norm() <= self.tolerance).collect();
        self.best = self.best.max(is_blind.iter().filter(|is_blind| **is_blind).count());
        if unseen.ncols() == 1 {
            return;
        }
        for residue in (last + 1..period).filter(|&residue| !is_blind[residue]) {
            if self.looks >= MOST_LOOKS {
                return;
            }
            let left = self.unseen(residue, unseen);
            if left.ncols() > 0 {
                self.descend(residue, &left);
            }
        }
    }

    /// Orthonormal basis of the directions among `unseen` that measurements of `residue` do not see either.
    fn unseen(&self, residue: usize, unseen: &Matrix) -> Matrix {
        let seen = &self.blocks[residue] * unseen;
        // With at least as many rows as columns all directions come out.
        let (rows, columns) = (seen.nrows().max(seen.ncols()), seen.ncols());
        let parts = seen.resize(rows, columns, Complex::from(0.0)).svd(false, true);
        let blind: Vec<usize> =
            (0..columns).filter(|&at| parts.singular_values[at] <= self.tolerance).collect();
        unseen * parts.v_t.expect("asked for").adjoint().select_columns(&blind)
    }
}
