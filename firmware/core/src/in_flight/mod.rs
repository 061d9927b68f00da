//! What was sent and may still be applied, and the input to expect from it.
//!
//! The thesis carries all of it as the vector rho (3.26) and needs one gain per actuator mode. Here it is
//! condensed to `vbar`, the expected input in each coming cycle if nothing newer arrived (THEORY 3), which
//! is all that the optimal law needs to know of the mode.
//!
//! | file | what lives there |
//! |---|---|
//! | `expected` | the expected inputs |
//! | `newest` | the same, given which packet is the newest that has arrived |
//! | `arrivals` | the recursion that both come from, over packets that may yet arrive |
//! | `under_way` | these packets |
//! | `mean` | the expected inputs where no acknowledgement ever comes |

mod arrivals;
mod expected;
mod mean;
mod newest;
mod under_way;

use crate::{
    Scalar, Tick,
    integrity::place_of,
    played::{Age, DefaultInput},
    sequence::ControlSequence,
};
use nalgebra::SVector;

pub use arrivals::add_newer;

/// The sequences sent in the last cycles, and one that may be sent next, in a ring that is lent.
///
/// Those sent in the last `N` cycles may still be applied. The ones before may have been applied some cycles ago, of which an
/// acknowledgement may tell late. One cycle is: [`InFlight::fill_expected`], [`InFlight::candidate`] is written, then
/// [`InFlight::push`] says whether it was sent.
///
/// ```
/// use slqg::in_flight::InFlight;
/// use slqg::nalgebra::Vector1;
/// use slqg::played::Played;
/// use slqg::{Age, DefaultInput, Tick};
/// # use slqg::checked::{Finite, Probabilities};
/// # use slqg::gains::{Gains, Tables};
/// # const LAW: Gains<'static, f32, 2, 1> = Gains::<f32, 2, 1>::new(
/// #     2,
/// #     DefaultInput::Zero,
/// #     Tables {
/// #         lx: Finite::<f32>::new(&[-3.0, -2.5, -2.5, -2.25]),
/// #         m: Finite::<f32>::new(&[0.0, -0.5]),
/// #         arrival: Probabilities::<f32>::new(&[0.5]),
/// #     },
/// # );
///
/// // Three cycles are remembered, of sequences of two inputs.
/// let (mut sent, mut inputs) = ([false; 4], [Vector1::zeros(); 8]);
/// let mut in_flight = InFlight::new(2, Tick(0), &mut sent, &mut inputs);
/// in_flight.candidate().copy_from_slice(&[Vector1::new(1.0), Vector1::new(3.0)]);
/// in_flight.push(true);
/// // It had not arrived in cycle 0, and arrives in cycle 1 with a probability of one half: `LAW` is as in the example of `Gains`.
/// let mut room = [Vector1::zeros(); 1];
/// assert_eq!(in_flight.fill_expected(&LAW, &Played::nothing(), &mut room), [Vector1::new(1.5)]);
/// let applied = |age| in_flight.applied_input(DefaultInput::Zero, Tick(1), age, &Vector1::zeros());
/// assert_eq!(applied(Age::Steps(1)), Some(Vector1::new(3.0)));
/// assert_eq!(applied(Age::Steps(0)), None, "nothing was sent in cycle 1");
/// ```
#[derive(Debug)]
pub struct InFlight<'m, T: Scalar, const NU: usize> {
    /// Inputs per sequence, `N`.
    length: usize,
    /// Whether a sequence was sent in each remembered cycle.
    sent: &'m mut [bool],
    /// `N` inputs for each, at the same place.
    inputs: &'m mut [SVector<T, NU>],
    /// The place of the newest.
    newest: usize,
    /// The cycle it was made in.
    tick: Tick,
}

impl<'m, T: Scalar, const NU: usize> InFlight<'m, T, NU> {
    /// Nothing was sent in any cycle before `tick`, the first. Sequences have `length` inputs.
    ///
    /// One less than `sent` has entries is the number of cycles that are remembered, at least `length`; `inputs` needs `length`
    /// for each entry. What is beyond is not used, but for the mean where no acknowledgement ever comes, [`InFlight::begin_mean`].
    pub fn new(length: usize, tick: Tick, sent: &'m mut [bool], inputs: &'m mut [SVector<T, NU>]) -> Self {
        sent.fill(false);
        Self { length, sent, inputs, newest: 0, tick: tick - 1 }
    }

    /// Nothing was sent in any cycle before `tick`.
    pub(crate) fn restart(&mut self, tick: Tick) {
        self.sent.fill(false);
        self.tick = tick - 1;
    }

    /// What a checksum is taken of: where its memory is, and how it is divided.
    pub(crate) fn word(&self) -> u32 {
        place_of(self.sent) ^ place_of(self.inputs) ^ self.length as u32
    }

    /// Whether the ring's position is within the ring.
    pub(crate) fn is_in_range(&self) -> bool {
        self.newest < self.sent.len()
    }

    /// Inputs per sequence.
    pub fn length(&self) -> usize {
        self.length
    }

    /// The sequence of the current cycle: room for it, and what was written there.
    pub fn candidate(&mut self) -> &mut [SVector<T, NU>] {
        let place = self.after_newest();
        self.inputs
            .get_mut(place * self.length..)
            .and_then(|rest| rest.get_mut(..self.length))
            .unwrap_or_default()
    }

    /// The sequence of the current cycle as it stands.
    pub fn proposed(&self) -> ControlSequence<'_, T, NU> {
        ControlSequence { tick: self.tick + 1, inputs: self.inputs_at(self.after_newest()) }
    }

    /// Ends the cycle: its sequence was sent, or nothing was.
    pub fn push(&mut self, is_sent: bool) {
        self.newest = self.after_newest();
        self.tick += 1;
        if let Some(sent) = self.sent.get_mut(self.newest) {
            *sent = is_sent;
        }
    }

    fn after_newest(&self) -> usize {
        let next = self.newest + 1;
        if next < self.sent.len() { next } else { 0 }
    }

    /// What was sent `ago` cycles before the newest, `N` inputs; `None` if nothing was, or it is not remembered.
    fn sent(&self, ago: usize) -> Option<&[SVector<T, NU>]> {
        // The place after the newest is the candidate's.
        let cycles = self.sent.len();
        if ago + 1 >= cycles {
            return None;
        }
        let place = if ago <= self.newest { self.newest - ago } else { self.newest + cycles - ago };
        self.sent.get(place).copied().unwrap_or(false).then(|| self.inputs_at(place))
    }

    fn inputs_at(&self, place: usize) -> &[SVector<T, NU>] {
        self.inputs.get(place * self.length..).and_then(|rest| rest.get(..self.length)).unwrap_or_default()
    }

    /// The sequence made in cycle `tick`, if one was sent then and is remembered.
    pub fn made_at(&self, tick: Tick) -> Option<ControlSequence<'_, T, NU>> {
        let ago = usize::try_from(self.tick.age_of(tick)?).ok()?;
        Some(ControlSequence { tick, inputs: self.sent(ago)? })
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
            Age::Steps(steps) => {
                self.made_at(tick - u32::from(steps))?.inputs.get(usize::from(steps)).copied()
            }
            Age::Empty => Some(match default_input {
                DefaultInput::Zero => SVector::zeros(),
                DefaultInput::Hold => *held,
            }),
        }
    }
}
