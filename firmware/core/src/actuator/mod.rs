//! `Actuator`: buffers the newest sequence, plays it out, tells what it played.
//!
//! Past-packet rejection, default input, saturation and acknowledgement are here; frames become sequences and
//! acknowledgements frames in [`crate::wire`].
//!
//! | file | what lives there |
//! |---|---|
//! | `settings` | how it behaves: default and safe input, limits |
//! | `rejected` | why a sequence or frame changed nothing |
//! | `standing` | what it stands on from cycle to cycle, kept twice; how it is |

mod rejected;
mod settings;
mod standing;

use crate::{
    Scalar, Tick,
    integrity::{Round, Twice},
    played::{Age, DefaultInput},
    sequence::ControlSequence,
    wire::{self, Acknowledgement, MOST_AGES},
};
use nalgebra::SVector;
use standing::Standing;

pub use crate::played::Applied;
pub use rejected::{RejectedFrame, RejectedSequence};
pub use settings::{Limits, Safe, Settings};

/// Inputs of memory that an [`Actuator`] is lent for sequences of up to `length` inputs: one that is played, its copy, and one
/// that comes.
pub const fn memory_len(length: usize) -> usize {
    length * 3
}

/// The actuator end of the link: sequences in, one input a cycle out.
///
/// All that decides about an input is kept twice. Where the copies differ, memory has changed by itself: the actuator is lost,
/// [`crate::health::Cause::Memory`], and applies its safe input for good. Only [`Actuator::new`] ends that.
///
/// ```
/// use slqg::actuator::{Actuator, Settings, memory_len};
/// use slqg::nalgebra::Vector1;
/// use slqg::sequence::ControlSequence;
/// use slqg::{Age, DefaultInput, Tick};
///
/// let mut memory = [Vector1::zeros(); memory_len(2)];
/// let settings = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
/// let mut actuator = Actuator::new(settings, Tick(0), &mut memory);
/// let inputs = [Vector1::new(1.5_f32), Vector1::new(0.5)];
/// actuator.offer(&ControlSequence { tick: Tick(0), inputs: &inputs }).expect("newer than any before");
/// let played = [(); 3].map(|()| actuator.step());
/// assert_eq!(played.map(|applied| applied.input[0]), [1.5, 0.5, 0.0]);
/// assert_eq!(played.map(|applied| applied.age), [Age::Steps(0), Age::Steps(1), Age::Empty]);
/// ```
#[derive(Debug)]
pub struct Actuator<'m, T: Scalar, const NU: usize> {
    settings: Twice<Settings<T, NU>>,
    standing: Twice<Standing<T, NU>>,
    /// What is applied once memory has changed by itself.
    safe_input: Twice<SVector<T, NU>>,
    /// The sequence that is played.
    buffer: &'m mut [SVector<T, NU>],
    /// The same.
    copy: &'m mut [SVector<T, NU>],
    /// Room for one that comes.
    coming: &'m mut [SVector<T, NU>],
    /// What was played in the last cycles, each at the place of its tick: a position of its own could change by itself.
    played: [Age; MOST_AGES],
    rejected_frames: u32,
    /// Whether memory has changed by itself.
    is_damaged: bool,
    round: Round,
}

impl<'m, T: Scalar, const NU: usize> Actuator<'m, T, NU> {
    /// An actuator with an empty buffer whose next cycle is `tick`. Until something arrives it applies zero, or
    /// what the limits make of it; before its first cycle it has applied zero.
    ///
    /// It takes sequences of up to a third as many inputs as `memory` holds, see [`memory_len`], and of 255 at most: an age must
    /// fit one byte.
    pub fn new(settings: Settings<T, NU>, tick: Tick, memory: &'m mut [SVector<T, NU>]) -> Self {
        let length = (memory.len() / 3).min(u8::MAX.into());
        let (buffer, rest) = memory.split_at_mut(length);
        let (copy, rest) = rest.split_at_mut(length);
        let (coming, _) = rest.split_at_mut(length);
        Self {
            safe_input: Twice::new(standing::safe_input(&settings)),
            settings: Twice::new(settings),
            standing: Twice::new(Standing::new(tick)),
            buffer,
            copy,
            coming,
            played: [Age::Empty; MOST_AGES],
            rejected_frames: 0,
            is_damaged: false,
            round: Round::START,
        }
    }

    /// Begins anew with cycle `tick`, as an actuator that has just been made; but memory that has changed by itself is not
    /// trusted again.
    pub fn restart(&mut self, tick: Tick) {
        self.standing = Twice::new(Standing::new(tick));
        self.rejected_frames = 0;
    }

    /// The cycle that [`Actuator::step`] will play next.
    pub fn tick(&self) -> Tick {
        self.standing.either().tick
    }

    /// Frames that were not for this actuator, damaged, past, run out or not finite, since the start; saturates.
    pub fn rejected_frames(&self) -> u32 {
        self.rejected_frames
    }

    /// Takes a frame from the link; any number of them a cycle, in any order.
    ///
    /// # Errors
    /// Says why the frame changed nothing. It is counted; there is nothing else to do.
    pub fn receive(&mut self, frame: &[u8]) -> Result<(), RejectedFrame> {
        let taken = match wire::decode_control(frame, self.coming) {
            Ok(sequence) => self.standing.get().filter(|_| !self.is_damaged).map_or_else(
                || Err(RejectedFrame::Sequence(RejectedSequence::Memory)),
                |standing| standing.with(&sequence).map_err(RejectedFrame::Sequence),
            ),
            Err(error) => Err(RejectedFrame::Decode(error)),
        };
        match taken {
            Ok(standing) => {
                core::mem::swap(&mut self.buffer, &mut self.coming);
                self.keep(standing);
                Ok(())
            }
            Err(error) => {
                self.rejected_frames = self.rejected_frames.saturating_add(1);
                Err(error)
            }
        }
    }

    /// Offers a sequence to the buffer, which keeps only the newest.
    ///
    /// # Errors
    /// Says why the buffer did not take it.
    pub fn offer(&mut self, sequence: &ControlSequence<'_, T, NU>) -> Result<(), RejectedSequence> {
        if !sequence.is_finite() {
            return Err(RejectedSequence::NotFinite);
        }
        let standing = self.standing.get().filter(|_| !self.is_damaged).ok_or(RejectedSequence::Memory)?;
        let standing = standing.with(sequence)?;
        let room = self.buffer.get_mut(..sequence.inputs.len()).ok_or(RejectedSequence::TooLong)?;
        room.copy_from_slice(sequence.inputs);
        self.keep(standing);
        Ok(())
    }

    /// The buffer holds what `standing` says.
    fn keep(&mut self, standing: Standing<T, NU>) {
        let length = standing.buffered.map_or(0, |(_, length)| length);
        for (copy, input) in self.copy.iter_mut().zip(&*self.buffer).take(length) {
            *copy = *input;
        }
        self.standing.set(standing);
    }

    /// Plays one cycle: the buffered sequence's input for it, or the default input. Thesis (3.10)-(3.12).
    pub fn step(&mut self) -> Applied<T, NU> {
        let (false, Some(settings), Some(standing)) =
            (self.is_damaged, self.settings.get(), self.standing.get())
        else {
            return self.stand_safe();
        };
        let Standing { tick, mut buffered, last_input, idle, played } = *standing;
        let due = buffered.and_then(|(made, length)| {
            let age = u8::try_from(tick.age_of(made)?).ok()?;
            (usize::from(age) < length).then_some(age)
        });
        let (input, age) = match due {
            Some(age) => {
                let place = usize::from(age);
                // Of a sequence in the buffer there is every input, and its copy is the same.
                match (self.buffer.get(place), self.copy.get(place)) {
                    (Some(input), Some(copy)) if input == copy => (*input, Age::Steps(age)),
                    _ => return self.stand_safe(),
                }
            }
            None => {
                // A sequence older than any that could still arrive: forget it before its tick can wrap.
                buffered = buffered.filter(|(made, _)| {
                    usize::try_from(tick.since(*made)).map_or(true, |age| age < self.buffer.len())
                });
                let default = match settings.default_input {
                    DefaultInput::Zero => SVector::zeros(),
                    DefaultInput::Hold => last_input,
                };
                let safe = settings.safe.filter(|safe| idle >= safe.after);
                (safe.map_or(default, |safe| safe.input), Age::Empty)
            }
        };
        // What is no longer told apart is not counted.
        let most = settings.safe.map_or(1, |safe| safe.after.saturating_add(1));
        let idle = if age == Age::Empty { idle.saturating_add(1).min(most) } else { 0 };
        let input = settings.leaves_after(&last_input, &input);
        self.played[place_of(tick)] = age;
        let played = played.saturating_add(1).min(MOST_AGES as u8);
        self.standing.set(Standing { tick: tick + 1, buffered, last_input: input, idle, played });
        Applied { tick, input, age }
    }

    /// What to acknowledge after [`Actuator::step`]: the age it played and those of the cycles before, `cycles` in all.
    /// At least 1 and at most [`MOST_AGES`] whatever `cycles` is, and no more than were played; `None` before the first, and of
    /// an actuator whose memory has changed by itself.
    ///
    /// The ages after the newest repeat what earlier acknowledgements said: if each has `cycles` of them, the controller
    /// never hears of a cycle only if `cycles` acknowledgements in a row are lost. Each takes one byte. An
    /// acknowledgement that has not come tells the controller nothing, neither that a sequence arrived nor that none
    /// did, unless the link guarantees delivery.
    pub fn acknowledgement(&self, cycles: usize) -> Option<Acknowledgement> {
        let standing = self.standing.get().filter(|standing| !self.is_damaged && standing.played > 0)?;
        let (newest, count) = (standing.tick - 1, cycles.clamp(1, MOST_AGES).min(standing.played.into()));
        // There is room for all.
        let ages = (0..).take(count).map(|ago| self.played[place_of(newest - ago)]).collect();
        Some(Acknowledgement { tick: newest, ages })
    }
}

/// Where it is kept what was played in a cycle.
fn place_of(tick: Tick) -> usize {
    tick.0 as usize % MOST_AGES
}

#[cfg(test)]
mod faults;
