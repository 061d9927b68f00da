//! The expected inputs where no acknowledgement ever comes: their mean over every age, carried on from cycle to cycle.
//!
//! Whether a packet arrives by a cycle does not depend on the packets before it, so what was sent need not be remembered: with
//! `c_m = P(d <= m+1)`,
//!
//! ```text
//! mean input  q(0) U_0 + (1 - q(0)) vbar_0 ;     vbar+_m = c_m U_(m+1) + (1 - c_m) vbar_(m+1)
//! ```

use super::arrivals::add_newer;
use crate::{Scalar, gains::Gains, played::DefaultInput};
use nalgebra::SVector;

/// `vbar`, in input units. THEORY 14.
#[derive(Debug)]
pub struct Mean<'m, T: Scalar, const NU: usize> {
    expected: &'m mut [SVector<T, NU>],
}

impl<'m, T: Scalar, const NU: usize> Mean<'m, T, NU> {
    /// Nothing was sent yet. `room` has room for a sequence.
    pub fn new(room: &'m mut [SVector<T, NU>]) -> Self {
        room.fill(SVector::zeros());
        Self { expected: room }
    }

    /// Nothing was sent yet.
    pub(crate) fn restart(&mut self) {
        self.expected.fill(SVector::zeros());
    }

    /// `vbar`: the mean of the input in each of the next `n_v` cycles if nothing sent from now on arrives.
    pub fn expected<const NX: usize>(&self, gains: &Gains<'_, T, NX, NU>) -> &[SVector<T, NU>] {
        self.expected.get(..gains.in_flight()).unwrap_or_default()
    }

    /// Ends a cycle in which `sent` was sent, as the actuator applies it, or nothing; it arrives at once with the probability
    /// `arrives_at_once`. Returns the mean of the input that is applied in it.
    pub fn push<const NX: usize>(
        &mut self,
        gains: &Gains<'_, T, NX, NU>,
        arrives_at_once: T,
        sent: Option<&[SVector<T, NU>]>,
    ) -> SVector<T, NU> {
        let (holds, missing) = (gains.default_input() == DefaultInput::Hold, T::one() - arrives_at_once);
        let (expected, _) = self.expected.split_at_mut(gains.in_flight().min(self.expected.len()));
        let before = expected.first().copied().unwrap_or_else(SVector::zeros);
        let last = expected.last().copied().filter(|_| holds);
        for place in 1..expected.len() {
            expected.swap(place - 1, place);
        }
        if let Some(place) = expected.last_mut() {
            *place = last.unwrap_or_else(SVector::zeros);
        }
        let Some((first, rest)) = sent.and_then(|inputs| inputs.split_first()) else { return before };
        let mean = first * arrives_at_once + before * missing;
        let arrivals = gains.arrival_table().get(..rest.len()).unwrap_or_default();
        // The table's first row is of a packet that did not arrive at once.
        let share = |_, r: T| {
            let late = missing * (T::one() - r);
            (T::one() - late, late)
        };
        add_newer(expected, gains.default_input(), rest, arrivals, share);
        if let ([held], []) = (expected, rest) {
            // A sequence of one input leaves nothing but what is held of it.
            *held = mean;
        }
        mean
    }
}
