//! The input to expect in each coming cycle if nothing newer is sent.
//!
//! What to expect if more is known than what was played last is `newest`'s.

use super::{
    InFlight,
    arrivals::add_newer,
    under_way::{age_of, packet_played},
};
use crate::{
    Scalar,
    gains::Gains,
    played::{Age, DefaultInput, Modes, Played},
};
use nalgebra::SVector;

impl<T: Scalar, const NU: usize> InFlight<'_, T, NU> {
    /// `vbar`: the expected input in each of the next `n_v` cycles if nothing sent from now on arrived, after the actuator has
    /// played `played` in the last one. THEORY 3, 8.
    ///
    /// It is written to the beginning of `expected`, and returned; of a shorter `expected` its beginning is.
    pub fn fill_expected<'e, const NX: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        played: &Played<'_, T, NU>,
        expected: &'e mut [SVector<T, NU>],
    ) -> &'e [SVector<T, NU>] {
        let count = gains.in_flight().min(expected.len());
        let (expected, _) = expected.split_at_mut(count);
        match played {
            // A constant for the loops within.
            Played::Known(age, last) => match gains.default_input() {
                DefaultInput::Zero => self.expected_after(DefaultInput::Zero, *age, last, gains, expected),
                DefaultInput::Hold => self.expected_after(DefaultInput::Hold, *age, last, gains, expected),
            },
            Played::Believed { modes, oldest } => self.expected_mean(modes, oldest, gains, expected),
        }
        expected
    }

    /// The same where `age` was played in the last cycle, and `last` applied.
    #[inline(always)]
    fn expected_after<const NX: usize>(
        &self,
        default_input: DefaultInput,
        age: Age,
        last: &SVector<T, NU>,
        gains: &Gains<'_, T, NX, NU>,
        expected: &mut [SVector<T, NU>],
    ) {
        let played = packet_played(age, self.length);
        self.fill_left_of(played, default_input, last, expected);
        for packet in self.newer_than(played, gains) {
            if let Some(inputs) = packet.inputs {
                add_newer(expected, default_input, inputs, packet.arrivals, |_, r| (r, T::one() - r));
            }
        }
    }

    /// The mean over every age that may have been played. `oldest` was applied if that was a sequence's last input.
    ///
    /// It is linear in what was played: all ages go through it together, each from where it comes in, where newer packets
    /// may replace it.
    #[inline(never)]
    fn expected_mean<const NX: usize>(
        &self,
        modes: &Modes<'_, T, NU>,
        oldest: &SVector<T, NU>,
        gains: &Gains<'_, T, NX, NU>,
        expected: &mut [SVector<T, NU>],
    ) {
        let (length, default_input) = (self.length, gains.default_input());
        let (empty, last_of_oldest) = (modes.probability(Age::Empty), modes.probability(age_of(length)));
        let last = modes.held * empty + *oldest * last_of_oldest;
        self.fill_left_of(length, default_input, &last, expected);
        let mut come_in = empty + last_of_oldest;
        for packet in self.newer_than(length, gains) {
            let played = modes.probability(age_of(packet.sent_ago));
            if let Some(inputs) = packet.inputs {
                let share = |_, r| (come_in * r + played, T::one() - r);
                add_newer(expected, default_input, inputs, packet.arrivals, share);
            }
            come_in += played;
        }
    }

    /// Writes what is expected of the packet sent `played` cycles ago alone, if the actuator played it in the last cycle and
    /// applied `last`: `N` inputs.
    #[inline(always)]
    pub(super) fn fill_left_of(
        &self,
        played: usize,
        default_input: DefaultInput,
        last: &SVector<T, NU>,
        expected: &mut [SVector<T, NU>],
    ) {
        let packet = played.checked_sub(1).and_then(|ago| self.sent(ago));
        let left = packet.and_then(|inputs| inputs.get(played..)).unwrap_or_default();
        let after = match default_input {
            DefaultInput::Zero => SVector::zeros(),
            DefaultInput::Hold => *left.last().unwrap_or(last),
        };
        let (begun, rest) = expected.split_at_mut(left.len().min(expected.len()));
        for (value, input) in begun.iter_mut().zip(left) {
            *value = *input;
        }
        rest.fill(after);
    }
}
