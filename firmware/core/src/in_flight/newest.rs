//! The input to expect given which packet is the newest that has arrived by a later cycle: what an event trigger asks for.

use super::{InFlight, arrivals::add_newer, under_way::packet_played};
use crate::{
    Scalar,
    gains::Gains,
    played::{Age, Played},
};
use nalgebra::SVector;

/// Which packet is asked for, and what is known of those after it.
struct Given<'g, T: Scalar, const NU: usize> {
    /// How many cycles ago it was sent.
    newest: usize,
    /// By which cycle it is the newest that has arrived.
    told: usize,
    /// What was applied in the last cycle.
    last: &'g SVector<T, NU>,
}

impl<T: Scalar, const NU: usize> InFlight<'_, T, NU> {
    /// Calls `each` with every sequence that may turn out to be the newest that has arrived by cycle `k+told`, after the
    /// actuator has played `played` in the last cycle: its probability, and the expected inputs given that it is, one for each
    /// of the next `n_v` cycles. THEORY 7.
    ///
    /// It is one that may have been played in the last cycle, or one sent after it; nothing is known of when it arrived. The
    /// expected inputs mean something from cycle `k+told` on; those before are what the sequence holds for them, played or
    /// not. `room` has room for `n_v` inputs.
    pub fn for_each_newest<const NX: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        played: &Played<'_, T, NU>,
        told: usize,
        room: &mut [SVector<T, NU>],
        mut each: impl FnMut(T, &[SVector<T, NU>]),
    ) {
        let (room, _) = room.split_at_mut(gains.in_flight().min(room.len()));
        match played {
            Played::Known(age, last) => {
                self.for_each_arrived(gains, told, (*age, last, T::one()), room, &mut each);
            }
            Played::Believed { modes, oldest } => {
                for (age, probability) in modes.iter() {
                    let last = if age == Age::Empty { &modes.held } else { oldest };
                    self.for_each_arrived(gains, told, (age, last, probability), room, &mut each);
                }
            }
        }
    }

    /// The same if the actuator played this age in the last cycle and applied this input, with every probability times this
    /// one.
    fn for_each_arrived<const NX: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        told: usize,
        (age, last, probability): (Age, &SVector<T, NU>, T),
        room: &mut [SVector<T, NU>],
        each: &mut impl FnMut(T, &[SVector<T, NU>]),
    ) {
        let played = packet_played(age, self.length);
        let mut none_newer = probability;
        for packet in 1..played {
            let is_sent = self.sent(packet - 1).is_some();
            let by_then = if is_sent { gains.arrival(packet, told) } else { T::zero() };
            if by_then > T::zero() {
                self.fill_expected_given(&Given { newest: packet, told, last }, gains, room);
                each(none_newer * by_then, room);
            }
            none_newer *= T::one() - by_then;
        }
        self.fill_expected_given(&Given { newest: played, told, last }, gains, room);
        each(none_newer, room);
    }

    /// `vbar` if the packet sent `newest` cycles ago is the newest that has arrived by cycle `k+told`.
    fn fill_expected_given<const NX: usize>(
        &self,
        given: &Given<'_, T, NU>,
        gains: &Gains<'_, T, NX, NU>,
        expected: &mut [SVector<T, NU>],
    ) {
        let (default_input, one) = (gains.default_input(), T::one());
        self.fill_left_of(given.newest, default_input, given.last, expected);
        for packet in self.newer_than(given.newest, gains) {
            let (Some(inputs), arrivals) = (packet.inputs, packet.arrivals) else { continue };
            let by_then = arrivals.get(given.told).or(arrivals.last()).copied().unwrap_or_else(T::one);
            let under_way = one - by_then;
            let given_none = |m, r| {
                let is_later = m > given.told && under_way > T::zero();
                let r = if is_later { (r - by_then) / under_way } else { T::zero() };
                (r, one - r)
            };
            add_newer(expected, default_input, inputs, arrivals, given_none);
        }
    }
}
