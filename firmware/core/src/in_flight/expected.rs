//! The input to expect in each coming cycle if nothing newer is sent.
//!
//! What to expect if more is known than what was played last is `newest`'s.

use super::{
    InFlight, Played,
    arrivals::add_newer,
    under_way::{age_of, packet_played},
};
use crate::{DefaultInput, Scalar, actuator::Age, estimator::Modes, gains::Gains};
use heapless::Vec;
use nalgebra::SVector;

impl<T: Scalar, const NU: usize, const N: usize, const H: usize> InFlight<T, NU, N, H> {
    /// `vbar`: the expected input in each of the next `n_v` cycles if nothing sent from now on arrived. THEORY 3, 8.
    pub fn expected_inputs<const NX: usize>(&self, gains: &Gains<'_, T, NX, NU>) -> Vec<SVector<T, NU>, N> {
        match &self.played {
            // A controller's capacity is its gains' length, as a rule: then all lengths are constants to the compiler.
            Played::Known(age, last) if gains.length() == N => match gains.default_input() {
                DefaultInput::Zero => self.expected_after(N, DefaultInput::Zero, *age, *last, gains),
                DefaultInput::Hold => self.expected_after(N, DefaultInput::Hold, *age, *last, gains),
            },
            Played::Known(age, last) => self.expected_mean(&Modes::certain(*age, *last), last, gains),
            Played::Believed { modes, oldest } => self.expected_mean(modes, oldest, gains),
        }
    }

    /// The same where `age` was played in the last cycle, and `last` applied.
    #[inline(always)]
    fn expected_after<const NX: usize>(
        &self,
        length: usize,
        default_input: DefaultInput,
        age: Age,
        last: SVector<T, NU>,
        gains: &Gains<'_, T, NX, NU>,
    ) -> Vec<SVector<T, NU>, N> {
        let played = packet_played(age, length);
        let mut expected = self.left_of(played, length, default_input, last);
        for packet in self.newer_than(played, length, gains) {
            if let Some(inputs) = packet.inputs {
                add_newer(&mut expected, default_input, inputs, packet.arrivals, |_, r| (r, T::one() - r));
            }
        }
        let mut expected = Vec::from(expected);
        expected.truncate(default_input.in_flight(length));
        expected
    }

    /// The mean over every age that may have been played. `oldest` was applied if that was a sequence's last input.
    ///
    /// It is linear in what was played: all ages go through it together, each from where it comes in, where newer packets
    /// may replace it.
    #[inline(never)]
    fn expected_mean<const NX: usize>(
        &self,
        modes: &Modes<T, NU, N>,
        oldest: &SVector<T, NU>,
        gains: &Gains<'_, T, NX, NU>,
    ) -> Vec<SVector<T, NU>, N> {
        let (length, default_input) = (gains.length(), gains.default_input());
        let (empty, last_of_oldest) = (modes.probability(Age::Empty), modes.probability(age_of(length)));
        let last = *modes.held() * empty + *oldest * last_of_oldest;
        let mut expected = Vec::from(self.left_of(length, length, default_input, last));
        expected.truncate(default_input.in_flight(length));
        let mut come_in = empty + last_of_oldest;
        for packet in self.newer_than(length, length, gains) {
            let played = modes.probability(age_of(packet.sent_ago));
            if let Some(inputs) = packet.inputs {
                let share = |_, r| (come_in * r + played, T::one() - r);
                add_newer(&mut expected, default_input, inputs, packet.arrivals, share);
            }
            come_in += played;
        }
        expected
    }

    /// What is expected of the packet sent `played` cycles ago alone, if the actuator played it in the last cycle and applied
    /// `last`.
    pub(super) fn left_of(
        &self,
        played: usize,
        length: usize,
        default_input: DefaultInput,
        last: SVector<T, NU>,
    ) -> [SVector<T, NU>; N] {
        let packet = self.sent.get(played.wrapping_sub(1));
        let left = packet.and_then(|packet| packet.inputs.get(played..length)).unwrap_or_default();
        let mut expected = match default_input {
            DefaultInput::Zero => [SVector::zeros(); N],
            DefaultInput::Hold => [*left.last().unwrap_or(&last); N],
        };
        for (value, input) in expected.iter_mut().zip(left) {
            *value = *input;
        }
        expected
    }
}
