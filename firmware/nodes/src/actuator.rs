//! The actuator node: takes control frames and the clock, applies inputs, acknowledges what it applied.

use crate::board::{self, Board, Notice};
use crate::clock::{Begin, Count};
use crate::design::{
    self, ACKNOWLEDGED_CYCLES, ACTUATOR, ACTUATOR_CHECKSUM, INPUTS, SEQUENCE_LENGTH, Scalar,
};
use crate::health::Health;
use slqg::{
    Age, Scalar as _, Tick,
    actuator::Applied,
    nalgebra::SVector,
    wire::{self, Clock, Kind, Role},
};

/// Bytes of the longest frame that is meant for this node.
pub const LONGEST_IN: usize = {
    let control = wire::control_len(INPUTS, SEQUENCE_LENGTH, Scalar::BYTES);
    if control > wire::LONGEST_SERVICE { control } else { wire::LONGEST_SERVICE }
};
/// Bytes of the longest frame that it sends.
pub const LONGEST_OUT: usize = {
    let applied = wire::applied_len(INPUTS, Scalar::BYTES);
    if applied > wire::LONGEST_SERVICE { applied } else { wire::LONGEST_SERVICE }
};
/// Numbers of the settings that are checked in each cycle, once the plant has its input.
pub const CHECKED_NUMBERS: usize = 4;
/// Periods of the cycle timer without a cycle, after which the plant gets the safe input.
pub const PATIENCE: u32 = {
    // Two seconds, and no less than a hundred cycles.
    let periods = (2.0 / design::SAMPLE_TIME) as u32;
    if periods > 100 { periods } else { 100 }
};

/// The actuator end of the loop, with a host and a clock.
///
/// What it applies when packets fail to come is the design's default input, and after a while its safe input, if it has one. That, or
/// else zero within the limits, is also for when the node itself does not know what to do: before the first clock frame, and when the clock that it was told to
/// wait for has stopped.
pub struct Node<'m> {
    actuator: design::Actuator<'m>,
    /// Whether the clock has told which cycle it is.
    is_aligned: bool,
    count: Count,
    /// Periods since the last cycle.
    idle: u32,
    health: Health,
    frame: [u8; LONGEST_OUT],
}

impl<'m> Node<'m> {
    /// A node that knows nothing yet.
    pub fn new(memory: &'m mut design::ActuatorMemory) -> Self {
        Self {
            actuator: design::Actuator::new(ACTUATOR, Tick(0), memory),
            is_aligned: false,
            count: Count::default(),
            idle: 0,
            health: Health::default(),
            frame: [0; LONGEST_OUT],
        }
    }
}

impl board::Node for Node<'_> {
    fn start(&mut self, board: &mut impl Board) {
        self.health.tell(Role::Actuator, &self.count, &mut self.frame, board);
    }

    fn take(&mut self, frame: &[u8], board: &mut impl Board) {
        let taken = match Kind::of(frame) {
            Some(Kind::Clock) => match wire::decode_service::<Scalar, Clock>(frame) {
                Ok((tick, clock)) => {
                    let begin = self.count.told(tick, clock);
                    self.begin(begin, board);
                    true
                }
                Err(_) => false,
            },
            Some(Kind::Question) if Health::is_asked(frame) => {
                self.start(board);
                true
            }
            // Before the first clock frame nobody can tell how old it is.
            _ => self.is_aligned && self.actuator.receive(frame).is_ok(),
        };
        if !taken {
            self.health.rejected(frame, board);
        }
    }

    fn period_over(&mut self, board: &mut impl Board) {
        self.idle = self.idle.saturating_add(1);
        let begin = self.count.period_over();
        self.begin(begin, board);
        if self.idle == PATIENCE {
            board.note(Notice::Safe);
            let input = self.safe_input();
            board.apply(&input);
            self.report(&input, board);
        }
    }

    fn safe_frame<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8] {
        wire::encode_applied(&self.safe_input(), buffer).unwrap_or_default()
    }
}

impl Node<'_> {
    fn safe_input(&self) -> Applied<Scalar, INPUTS> {
        let tick = self.count.next().unwrap_or_default();
        let input = ACTUATOR.safe.map_or_else(SVector::zeros, |safe| safe.input);
        Applied { tick, input: ACTUATOR.saturate(&input), age: Age::Empty }
    }

    fn begin(&mut self, begin: Begin, board: &mut impl Board) {
        match begin {
            Begin::Nothing => return,
            Begin::Refused(tick) => return self.health.clock_refused(tick, board),
            Begin::Next => (),
            Begin::Align(tick) => return self.align(tick, board),
            Begin::Anew(tick) => self.align(tick, board),
        }
        board.restart_period();
        self.idle = 0;
        self.cycle(board);
    }

    /// Begins anew with cycle `tick`, the buffer empty: its sequences count cycles that are not these.
    fn align(&mut self, tick: Tick, board: &mut impl Board) {
        self.health.aligned(!self.is_aligned, tick, board);
        self.actuator.restart(tick);
        self.is_aligned = true;
        // Nothing is begun with settings that are wrong.
        self.actuator.check_memory(ACTUATOR_CHECKSUM, usize::MAX);
    }

    fn cycle(&mut self, board: &mut impl Board) {
        if !self.is_aligned {
            return;
        }
        // Both count the same cycles, or one of them counts wrong.
        if self.count.next() != Some(self.actuator.tick() + 1) {
            self.actuator.report_memory_fault();
        }
        let applied = self.actuator.step();
        self.health.ran();
        self.health.is(self.actuator.health(), board);
        let told = self.actuator.acknowledgement(ACKNOWLEDGED_CYCLES);
        // The plant first: it waits.
        board.apply(&applied);
        if let Some(Ok(frame)) =
            told.map(|told| wire::encode_acknowledgement::<Scalar>(&told, &mut self.frame))
        {
            board.send(frame);
        }
        self.report(&applied, board);
        self.actuator.check_memory(ACTUATOR_CHECKSUM, CHECKED_NUMBERS);
    }

    fn report(&mut self, applied: &Applied<Scalar, INPUTS>, board: &mut impl Board) {
        if let Ok(frame) = wire::encode_applied(applied, &mut self.frame) {
            board.send(frame);
        }
    }
}
