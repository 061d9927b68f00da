//! What was sent and may still be applied, and the input to expect from it.
//!
//! The thesis carries all of it as the vector rho (3.26) and needs one gain per actuator mode. Here it is
//! condensed to `vbar`, the expected input in each coming cycle if nothing newer arrived (THEORY 3), which
//! is all that the optimal law needs to know of the mode.

use crate::{
    DefaultInput, Scalar, Tick, actuator::Age, estimator::Modes, gains::Gains, sequence::ControlSequence,
};
use core::ops::{Add, Mul};
use heapless::{Deque, Vec};
use nalgebra::SVector;

/// A law's view of sequences: how long they are, what follows their end, and how likely they still arrive.
#[derive(Debug, Clone, Copy)]
pub struct PlayOut<R> {
    /// Inputs per sequence, `N`.
    pub length: usize,
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
    /// `r(b, m)`: probability that a packet of age `b >= 1` arrives by `k+m`, given that it had not by `k-1`.
    pub arrival: R,
}

impl<R> PlayOut<R> {
    /// Fills `expected` with `vbar`: the expected input in cycle `k+m` if no packet sent at or after `k`
    /// arrived by then, given that the actuator played `age` at `k-1`. THEORY 3.
    ///
    /// `sent(a, m)` is the input `u_{k+m|k-a}` of the packet sent `a >= 1` cycles ago (`a + m <= N-1`), `None`
    /// if none was sent then; `last` the input applied at `k-1`. `B` is an input vector, or a plain scalar
    /// where the weights themselves are wanted.
    pub fn expected_inputs<T, B>(
        &self,
        age: Age,
        sent: impl Fn(usize, usize) -> Option<B>,
        last: B,
        expected: &mut [B],
    ) where
        T: Scalar,
        B: Copy + Add<Output = B> + Mul<T, Output = B>,
        R: Fn(usize, usize) -> T,
    {
        let sent = &sent;
        let packet = |age: usize| {
            sent(age, 0)?;
            let left = 0..self.length - age;
            let inputs = left.clone().map_while(move |m| sent(age, m));
            Some((inputs, left.map(move |m| (self.arrival)(age, m))))
        };
        self.weigh(age, packet, last, expected);
    }

    /// The same with each packet as a whole: `packet(a)` is what the packet sent `a` cycles ago holds for the current
    /// cycle and those after it, `N - a` inputs, and `r(a, m)` for as many cycles.
    fn weigh<T, B, I, P>(
        &self,
        age: Age,
        packet: impl Fn(usize) -> Option<(I, P)>,
        last: B,
        expected: &mut [B],
    ) where
        T: Scalar,
        B: Copy + Add<Output = B> + Mul<T, Output = B>,
        I: Iterator<Item = B>,
        P: Iterator<Item = T>,
    {
        let zero = last * T::zero();
        let hold = self.default_input == DefaultInput::Hold;
        let buffered = age.steps().map_or(self.length, |steps| steps + 1).min(self.length);
        expected.fill(if hold { last } else { zero });
        let newest = if buffered < self.length { packet(buffered) } else { None };
        if let Some((inputs, _)) = newest {
            let mut after = zero;
            let (within, beyond) = expected.split_at_mut((self.length - buffered).min(expected.len()));
            for (value, input) in within.iter_mut().zip(inputs) {
                *value = input;
                after = input;
            }
            beyond.fill(if hold { after } else { zero });
        }
        for age in (1..buffered).rev() {
            let Some((inputs, arrivals)) = packet(age) else { continue };
            let (mut after, mut arrived) = (zero, T::zero());
            let (within, beyond) = expected.split_at_mut((self.length - age).min(expected.len()));
            for ((value, input), by_then) in within.iter_mut().zip(inputs).zip(arrivals) {
                *value = input * by_then + *value * (T::one() - by_then);
                (after, arrived) = (input, by_then);
            }
            if hold {
                // Later than for its last input it does not arrive.
                let (held, missing) = (after * arrived, T::one() - arrived);
                for value in beyond {
                    *value = held + *value * missing;
                }
            }
            // Otherwise they are zero as they are: older packets have run out before.
        }
    }
}

/// The sequences sent in the last `N + H` cycles, and the input applied last.
///
/// `N` is the capacity of a sequence; those sent in the last `N` cycles may still be applied. The ones before
/// may have been applied up to `H` cycles ago, of which an acknowledgement may tell late. One cycle is:
/// [`InFlight::acknowledge`] what was played in the last cycle, or [`InFlight::believe`] what may have been,
/// [`InFlight::expected_inputs`], then [`InFlight::push`] what was sent (or that nothing was).
#[derive(Debug, Clone)]
pub struct InFlight<T: Scalar, const NU: usize, const N: usize, const H: usize> {
    /// Newest first; `None` for a cycle in which nothing was sent.
    sent: Deque<Option<ControlSequence<T, NU, N>>, N>,
    /// What came before `sent`, newest first.
    run_out: Deque<Option<ControlSequence<T, NU, N>>, H>,
    /// What was played in the last cycle. Of a certain age its `held` is what was applied, whatever the age.
    played: Modes<T, NU, N>,
    /// What was applied in the last cycle if that was a sequence's last input.
    oldest: SVector<T, NU>,
}

impl<T: Scalar, const NU: usize, const N: usize, const H: usize> Default for InFlight<T, NU, N, H> {
    fn default() -> Self {
        let nothing = SVector::zeros();
        let played = Modes::certain(Age::Empty, nothing);
        Self { sent: Deque::new(), run_out: Deque::new(), played, oldest: nothing }
    }
}

impl<T: Scalar, const NU: usize, const N: usize, const H: usize> InFlight<T, NU, N, H> {
    /// Takes note of what was sent in this cycle; `None` if nothing was.
    pub fn push(&mut self, sequence: Option<ControlSequence<T, NU, N>>) {
        if self.sent.is_full() {
            if let Some(oldest) = self.sent.pop_back() {
                push_newest(&mut self.run_out, oldest);
            }
        }
        push_newest(&mut self.sent, sequence);
    }

    /// The sequence sent `a >= 1` cycles before the current one, which is not pushed yet.
    fn sent(&self, a: usize) -> Option<&ControlSequence<T, NU, N>> {
        self.sent.get(a.checked_sub(1)?)?.as_ref()
    }

    /// The sequence made in cycle `tick`, if one was sent then and is remembered.
    pub fn made_at(&self, tick: Tick) -> Option<&ControlSequence<T, NU, N>> {
        let sent = (0..self.sent.len()).filter_map(|place| self.sent.get(place));
        let run_out = (0..self.run_out.len()).filter_map(|place| self.run_out.get(place));
        sent.chain(run_out).flatten().find(|sequence| sequence.tick == tick)
    }

    /// The input that the actuator applied in cycle `tick` if its buffer had `age` then.
    ///
    /// `None` if no such sequence was sent, or too long ago to remember: an acknowledgement that claims it
    /// deserves no belief. For [`Age::Empty`] with hold the input depends on the past; `held` is that of the
    /// cycle before.
    pub fn applied_input(
        &self,
        default_input: DefaultInput,
        tick: Tick,
        age: Age,
        held: &SVector<T, NU>,
    ) -> Option<SVector<T, NU>> {
        match age {
            Age::Steps(steps) => self.made_at(tick - u32::from(steps))?.input_at(tick).copied(),
            Age::Empty => Some(match default_input {
                DefaultInput::Zero => SVector::zeros(),
                DefaultInput::Hold => *held,
            }),
        }
    }

    /// Takes note of what the actuator played in the last cycle, for certain.
    pub fn acknowledge(&mut self, age: Age, input: SVector<T, NU>) {
        self.played = Modes::certain(age, input);
    }

    /// Takes note of what the actuator may have played in the last cycle, where that is not certain. `oldest` is what was
    /// applied if that was a sequence's last input.
    pub fn believe(&mut self, modes: Modes<T, NU, N>, oldest: SVector<T, NU>) {
        self.played = modes;
        self.oldest = oldest;
    }

    /// What was applied in the last cycle if `age` was played then and nothing of that sequence is left.
    fn last_input(&self, age: Age) -> SVector<T, NU> {
        match (self.played.known(), age) {
            (None, Age::Steps(_)) => self.oldest,
            _ => *self.played.held(),
        }
    }

    /// `vbar`: the expected input in each of the next `n_v` cycles if nothing sent from now on arrived. THEORY 3, 8.
    pub fn expected_inputs<const NX: usize>(&self, gains: &Gains<'_, T, NX, NU>) -> Vec<SVector<T, NU>, N> {
        let of = |age, last| self.expected(gains, age, last, |b| Some(gains.arrivals(b)?.iter().copied()));
        if let Some(age) = self.played.known() {
            return of(age, *self.played.held());
        }
        let mut mean = nothing(gains);
        for (age, probability) in self.played.iter() {
            for (sum, input) in mean.iter_mut().zip(&of(age, self.last_input(age))) {
                *sum += input * probability;
            }
        }
        mean
    }

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
        match self.played.known() {
            Some(age) => self.for_each_newer(gains, told, age, T::one(), &mut each),
            None => {
                for (age, probability) in self.played.iter() {
                    self.for_each_newer(gains, told, age, probability, &mut each);
                }
            }
        }
    }

    /// The same where `played` is certain, with every probability times `probability`.
    fn for_each_newer<const NX: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        told: usize,
        played: Age,
        probability: T,
        each: &mut impl FnMut(T, &[SVector<T, NU>]),
    ) {
        let one = T::one();
        let acknowledged = played.steps().map_or(gains.length(), |steps| steps + 1).min(gains.length());
        // By age less one, for this is asked for every input in flight.
        let by_now: Vec<T, N> = (1..acknowledged).map(|age| gains.arrival(age, told)).collect();
        // Given that it had not arrived by k+told.
        let arrivals = |b: usize| {
            let by_now = by_now.get(b - 1).copied().unwrap_or_else(T::zero);
            let under_way = one - by_now;
            Some(gains.arrivals(b)?.iter().enumerate().map(move |(m, arrival)| {
                if m > told && under_way > T::zero() { (*arrival - by_now) / under_way } else { T::zero() }
            }))
        };
        let mut none_newer = probability;
        for age in 1..acknowledged {
            let by_now = by_now.get(age - 1).copied().unwrap_or_else(T::zero);
            let arrived = if self.sent(age).is_some() { by_now } else { T::zero() };
            let steps = u8::try_from(age - 1).map_or(Age::Empty, Age::Steps);
            if arrived > T::zero() {
                each(none_newer * arrived, &self.expected(gains, steps, self.last_input(steps), arrivals));
            }
            none_newer *= one - arrived;
        }
        each(none_newer, &self.expected(gains, played, self.last_input(played), arrivals));
    }

    /// `vbar` if the actuator had played `age`, which made it apply `last`, and packets under way arrived with the
    /// probabilities `arrivals`.
    fn expected<const NX: usize, P: Iterator<Item = T>>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        age: Age,
        last: SVector<T, NU>,
        arrivals: impl Fn(usize) -> Option<P>,
    ) -> Vec<SVector<T, NU>, N> {
        let (length, default_input) = (gains.length(), gains.default_input());
        let mut expected = nothing(gains);
        let packet = |age| {
            let inputs = self.sent(age)?.inputs.get(age..length)?;
            Some((inputs.iter().copied(), arrivals(age)?))
        };
        let play_out = PlayOut { length, default_input, arrival: () };
        play_out.weigh(age, packet, last, &mut expected);
        expected
    }
}

/// A zero input for each of the next `n_v` cycles.
fn nothing<T: Scalar, const NX: usize, const NU: usize, const N: usize>(
    gains: &Gains<'_, T, NX, NU>,
) -> Vec<SVector<T, NU>, N> {
    let mut inputs = Vec::from([SVector::zeros(); N]);
    inputs.truncate(gains.in_flight());
    inputs
}

/// Puts `entry` in front; a full queue loses its last one.
fn push_newest<E, const C: usize>(queue: &mut Deque<E, C>, entry: E) {
    if queue.is_full() {
        queue.pop_back();
    }
    // There is room now.
    let _ = queue.push_front(entry);
}
