//! Time by step of a cycle, in ticks of a clock that the caller brings.
//!
//! Which steps there are is said here; what they work on, in `run`.

use crate::Time;
use core::hint::black_box;

/// What of a control cycle is counted apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The sequence from estimate and expected inputs: `U = Lx xhat + M vbar`.
    Law,
    /// `vbar`, from what is under way and what was played.
    ExpectedInputs,
    /// The estimator where every age is acknowledged: one prediction, one update, one cycle remembered.
    Estimator,
    /// The estimator where none is.
    ModeFilter,
    /// What a reference adds to the sequence.
    Feedforward,
    /// What sending the sequence is worth.
    Benefit,
    /// A sequence to bytes.
    EncodeControl,
    /// Bytes to a measurement.
    DecodeMeasurement,
    /// Bytes to an acknowledgement of one cycle.
    DecodeAcknowledgement,
    /// Bytes to a sequence.
    DecodeControl,
    /// The actuator without bytes: a sequence taken in, an input applied, an acknowledgement made.
    PlayOut,
    /// The controller's whole cycle: measurement and acknowledgement taken in as bytes, a frame made.
    ControllerCycle,
    /// The actuator's: a frame taken in, an input applied, an acknowledgement frame made.
    ActuatorCycle,
}

impl Step {
    pub(super) const ALL: [Self; 13] = [
        Self::Law,
        Self::ExpectedInputs,
        Self::Estimator,
        Self::ModeFilter,
        Self::Feedforward,
        Self::Benefit,
        Self::EncodeControl,
        Self::DecodeMeasurement,
        Self::DecodeAcknowledgement,
        Self::DecodeControl,
        Self::PlayOut,
        Self::ControllerCycle,
        Self::ActuatorCycle,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Law => "law",
            Self::ExpectedInputs => "expected-inputs",
            Self::Estimator => "estimator",
            Self::ModeFilter => "mode-filter",
            Self::Feedforward => "feedforward",
            Self::Benefit => "benefit",
            Self::EncodeControl => "encode-control",
            Self::DecodeMeasurement => "decode-measurement",
            Self::DecodeAcknowledgement => "decode-acknowledgement",
            Self::DecodeControl => "decode-control",
            Self::PlayOut => "play-out",
            Self::ControllerCycle => "controller-cycle",
            Self::ActuatorCycle => "actuator-cycle",
        }
    }
}

/// Adds up the time of each step.
pub(super) struct Stopwatch {
    clock: fn() -> u32,
    /// What reading the clock itself takes.
    idle: u32,
    counting: bool,
    times: [Time; Step::ALL.len()],
}

impl Stopwatch {
    pub(super) fn new(clock: fn() -> u32) -> Self {
        let mut stopwatch =
            Self { clock, idle: 0, counting: false, times: [Time::default(); Step::ALL.len()] };
        stopwatch.idle = stopwatch.timed(|| ()).1;
        stopwatch
    }

    /// Counts from now on; what ran before has warmed up what remembers.
    pub(super) fn start(&mut self) {
        self.counting = true;
    }

    /// Does one step. Its result is made within the time; its inputs must be, too: `work` passes them through
    /// [`black_box`], or the compiler may have computed with them before.
    pub(super) fn time<R>(&mut self, step: Step, work: impl FnOnce() -> R) -> R {
        let (result, ticks) = self.timed(work);
        if self.counting {
            self.times[step as usize].add(ticks.saturating_sub(self.idle));
        }
        result
    }

    fn timed<R>(&self, work: impl FnOnce() -> R) -> (R, u32) {
        let begin = black_box(self.clock)();
        let result = work();
        black_box(&result);
        let ticks = black_box(self.clock)().wrapping_sub(begin);
        (result, ticks)
    }

    /// Steps that were done, in the order of a cycle.
    pub(super) fn times(&self) -> impl Iterator<Item = (Step, Time)> + '_ {
        Step::ALL.into_iter().zip(self.times).filter(|(_, time)| time.cycles > 0)
    }
}
