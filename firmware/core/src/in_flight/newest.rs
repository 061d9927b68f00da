//! The input to expect given which packet is the newest that has arrived by a later cycle: what an event trigger asks for.

use super::{InFlight, Played, arrivals::add_newer, under_way::packet_played};
use crate::{Scalar, actuator::Age, gains::Gains};
use heapless::Vec;
use nalgebra::SVector;

impl<T: Scalar, const NU: usize, const N: usize, const H: usize> InFlight<T, NU, N, H> {
    /// Calls `each` with every sequence that may turn out to be the newest that has arrived by cycle `k+told`: its
    /// probability, and the expected inputs given that it is, one for each of the next `n_v` cycles. THEORY 7.
    ///
    /// It is one that may have been played in the last cycle, or one sent after it; nothing is known of when it arrived. The
    /// expected inputs mean something from cycle `k+told` on; those before are what the sequence holds for them, played or
    /// not.
    pub fn for_each_newest<const NX: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        told: usize,
        mut each: impl FnMut(T, &[SVector<T, NU>]),
    ) {
        match &self.played {
            Played::Known(age, last) => self.for_each_arrived(gains, told, *age, *last, T::one(), &mut each),
            Played::Believed { modes, oldest } => {
                for (age, probability) in modes.iter() {
                    let last = if age == Age::Empty { *modes.held() } else { *oldest };
                    self.for_each_arrived(gains, told, age, last, probability, &mut each);
                }
            }
        }
    }

    /// The same if the actuator played `age` in the last cycle and applied `last`, with every probability times `probability`.
    fn for_each_arrived<const NX: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        told: usize,
        age: Age,
        last: SVector<T, NU>,
        probability: T,
        each: &mut impl FnMut(T, &[SVector<T, NU>]),
    ) {
        let played = packet_played(age, gains.length());
        let mut none_newer = probability;
        for packet in 1..played {
            let is_sent = self.sent.get(packet - 1).is_some_and(|sent| !sent.inputs.is_empty());
            let by_then = if is_sent { gains.arrival(packet, told) } else { T::zero() };
            if by_then > T::zero() {
                each(none_newer * by_then, &self.expected_given(packet, gains, told, last));
            }
            none_newer *= T::one() - by_then;
        }
        each(none_newer, &self.expected_given(played, gains, told, last));
    }

    /// `vbar` if the packet sent `newest` cycles ago is the newest that has arrived by cycle `k+told`.
    fn expected_given<const NX: usize>(
        &self,
        newest: usize,
        gains: &Gains<'_, T, NX, NU>,
        told: usize,
        last: SVector<T, NU>,
    ) -> Vec<SVector<T, NU>, N> {
        let (length, default_input, one) = (gains.length(), gains.default_input(), T::one());
        let mut expected = Vec::from(self.left_of(newest, length, default_input, last));
        expected.truncate(default_input.in_flight(length));
        for packet in self.newer_than(newest, length, gains) {
            let (Some(inputs), arrivals) = (packet.inputs, packet.arrivals) else { continue };
            let by_then = arrivals.get(told).or(arrivals.last()).copied().unwrap_or_else(T::one);
            let under_way = one - by_then;
            let given_none = |m, r| {
                let r = if m > told && under_way > T::zero() { (r - by_then) / under_way } else { T::zero() };
                (r, one - r)
            };
            add_newer(&mut expected, default_input, inputs, arrivals, given_none);
        }
        expected
    }
}
