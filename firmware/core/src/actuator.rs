//! `Actuator`: buffers the newest sequence, plays it out, tells what it played.
//!
//! Past-packet rejection, default input, saturation and acknowledgement are here; frames become sequences and
//! acknowledgements frames in [`crate::wire`].

use crate::{
    Scalar, Tick,
    health::{Cause, Health},
    played::{Age, DefaultInput},
    sequence::ControlSequence,
    wire::{self, Acknowledgement, MOST_AGES},
};
use heapless::HistoryBuf;
use nalgebra::SVector;

pub use crate::played::Applied;

/// Bounds of each input, in input units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<T, const NU: usize> {
    /// Smallest value of each input.
    pub min: SVector<T, NU>,
    /// Largest value of each input; not below `min`.
    pub max: SVector<T, NU>,
    /// Most that each input changes from one cycle to the next, not negative; `None`: any.
    pub rate: Option<SVector<T, NU>>,
}

impl<T: Scalar, const NU: usize> Limits<T, NU> {
    /// The nearest input within the limits.
    pub fn saturate(&self, input: &SVector<T, NU>) -> SVector<T, NU> {
        // Not `clamp`, which panics on limits in the wrong order.
        input.zip_zip_map(&self.min, &self.max, |value, min, max| value.max(min).min(max))
    }
}

/// How an actuator behaves; does not change while it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<T, const NU: usize> {
    /// What is applied when the buffer has run out.
    pub default_input: DefaultInput,
    /// Saturation, if any.
    pub limits: Option<Limits<T, NU>>,
    /// What is applied once the buffer has been empty for too long, if anything but the default input.
    pub safe: Option<Safe<T, NU>>,
}

/// What brings the plant to where it does no harm, as far as an input can.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Safe<T, const NU: usize> {
    /// Cycles in a row with an empty buffer before it is applied.
    pub after: u16,
    /// The input, in input units; within the limits, or else what they make of it.
    pub input: SVector<T, NU>,
}

impl<T: Scalar, const NU: usize> Settings<T, NU> {
    /// `input` as it leaves the actuator. Controller and actuator both call this, so that the controller
    /// knows what an acknowledged input really was.
    pub fn saturate(&self, input: &SVector<T, NU>) -> SVector<T, NU> {
        self.limits.as_ref().map_or(*input, |limits| limits.saturate(input))
    }

    /// The same after `before` in the cycle before: what becomes of `input`, where inputs may change so much in a cycle only.
    pub fn leaves_after(&self, before: &SVector<T, NU>, input: &SVector<T, NU>) -> SVector<T, NU> {
        let within = self.saturate(input);
        let Some(rate) = self.rate() else { return within };
        within.zip_zip_map(before, &rate, |value, before, rate| value.max(before - rate).min(before + rate))
    }

    /// Most that each input changes from one cycle to the next, if that is limited.
    pub fn rate(&self) -> Option<SVector<T, NU>> {
        self.limits.as_ref().and_then(|limits| limits.rate)
    }
}

/// Why a sequence did not enter the buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RejectedSequence {
    /// It is not newer than the buffered one: past-packet rejection, thesis 3.1.
    Past,
    /// Its last input was meant for a cycle that is over.
    RunOut,
    /// It was made in a cycle that has not begun: the two ends' ticks disagree.
    Future,
    /// It holds a number that is not finite.
    NotFinite,
    /// It holds no input.
    NoInputs,
    /// It holds more inputs than the actuator has room for.
    TooLong,
}

impl core::fmt::Display for RejectedSequence {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Past => "a sequence not newer than the one in the buffer",
            Self::RunOut => "a sequence whose last input was meant for a cycle that is over",
            Self::Future => {
                "a sequence made in a cycle that has not begun: the clocks of the two ends disagree"
            }
            Self::NotFinite => "a sequence with a number that is not finite",
            Self::NoInputs => "a sequence of no input",
            Self::TooLong => "a sequence of more inputs than the actuator has memory for",
        })
    }
}

impl core::error::Error for RejectedSequence {}

/// Why a frame changed nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RejectedFrame {
    /// The bytes are not a control frame for this actuator.
    Decode(wire::DecodeError),
    /// The sequence in it is of no use.
    Sequence(RejectedSequence),
}

impl core::fmt::Display for RejectedFrame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Decode(why) => why.fmt(f),
            Self::Sequence(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for RejectedFrame {}

/// Inputs of memory that an [`Actuator`] is lent for sequences of up to `length` inputs: one that is played, one that comes.
pub const fn memory_len(length: usize) -> usize {
    length * 2
}

/// The actuator end of the link: sequences in, one input a cycle out.
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
    settings: Settings<T, NU>,
    tick: Tick,
    /// The sequence that is played.
    buffer: &'m mut [SVector<T, NU>],
    /// Its tick and its length; `None` while there is none.
    buffered: Option<(Tick, usize)>,
    /// Room for one that comes.
    coming: &'m mut [SVector<T, NU>],
    last_input: SVector<T, NU>,
    /// What was played in the last cycles.
    played: HistoryBuf<Age, MOST_AGES>,
    /// Cycles in a row with an empty buffer.
    idle: u16,
    rejected_frames: u32,
}

impl<'m, T: Scalar, const NU: usize> Actuator<'m, T, NU> {
    /// An actuator with an empty buffer whose next cycle is `tick`. Until something arrives it applies zero, or
    /// what the limits make of it; before its first cycle it has applied zero.
    ///
    /// It takes sequences of up to half as many inputs as `memory` holds, see [`memory_len`], and of 255 at most: an age must
    /// fit one byte.
    pub fn new(settings: Settings<T, NU>, tick: Tick, memory: &'m mut [SVector<T, NU>]) -> Self {
        let length = (memory.len() / 2).min(u8::MAX.into());
        let (buffer, rest) = memory.split_at_mut(length);
        let (coming, _) = rest.split_at_mut(length);
        Self {
            settings,
            tick,
            buffer,
            buffered: None,
            coming,
            last_input: SVector::zeros(),
            played: HistoryBuf::new(),
            idle: 0,
            rejected_frames: 0,
        }
    }

    /// Begins anew with cycle `tick`, as an actuator that has just been made.
    pub fn restart(&mut self, tick: Tick) {
        self.tick = tick;
        self.buffered = None;
        self.last_input = SVector::zeros();
        self.played = HistoryBuf::new();
        self.idle = 0;
        self.rejected_frames = 0;
    }

    /// The cycle that [`Actuator::step`] will play next.
    pub fn tick(&self) -> Tick {
        self.tick
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
            Ok(sequence) => {
                let (tick, length) = (sequence.tick, sequence.inputs.len());
                judge(&sequence, self.tick, self.buffered)
                    .map(|()| (tick, length))
                    .map_err(RejectedFrame::Sequence)
            }
            Err(error) => Err(RejectedFrame::Decode(error)),
        };
        match taken {
            Ok(buffered) => {
                core::mem::swap(&mut self.buffer, &mut self.coming);
                self.buffered = Some(buffered);
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
        judge(sequence, self.tick, self.buffered)?;
        let room = self.buffer.get_mut(..sequence.inputs.len()).ok_or(RejectedSequence::TooLong)?;
        room.copy_from_slice(sequence.inputs);
        self.buffered = Some((sequence.tick, sequence.inputs.len()));
        Ok(())
    }

    /// The sequence in the buffer.
    fn held(&self) -> Option<ControlSequence<'_, T, NU>> {
        let (tick, length) = self.buffered?;
        Some(ControlSequence { tick, inputs: self.buffer.get(..length)? })
    }

    /// Plays one cycle: the buffered sequence's input for it, or the default input. Thesis (3.10)-(3.12).
    pub fn step(&mut self) -> Applied<T, NU> {
        let tick = self.tick;
        let played = self.held().and_then(|sequence| {
            let age = u8::try_from(tick.age_of(sequence.tick)?).ok()?;
            sequence.input_at(tick).map(|input| (*input, Age::Steps(age)))
        });
        let (input, age) = played.unwrap_or_else(|| {
            // A sequence older than any that could still arrive: forget it before its tick can wrap.
            let length = self.buffer.len();
            if self
                .buffered
                .is_some_and(|(held, _)| usize::try_from(tick.since(held)).is_ok_and(|age| age >= length))
            {
                self.buffered = None;
            }
            let default = match self.settings.default_input {
                DefaultInput::Zero => SVector::zeros(),
                DefaultInput::Hold => self.last_input,
            };
            let safe = self.settings.safe.filter(|safe| self.idle >= safe.after);
            (safe.map_or(default, |safe| safe.input), Age::Empty)
        });
        // What is no longer told apart is not counted.
        let most = self.settings.safe.map_or(1, |safe| safe.after.saturating_add(1));
        self.idle = if age == Age::Empty { self.idle.saturating_add(1).min(most) } else { 0 };
        self.last_input = self.settings.leaves_after(&self.last_input, &input);
        self.played.write(age);
        self.tick += 1;
        Applied { tick, input: self.last_input, age }
    }

    /// How this end of the loop is, after the cycle that was played last: lost once it applies the safe input.
    pub fn health(&self) -> Health {
        match self.settings.safe {
            Some(safe) if self.idle > safe.after => Health::Lost(Cause::RunOut),
            _ if self.idle > 0 => Health::Degraded(Cause::RunOut),
            _ => Health::Nominal,
        }
    }

    /// What to acknowledge after [`Actuator::step`]: the age it played and those of the cycles before, `cycles` in all.
    /// At least 1 and at most [`MOST_AGES`] whatever `cycles` is, and no more than were played; `None` before the first.
    ///
    /// The ages after the newest repeat what earlier acknowledgements said: if each has `cycles` of them, the controller
    /// never hears of a cycle only if `cycles` acknowledgements in a row are lost. Each takes one byte. An
    /// acknowledgement that has not come tells the controller nothing, neither that a sequence arrived nor that none
    /// did, unless the link guarantees delivery.
    pub fn acknowledgement(&self, cycles: usize) -> Option<Acknowledgement> {
        if self.played.is_empty() {
            return None;
        }
        let (older, newer) = self.played.as_slices();
        let mut ages = heapless::Vec::new();
        for part in [newer, older] {
            let wanted = cycles.clamp(1, MOST_AGES) - ages.len();
            for age in part.iter().rev().take(wanted) {
                // There is room for all.
                let _ = ages.push(*age);
            }
        }
        Some(Acknowledgement { tick: self.tick - 1, ages })
    }
}

/// Whether a sequence of finite inputs is of use in cycle `now`, beside the one that is buffered: its tick and its length.
fn judge<T: Scalar, const NU: usize>(
    sequence: &ControlSequence<'_, T, NU>,
    now: Tick,
    buffered: Option<(Tick, usize)>,
) -> Result<(), RejectedSequence> {
    if sequence.inputs.is_empty() {
        return Err(RejectedSequence::NoInputs);
    }
    if sequence.tick.is_after(now) {
        return Err(RejectedSequence::Future);
    }
    if sequence.input_at(now).is_none() {
        return Err(RejectedSequence::RunOut);
    }
    if buffered.is_some_and(|(held, _)| !sequence.tick.is_after(held)) {
        return Err(RejectedSequence::Past);
    }
    Ok(())
}
