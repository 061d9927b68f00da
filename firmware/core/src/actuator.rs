//! `Actuator`: buffers the newest sequence, plays it out, tells what it played.
//!
//! Past-packet rejection, default input, saturation and acknowledgement are here; frames become sequences and
//! acknowledgements frames in [`crate::wire`].

use crate::{
    Scalar, Tick,
    sequence::ControlSequence,
    wire::{self, Acknowledgement, MOST_AGES},
};
use heapless::HistoryBuf;
use nalgebra::SVector;

/// What the actuator applies when its buffer has run out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DefaultInput {
    /// Zero input, thesis (3.9).
    Zero,
    /// The input applied last, thesis 3.6.1.
    Hold,
}

impl DefaultInput {
    /// In-flight inputs the control law for sequences of `length` inputs takes, `n_v`. THEORY 3.
    pub const fn in_flight(self, length: usize) -> usize {
        match self {
            Self::Zero => length.saturating_sub(1),
            Self::Hold => length,
        }
    }

    /// As in design files, on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::Hold => "hold",
        }
    }
}

/// What the actuator played in one cycle: theta of thesis (3.11).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Age {
    /// The entry of a sequence made this many cycles before.
    Steps(u8),
    /// The default input: the buffer was empty or had run out (theta = N in the thesis).
    Empty,
}

impl Age {
    /// Cycles since the played sequence was made; `None` for the default input.
    pub const fn steps(self) -> Option<usize> {
        match self {
            Self::Steps(steps) => Some(steps as usize),
            Self::Empty => None,
        }
    }
}

/// Bounds of each input, in input units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<T, const NU: usize> {
    /// Smallest value of each input.
    pub min: SVector<T, NU>,
    /// Largest value of each input; not below `min`.
    pub max: SVector<T, NU>,
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
}

impl<T: Scalar, const NU: usize> Settings<T, NU> {
    /// `input` as it leaves the actuator. Controller and actuator both call this, so that the controller
    /// knows what an acknowledged input really was.
    pub fn saturate(&self, input: &SVector<T, NU>) -> SVector<T, NU> {
        self.limits.as_ref().map_or(*input, |limits| limits.saturate(input))
    }
}

/// Why a sequence did not enter the buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
}

/// Why a frame changed nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectedFrame {
    /// The bytes are not a control frame for this actuator.
    Decode(wire::DecodeError),
    /// The sequence in it is of no use.
    Sequence(RejectedSequence),
}

/// What left the actuator in one cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Applied<T, const NU: usize> {
    /// The cycle.
    pub tick: Tick,
    /// The input after saturation, in input units; always finite.
    pub input: SVector<T, NU>,
    /// Where it came from.
    pub age: Age,
}

/// The actuator end of the link: sequences in, one input a cycle out.
#[derive(Debug, Clone)]
pub struct Actuator<T: Scalar, const NU: usize, const N: usize> {
    settings: Settings<T, NU>,
    tick: Tick,
    buffer: Option<ControlSequence<T, NU, N>>,
    last_input: SVector<T, NU>,
    /// What was played in the last cycles.
    played: HistoryBuf<Age, MOST_AGES>,
    rejected_frames: u32,
}

impl<T: Scalar, const NU: usize, const N: usize> Actuator<T, NU, N> {
    /// An actuator with an empty buffer whose next cycle is `tick`. Until something arrives it applies zero, or
    /// what the limits make of it.
    ///
    /// Does not compile for `N > 255`: an age must fit one byte.
    pub fn new(settings: Settings<T, NU>, tick: Tick) -> Self {
        const { assert!(N <= u8::MAX as usize, "the age of a sequence must fit one byte") };
        Self {
            settings,
            tick,
            buffer: None,
            last_input: SVector::zeros(),
            played: HistoryBuf::new(),
            rejected_frames: 0,
        }
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
        let outcome = wire::decode_control(frame)
            .map_err(RejectedFrame::Decode)
            .and_then(|sequence| self.offer(sequence).map_err(RejectedFrame::Sequence));
        if outcome.is_err() {
            self.rejected_frames = self.rejected_frames.saturating_add(1);
        }
        outcome
    }

    /// Offers a sequence to the buffer, which keeps only the newest.
    ///
    /// # Errors
    /// Says why the buffer did not take it.
    pub fn offer(&mut self, sequence: ControlSequence<T, NU, N>) -> Result<(), RejectedSequence> {
        if !sequence.is_finite() {
            return Err(RejectedSequence::NotFinite);
        }
        if sequence.inputs.is_empty() {
            return Err(RejectedSequence::NoInputs);
        }
        if sequence.tick.is_after(self.tick) {
            return Err(RejectedSequence::Future);
        }
        if sequence.input_at(self.tick).is_none() {
            return Err(RejectedSequence::RunOut);
        }
        if self.buffer.as_ref().is_some_and(|held| !sequence.tick.is_after(held.tick)) {
            return Err(RejectedSequence::Past);
        }
        self.buffer = Some(sequence);
        Ok(())
    }

    /// Plays one cycle: the buffered sequence's input for it, or the default input. Thesis (3.10)-(3.12).
    pub fn step(&mut self) -> Applied<T, NU> {
        let tick = self.tick;
        let played = self.buffer.as_ref().and_then(|sequence| {
            let age = u8::try_from(tick.age_of(sequence.tick)?).ok()?;
            sequence.input_at(tick).map(|input| (*input, Age::Steps(age)))
        });
        let (input, age) = played.unwrap_or_else(|| {
            // A sequence older than any that could still arrive: forget it before its tick can wrap.
            if self.buffer.as_ref().is_some_and(|sequence| tick.since(sequence.tick) >= N as i32) {
                self.buffer = None;
            }
            match self.settings.default_input {
                DefaultInput::Zero => (SVector::zeros(), Age::Empty),
                DefaultInput::Hold => (self.last_input, Age::Empty),
            }
        });
        self.last_input = self.settings.saturate(&input);
        self.played.write(age);
        self.tick += 1;
        Applied { tick, input: self.last_input, age }
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
        let newest = self.played.oldest_ordered().rev().take(cycles.clamp(1, MOST_AGES));
        Some(Acknowledgement { tick: self.tick - 1, ages: newest.copied().collect() })
    }
}
