//! The expected inputs where no acknowledgement ever comes: their mean over every age, carried on from cycle to cycle.
//!
//! Whether a packet arrives by a cycle does not depend on the packets before it, so what was sent need not be remembered: with
//! `c_m = P(d <= m+1)`,
//!
//! ```text
//! mean input  q(0) U_0 + (1 - q(0)) vbar_0 ;     vbar+_m = c_m U_(m+1) + (1 - c_m) vbar_(m+1)
//! ```
//!
//! `vbar` stands behind the ring, in `N` more of its inputs. THEORY 14.

use super::{InFlight, arrivals::add_newer};
use crate::{Scalar, gains::Gains, played::DefaultInput};
use nalgebra::SVector;

impl<T: Scalar, const NU: usize> InFlight<'_, T, NU> {
    /// Begins the mean: nothing was sent yet.
    pub fn begin_mean(&mut self) {
        if let Some((_, mean)) = self.inputs.split_at_mut_checked(self.sent.len() * self.length) {
            mean.fill(SVector::zeros());
        }
    }

    /// `vbar`: the mean of the input in each of the next `n_v` cycles if nothing sent from now on arrives, in input units.
    ///
    /// It is written to the beginning of `expected`, and returned; of a shorter `expected`, or where the ring was lent no more
    /// than it takes itself, its beginning is.
    pub fn fill_mean<'e, const NX: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        expected: &'e mut [SVector<T, NU>],
    ) -> &'e [SVector<T, NU>] {
        let mean = self.inputs.get(self.sent.len() * self.length..).unwrap_or_default();
        let (expected, _) = expected.split_at_mut(gains.in_flight().min(expected.len()).min(mean.len()));
        for (place, value) in expected.iter_mut().zip(mean) {
            *place = *value;
        }
        expected
    }

    /// [`InFlight::push`] that carries the mean on: the candidate, as the actuator applies it, was sent or was not, and arrives
    /// at once with the probability `arrives_at_once`. Returns the mean of the input that is applied in the cycle that ends.
    pub fn push_mean<const NX: usize>(
        &mut self,
        gains: &Gains<'_, T, NX, NU>,
        arrives_at_once: T,
        is_sent: bool,
    ) -> SVector<T, NU> {
        let candidate = self.after_newest() * self.length;
        let (ring, mean) =
            self.inputs.split_at_mut_checked(self.sent.len() * self.length).unwrap_or_default();
        let sent = ring.get(candidate..).and_then(|rest| rest.get(..self.length)).filter(|_| is_sent);
        let applied = carry_on(mean, gains, arrives_at_once, sent);
        self.push(is_sent);
        applied
    }
}

/// Makes of `vbar` that of the next cycle; returns the mean of the input that is applied in this one.
fn carry_on<T: Scalar, const NX: usize, const NU: usize>(
    mean: &mut [SVector<T, NU>],
    gains: &Gains<'_, T, NX, NU>,
    arrives_at_once: T,
    sent: Option<&[SVector<T, NU>]>,
) -> SVector<T, NU> {
    let (holds, missing) = (gains.default_input() == DefaultInput::Hold, T::one() - arrives_at_once);
    let (expected, _) = mean.split_at_mut(gains.in_flight().min(mean.len()));
    let before = expected.first().copied().unwrap_or_else(SVector::zeros);
    let last = expected.last().copied().filter(|_| holds);
    // Moved by swaps: a move of a whole slice brings a function of its own into flash.
    for place in 1..expected.len() {
        expected.swap(place - 1, place);
    }
    if let Some(place) = expected.last_mut() {
        *place = last.unwrap_or_else(SVector::zeros);
    }
    let Some((first, rest)) = sent.and_then(|inputs| inputs.split_first()) else { return before };
    let applied = first * arrives_at_once + before * missing;
    let arrivals = gains.arrival_table().get(..rest.len()).unwrap_or_default();
    // The table's first row is of a packet that did not arrive at once.
    let share = |_, r: T| {
        let late = missing * (T::one() - r);
        (T::one() - late, late)
    };
    add_newer(expected, gains.default_input(), rest, arrivals, share);
    if let ([held], []) = (expected, rest) {
        // A sequence of one input leaves nothing but what is held of it.
        *held = applied;
    }
    applied
}
