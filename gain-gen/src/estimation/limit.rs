//! The least arrival probability of measurements for which the expected error covariance stays bounded, exactly.
//!
//! Park and Sahai (2011): with independent losses the covariance stays bounded if, for every cycle of eigenvalues (see
//! `cycle`) of modulus `|lambda| > 1` and period `p` which is no longer seen once `l` residues modulo `p` are lost, at least,
//!
//! ```text
//! (1 - q)^(l/p) |lambda|^2 < 1,       so  q > 1 - |lambda|^(-2 p/l)
//! ```
//!
//! and grows without bound if one of these is above 1 (THEORY 10). An
//! eigenvalue on its own has `p = l = 1`, which is the bound of Theorem 3.4 a).
//!
//! **Rounding.** Eigenvalues are known within some uncertainty. Once everything that may be a coincidence within rounding
//! counts as one, and once only what is one to the last digits: the limit lies between what comes out.

use super::coordinates::Coordinates;
use super::cycle::{Cycle, Losses, cycles};
use super::spectrum::{Mode, lasting_modes};
use crate::design::{
    Plant,
    modes::{Growth, modes, spoken},
};
use core::fmt::{self, Display, Formatter};
use nalgebra::{Complex, DMatrix};

/// Rounding of entries per state, in units of the last digit: coincidences to this count as meant.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Beyond this many times `ROUNDING` nothing coincides.
const DOUBT: f64 = 1e3;
/// Share of all angles that may pass for roots of unity by accident where coincidences are to be beyond doubt.
const ACCIDENTAL: f64 = 1e-6;
/// Limits below this are those of modes that do not grow but for rounding.
const NEGLIGIBLE: f64 = 1e-6;
/// Rounding of a probability.
const LAST_DIGITS: f64 = 8.0 * f64::EPSILON;

/// The least arrival probability for which the error stays bounded, and what decides it.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrivalLimit {
    /// Below this probability the expected error covariance grows without bound, whatever it starts from but for zero.
    pub lower: f64,
    /// Above it stays bounded. Further from `lower` than by rounding only where coincidences are in doubt.
    pub upper: f64,
    /// The modes that decide; `None` if none grows.
    pub cycle: Option<DecidingCycle>,
}

/// Modes of one modulus that come round together.
#[derive(Debug, Clone, PartialEq)]
pub struct DecidingCycle {
    /// Their eigenvalues; of a conjugate pair that does not come round one only.
    pub eigenvalues: Vec<Complex<f64>>,
    /// `p`: after so many steps all have turned by the same angle.
    pub period: usize,
    /// `l`: of `p` measurements in a row so many must be lost, always the same ones, for some direction to go unseen.
    pub losses: usize,
}

/// `0 ± 1.2i, unseen where the same 1 of 2 measurements is always lost`.
impl Display for DecidingCycle {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mut modes: Vec<String> = self.eigenvalues.iter().copied().map(spoken).collect();
        modes.sort();
        modes.dedup();
        write!(f, "{}, unseen ", modes.join(", "))?;
        match (self.losses, self.period) {
            (losses, period) if losses == period => f.write_str("while all measurements are lost"),
            (1, period) => write!(f, "where the same 1 of {period} measurements is always lost"),
            (losses, period) => write!(f, "where the same {losses} of {period} measurements are always lost"),
        }
    }
}

/// The limit for a plant whose outputs see every mode that does not decay. `None`: all modes decay, no measurement is needed.
pub fn arrival_limit(plant: &Plant) -> Option<ArrivalLimit> {
    let growths: Vec<Growth> = modes(&plant.a).into_iter().flatten().map(|mode| mode.growth).collect();
    if !growths.contains(&Growth::Grows) && growths.len() == plant.a.nrows() {
        let is_lasting = growths.contains(&Growth::OnTheLimit);
        return is_lasting.then_some(ArrivalLimit { lower: 0.0, upper: 0.0, cycle: None });
    }
    let balanced = Coordinates::of(plant);
    let rounding = ROUNDING * plant.a.nrows() as f64;
    let lasting = |rounding| lasting_modes(&balanced.a, rounding);
    let (Some(meant), Some(possible)) = (lasting(rounding), lasting(rounding * DOUBT)) else {
        return Some(ArrivalLimit { lower: 0.0, upper: 1.0, cycle: None });
    };
    let least = |mode: &Mode| mode.value.norm() - mode.uncertainty;
    let (lower, _) = greatest(cycles(meant, ACCIDENTAL), &balanced.c, least, |losses| losses.most);
    let largest = |mode: &Mode| mode.largest + mode.uncertainty;
    let (upper, cycle) =
        greatest(cycles(possible, f64::INFINITY), &balanced.c, largest, |losses| losses.least);
    let (lower, upper) = ((lower - LAST_DIGITS).max(0.0), (upper + LAST_DIGITS).min(1.0));
    Some(ArrivalLimit { lower, upper, cycle: cycle.filter(|_| upper > NEGLIGIBLE) })
}

/// The greatest limit of all `cycles`, with the given modulus of their modes and number of losses, and the cycle it is of.
fn greatest(
    cycles: Vec<Cycle>,
    c: &DMatrix<f64>,
    modulus: impl Fn(&Mode) -> f64,
    losses: impl Fn(Losses) -> usize,
) -> (f64, Option<DecidingCycle>) {
    let mut greatest = (0.0, None);
    for cycle in cycles {
        let modulus = cycle.modes.iter().map(|(mode, _)| modulus(mode)).fold(0.0, f64::max);
        if modulus <= 1.0 {
            continue;
        }
        let (period, losses) = (cycle.period, losses(cycle.losses(c)));
        let limit = 1.0 - modulus.powf(-2.0 * period as f64 / losses as f64);
        if limit > greatest.0 {
            let eigenvalues = cycle.modes.iter().map(|(mode, _)| mode.value).collect();
            greatest = (limit, Some(DecidingCycle { eigenvalues, period, losses }));
        }
    }
    greatest
}
