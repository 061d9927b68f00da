//! Input limits on a plant with an integrator: whether the loop is shown to stay bounded although its inputs are.
//!
//! Let one mode of the plant have the eigenvalue 1 and all others decay, `v` and `w` its right and left eigenvectors, `w'v = 1`.
//! Then `z = w'x` moves by `w'B u` and noise, and all else in the state stays bounded. While `z` is large every new sequence is
//! `z g + M vbar` but for terms that stay bounded, with `g = Lx v`, and `z` changes slowly, as inputs are limited. Of the
//! sequences, which are remembered without the limits, entries then come to lie within intervals times `z`. If
//! those of every entry that may be applied have the sign that takes `z` back, for every input that moves `z` at all, each
//! input at its limit takes `z` back by as much in every cycle in which the buffer is not empty. By this drift (Hajek 1982)
//! `E exp(k |z|)` stays bounded for some small `k`, and so do all moments. See docs/theory.md.
//!
//! That the eigenvalue is exactly 1 is decided without rounding, modulo large primes.

mod exact;

use crate::design::{Acknowledgement, Behaviour, Design, modes};
use crate::solve::Law;
use crate::units::Units;
use exact::{has_eigenvalue_one, is_singular};
use nalgebra::{DMatrix, DVector};
use slqg::DefaultInput;

/// Rounds in which the intervals must settle.
const ROUNDS: usize = 2000;
/// Part of its size by which an interval has to keep clear of zero, and that an input which moves nothing may have by rounding.
const CLEAR: f64 = 1e-6;

/// Why it is not shown that limits leave the loop bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotShown {
    /// More than one mode, or not the eigenvalue 1.
    #[error("it is shown for a plant only of which one mode is an integrator and all others decay")]
    Modes,
    /// The eigenvalue is 1 within rounding only.
    #[error(
        "the largest eigenvalue is 1 within rounding only, and beyond 1 inputs with limits would not be enough"
    )]
    NotExact,
    /// Not the loop that the argument is for.
    #[error(
        "it is shown only for instant acknowledgements and independent packets that are sent in every cycle"
    )]
    Network,
    /// Inputs take time to get where they push back.
    #[error("inputs that may change so much in a cycle only push the wrong way for a while")]
    Rates,
    /// Measurements and inputs have a range.
    #[error("values that are counted have a range, beyond which the filter sees nothing")]
    Counted,
    /// An input may not take the mode back.
    #[error("some input can be at a limit that does not take the integrator back")]
    PushesAway,
    /// Sequences may not take the mode back.
    #[error("sequences that lie at a limit for long may come to push the wrong way")]
    Sequences,
}

/// Shows that the loop with `law` stays bounded in the mean square within the design's input limits, for a plant on the limit of
/// stability.
///
/// # Errors
/// It is not shown. That does not mean that it does not.
pub(crate) fn pushed_back(design: &Design, law: &Law) -> Result<(), NotShown> {
    let (network, settings) = (&design.network, &design.controller);
    let links = [&network.controller_to_actuator, &network.sensor_to_controller];
    let is_plain = network.acknowledgement == Acknowledgement::Instant
        && design.event.is_none()
        && links.into_iter().all(|link| link.behaviour == Behaviour::Independent);
    if !is_plain {
        return Err(NotShown::Network);
    }
    if settings.input_rates.is_some() {
        return Err(NotShown::Rates);
    }
    if design.wire.counts_values() {
        return Err(NotShown::Counted);
    }
    let found = modes::modes(&design.plant.a).ok_or(NotShown::Modes)?;
    let lasting: Vec<_> = found.into_iter().filter(|mode| mode.growth != modes::Growth::Decays).collect();
    let [mode] = lasting.as_slice() else { return Err(NotShown::Modes) };
    if mode.growth != modes::Growth::OnTheLimit || (mode.value.re - 1.0).abs() > CLEAR {
        return Err(NotShown::Modes);
    }
    let is_exact = match &design.plant.continuous {
        Some((a, _)) => is_singular(a),
        None => has_eigenvalue_one(&design.plant.a),
    };
    if !is_exact {
        return Err(NotShown::NotExact);
    }
    let units = Units::of(&design.plant);
    let (plant, law) = (units.plant(&design.plant), units.law(&law.rounded_to(settings.scalar)));
    let (left, right) = eigenvectors(&plant.a).ok_or(NotShown::Modes)?;
    let limits = settings.input_limits.as_ref().expect("asked for designs with limits");
    let moves = away(&plant.b, &left, limits)?;
    let entries = entries(&law, &(&law.lx * right)).ok_or(NotShown::Sequences)?;
    let inputs = moves.len();
    let link = &network.controller_to_actuator.delays;
    let mut none_newer = 1.0;
    for m in 0..law.length {
        let is_applied = link.arrival(m) > 0.0 && none_newer > 0.0;
        none_newer *= 1.0 - link.arrival(m);
        for (input, &moves) in moves.iter().enumerate().filter(|&(_, &moves)| is_applied && moves != 0.0) {
            let (least, greatest) = entries[m * inputs + input];
            let clear = CLEAR * least.abs().max(greatest.abs());
            let takes_back = if moves > 0.0 { greatest < -clear } else { least > clear };
            if !takes_back {
                return Err(NotShown::Sequences);
            }
        }
    }
    Ok(())
}

/// The left and the right eigenvector of the eigenvalue 1, `w'v = 1`.
fn eigenvectors(a: &DMatrix<f64>) -> Option<(DVector<f64>, DVector<f64>)> {
    let size = a.nrows();
    let parts = (a - DMatrix::identity(size, size)).svd(true, true);
    let least = parts.singular_values.imin();
    let left = parts.u?.column(least).clone_owned();
    let right = parts.v_t?.row(least).transpose();
    let along = left.dot(&right);
    (along.abs() > f64::EPSILON.sqrt() * CLEAR).then(|| (left / along, right))
}

/// By how much each input moves the mode; 0 for those that do not.
fn away(b: &DMatrix<f64>, left: &DVector<f64>, limits: &[(f64, f64)]) -> Result<Vec<f64>, NotShown> {
    let of_input = |(column, &(least, greatest)): (usize, &(f64, f64))| {
        let terms = || b.column(column).iter().zip(left.iter()).map(|(b, w)| b * w).collect::<Vec<_>>();
        let moves: f64 = terms().iter().sum();
        let size: f64 = terms().iter().map(|term| term.abs()).sum();
        let moves = if moves.abs() > CLEAR * size { moves } else { 0.0 };
        match moves == 0.0 || (least < 0.0 && 0.0 < greatest) {
            true => Ok(moves),
            false => Err(NotShown::PushesAway),
        }
    };
    let moves = limits.iter().enumerate().map(of_input).collect::<Result<Vec<f64>, _>>()?;
    if moves.iter().all(|&moves| moves == 0.0) { Err(NotShown::PushesAway) } else { Ok(moves) }
}

/// Intervals in which the entries of sequences come to lie for a mode of size 1, `gain` its part in them; `None`: they do not settle.
fn entries(law: &Law, gain: &DVector<f64>) -> Option<Vec<(f64, f64)>> {
    let inputs = law.inputs();
    let (length, in_flight) = (law.length, law.default_input.in_flight(law.length));
    let last = |at: usize| match law.default_input {
        DefaultInput::Zero => at,
        DefaultInput::Hold => at.min(length - 1),
    };
    let mut found: Vec<(f64, f64)> = vec![(0.0, 0.0); gain.len()];
    for _ in 0..ROUNDS {
        // What is expected in cycle j: entries of earlier sequences from j + 1 on, or an input within the limits, which is none beside a
        // large mode.
        let expected: Vec<(f64, f64)> = (0..in_flight * inputs)
            .map(|at| {
                let (first, input) = (last(at / inputs + 1), at % inputs);
                let entries = (first..length).map(|m| found[m * inputs + input]);
                entries.fold((0.0, 0.0), |hull, entry| (entry.0.min(hull.0), entry.1.max(hull.1)))
            })
            .collect();
        let of_row = |row: usize| {
            expected.iter().enumerate().fold((gain[row], gain[row]), |sum, (column, hull)| {
                let (one, other) = (law.m[(row, column)] * hull.0, law.m[(row, column)] * hull.1);
                (sum.0 + one.min(other), sum.1 + one.max(other))
            })
        };
        let next: Vec<(f64, f64)> = (0..gain.len()).map(of_row).collect();
        let size = next.iter().map(|entry| entry.0.abs().max(entry.1.abs())).fold(0.0, f64::max);
        let moved = next
            .iter()
            .zip(&found)
            .map(|(next, found)| (next.0 - found.0).abs().max((next.1 - found.1).abs()));
        let settled = moved.fold(0.0, f64::max) <= 1e-3 * CLEAR * size;
        found = next;
        if settled {
            return Some(found);
        }
        if size.is_nan() || size > 1e100 {
            return None;
        }
    }
    None
}
