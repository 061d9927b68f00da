//! The controller node: takes measurements, acknowledgements, references and the clock, sends control frames.

use crate::board::{self, Board, Notice};
use crate::clock::{Begin, Count};
use crate::design::{self, DESIGN, INPUTS, OUTPUTS, SEQUENCE_LENGTH, Scalar};
use crate::dimensions::{CHECKSUMS, JOINING, TRACKED_OUTPUTS};
use crate::health::Health;
use crate::laws::{LARGEST_PART, Laws};
use crate::reference::{PER_FRAME, Window};
use slqg::{
    Scalar as _, Tick,
    controller::Design,
    wire::{self, Clock, Kind, Ran, Role, Verdict},
};

/// Bytes of the longest frame that is meant for this node.
pub const LONGEST_IN: usize = longest(&[
    wire::gains_part_len(LARGEST_PART),
    wire::measurement_len(OUTPUTS, Scalar::BYTES),
    wire::LONGEST_ACKNOWLEDGEMENT,
    wire::reference_len(TRACKED_OUTPUTS, PER_FRAME, Scalar::BYTES),
    wire::LONGEST_SERVICE,
]);
/// Bytes of the longest frame that it sends.
pub const LONGEST_OUT: usize =
    longest(&[wire::control_len(INPUTS, SEQUENCE_LENGTH, Scalar::BYTES), wire::LONGEST_SERVICE]);

/// Numbers of the tables that are checked in each cycle, once its frame is on its way.
pub const CHECKED_NUMBERS: usize = 64;

const fn longest(lengths: &[usize]) -> usize {
    let (mut longest, mut rest) = (0, lengths);
    while let [length, others @ ..] = rest {
        longest = if *length > longest { *length } else { longest };
        rest = others;
    }
    longest
}

/// The controller end of the loop, with a host and a clock; `L` is where its gains come from beside its design.
pub struct Node<'m, L> {
    /// `None` if the design did not fit together, which the generator rules out.
    controller: Option<design::Controller<'m>>,
    /// Whether the clock has told which cycle it is.
    is_aligned: bool,
    count: Count,
    reference: Window,
    laws: &'m mut L,
    /// Time spent on frames since the last cycle, in the board's ticks.
    taking: u32,
    health: Health,
    frame: [u8; LONGEST_OUT],
}

impl<'m, L: Laws> Node<'m, L> {
    /// A node that knows nothing yet.
    // Apart from the main loop, whose stack would keep what only the start needs.
    #[inline(never)]
    pub fn new(memory: &'m mut design::Memory, laws: &'m mut L) -> Self {
        Self {
            controller: design::Controller::new(DESIGN, Tick(0), memory.lend()).ok(),
            is_aligned: false,
            count: Count::default(),
            reference: Window::default(),
            laws,
            taking: 0,
            health: Health::default(),
            frame: [0; LONGEST_OUT],
        }
    }
}

impl<L: Laws> board::Node for Node<'_, L> {
    fn start(&mut self, board: &mut impl Board) {
        self.health.tell(Role::Controller, &self.count, &mut self.frame, board);
    }

    fn take(&mut self, frame: &[u8], board: &mut impl Board) {
        let begin = board.ticks();
        let taken = match Kind::of(frame) {
            Some(Kind::Clock) => match wire::decode_service::<Scalar, Clock>(frame) {
                Ok((tick, clock)) => {
                    let begin = self.count.told(tick, clock);
                    self.begin(begin, board);
                    return;
                }
                Err(_) => false,
            },
            Some(Kind::Question) if Health::is_asked(frame) => {
                self.start(board);
                true
            }
            Some(Kind::Reference) => {
                wire::decode_reference(frame).map(|reference| self.reference.take(&reference)).is_ok()
            }
            Some(Kind::GainsPart) => self.replace_gains(frame, board),
            // Before the first clock frame nobody can tell how old it is.
            _ => self.controller().is_some_and(|controller| controller.receive(frame).is_ok()),
        };
        if !taken {
            self.health.rejected(frame, board);
        }
        self.taking = self.taking.wrapping_add(board.elapsed(begin));
    }

    fn period_over(&mut self, board: &mut impl Board) {
        let begin = self.count.period_over();
        self.begin(begin, board);
    }

    fn safe_frame<'b>(&mut self, _buffer: &'b mut [u8]) -> &'b [u8] {
        // The actuator plays on, and knows what to do when it has played out.
        &[]
    }
}

impl<'m, L: Laws> Node<'m, L> {
    fn begin(&mut self, begin: Begin, board: &mut impl Board) {
        match begin {
            Begin::Nothing => return,
            Begin::Refused(tick) => return self.health.clock_refused(tick, board),
            Begin::Next => (),
            Begin::Align(tick) => return self.align(tick, board),
            Begin::Anew(tick) => self.align(tick, board),
        }
        board.restart_period();
        self.cycle(board);
    }

    /// Begins anew with cycle `tick`: of what was sent before, nothing is known to be right any more.
    // As `new`.
    #[inline(never)]
    fn align(&mut self, tick: Tick, board: &mut impl Board) {
        self.health.aligned(!self.is_aligned, tick, board);
        // Cycle 0 begins with the design's initial state. In any other the loop has been running, and may be anywhere.
        let is_start = tick == Tick(0);
        let design = if is_start { DESIGN } else { Design { model: &JOINING, ..DESIGN } };
        let Some(controller) = &mut self.controller else { return };
        self.is_aligned = controller.restart(design, tick).is_ok();
        // Nothing is begun with tables that are wrong.
        while !controller.check_memory(&CHECKSUMS, usize::MAX) {}
    }

    /// The controller, once the clock has told which cycle it is.
    fn controller(&mut self) -> Option<&mut design::Controller<'m>> {
        self.controller.as_mut().filter(|_| self.is_aligned)
    }

    fn cycle(&mut self, board: &mut impl Board) {
        let Some(controller) = self.controller.as_mut().filter(|_| self.is_aligned) else { return };
        let begin = board.ticks();
        let tick = controller.tick();
        // Both count the same cycles, or one of them counts wrong.
        if self.count.next() != Some(tick + 1) {
            controller.report_memory_fault();
        }
        if DESIGN.preview.is_some() {
            // Without samples the last feedforward stays in force.
            let _ = controller.follow(self.reference.from(tick + 1));
        }
        // A frame that could not be written is one that is lost.
        self.laws.observe(controller);
        let sequence = match self.laws.law() {
            None => controller.cycle(&mut self.frame).ok().flatten(),
            Some(law) => controller.cycle_under(&law, &mut self.frame).ok().flatten(),
        };
        let sent = sequence.is_some();
        if let Some(sequence) = sequence {
            board.send(sequence);
        }
        let duration = self.taking.wrapping_add(board.elapsed(begin));
        self.taking = 0;
        self.health.ran();
        self.health.is(controller.health(), board);
        // The frame is on its way: what is done now delays nothing but what comes before the next cycle.
        if let Some(tuned) = self.laws.work() {
            board.note(Notice::Tuned(tuned.step));
            if let Ok(frame) = wire::encode_service::<Scalar, _>(tick, &tuned, &mut self.frame) {
                board.send(frame);
            }
        }
        if let Ok(frame) = wire::encode_service::<Scalar, _>(tick, &Ran { sent, duration }, &mut self.frame) {
            board.send(frame);
        }
        if !self.laws.check_memory(CHECKED_NUMBERS) {
            controller.report_memory_fault();
        }
        controller.check_memory(&CHECKSUMS, CHECKED_NUMBERS);
    }

    #[inline(never)]
    fn replace_gains(&mut self, frame: &[u8], board: &mut impl Board) -> bool {
        let Ok(part) = wire::decode_gains_part::<Scalar>(frame) else { return false };
        let answer = self.laws.take(&part);
        if answer.verdict != Verdict::Incomplete {
            board.note(Notice::Gains(answer.verdict));
        }
        let transfer = Tick(part.transfer);
        if let Ok(frame) = wire::encode_service::<Scalar, _>(transfer, &answer, &mut self.frame) {
            board.send(frame);
        }
        true
    }
}
