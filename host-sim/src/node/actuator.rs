//! The actuator node: the core's [`Actuator`], one cycle at a time on the wall clock.
//!
//! Which sequence is played is the core's to decide. A node that was killed begins again with an empty buffer, and applies
//! the default input until the next sequence comes.

use super::{
    applied::AppliedInput,
    arrivals::Arrivals,
    clock::{Due, Pacer, WallTime, tick_of},
    clock_offset::{ClockOffset, Way},
    event_loop::{Channel, Node, Outbox},
    statistics::{Figure, Mean, Punctuality, Section},
};
use crate::size_class::LONGEST_SEQUENCE;
use nalgebra::SVector;
use slqg::{
    Scalar, Tick,
    actuator::{Actuator, Settings},
    wire::{LONGEST_ACKNOWLEDGEMENT, decode_control, encode_acknowledgement},
};

/// Frames kept for one cycle; more are a flood, and lost.
const INBOX: usize = 256;

/// An actuator in real time.
#[derive(Debug)]
pub struct ActuatorNode<'m, T: Scalar, const NU: usize> {
    /// The design's own, without padding.
    inputs: usize,
    /// Cycles that an acknowledgement tells; none are sent if 0.
    acknowledged_cycles: usize,
    pacer: Pacer,
    core: Actuator<'m, T, NU>,
    has_begun: bool,
    /// Frames since the last cycle. The core takes none of a cycle that it has not caught up with.
    inbox: Vec<Vec<u8>>,
    punctuality: Punctuality,
    control_frames: Arrivals,
    controller_clock: ClockOffset,
    default_inputs: u64,
    age: Mean,
    rejected: u64,
    overflowed: u64,
}

impl<'m, T: Scalar, const NU: usize> ActuatorNode<'m, T, NU> {
    /// A node with an empty buffer and `inputs` inputs. Its acknowledgements tell `acknowledged_cycles` cycles; of 0 it
    /// sends none.
    pub fn new(
        settings: Settings<T, NU>,
        inputs: usize,
        acknowledged_cycles: usize,
        pacer: Pacer,
        punctuality: Punctuality,
        memory: &'m mut [SVector<T, NU>],
    ) -> Self {
        Self {
            inputs,
            acknowledged_cycles,
            pacer,
            core: Actuator::new(settings, Tick(0), memory),
            has_begun: false,
            inbox: Vec::new(),
            punctuality,
            control_frames: Arrivals::default(),
            controller_clock: ClockOffset::new(Way::Link),
            default_inputs: 0,
            age: Mean::default(),
            rejected: 0,
            overflowed: 0,
        }
    }

    fn cycle(&mut self, cycle: u64, outbox: &mut Outbox) {
        let tick = tick_of(cycle);
        if !self.has_begun {
            self.core.restart(tick);
            self.has_begun = true;
        }
        let core = &mut self.core;
        // Cycles that nobody woke up in: what would have been played in them is not applied any more.
        while tick.is_after(core.tick()) {
            core.step();
        }
        for frame in self.inbox.drain(..) {
            self.rejected += u64::from(core.receive(&frame).is_err());
        }
        let applied = core.step();
        match applied.age.steps() {
            Some(age) => self.age.add(age as f64),
            None => self.default_inputs += 1,
        }
        let input = applied.input.iter().take(self.inputs).map(|value| value.widen()).collect();
        outbox.push((Channel::AppliedInput, AppliedInput { tick, age: applied.age, input }.encode()));
        if self.acknowledged_cycles == 0 {
            return;
        }
        let mut frame = [0; LONGEST_ACKNOWLEDGEMENT];
        let told = core.acknowledgement(self.acknowledged_cycles);
        if let Some(Ok(frame)) = told.map(|told| encode_acknowledgement::<T>(&told, &mut frame)) {
            outbox.push((Channel::Acknowledgement, frame.to_vec()));
        }
    }
}

impl<T: Scalar, const NU: usize> Node for ActuatorNode<'_, T, NU> {
    fn next(&self) -> Option<WallTime> {
        Some(self.pacer.next())
    }

    fn act(&mut self, now: WallTime, outbox: &mut Outbox) {
        let due = self.pacer.due(now);
        self.punctuality.note(due);
        match due {
            Due::Nothing => {}
            Due::Act { cycle, .. } => self.cycle(cycle, outbox),
            Due::BeginAnew { cycle, .. } => {
                self.has_begun = false;
                self.cycle(cycle, outbox);
            }
        }
    }

    fn receive(&mut self, packet: &[u8], now: WallTime) {
        let mut room = [SVector::<T, NU>::zeros(); LONGEST_SEQUENCE];
        let Ok(sequence) = decode_control(packet, &mut room) else {
            self.rejected += 1;
            return;
        };
        self.control_frames.note(sequence.tick, self.pacer.timetable(), now);
        self.controller_clock.note(sequence.tick, self.pacer.timetable(), now);
        if self.inbox.len() < INBOX {
            self.inbox.push(packet.to_vec());
        } else {
            self.overflowed += 1;
        }
    }

    fn cycles(&self) -> u64 {
        self.punctuality.cycles()
    }

    fn progress(&self) -> String {
        let (cycles, misses) = (self.cycles(), self.punctuality.misses());
        format!("cycle {cycles}, {misses} missed: default input in {} cycles", self.default_inputs)
    }

    fn findings(&self) -> Vec<String> {
        self.controller_clock.sentence("controller").into_iter().collect()
    }

    fn sections(&self) -> Vec<Section> {
        let actuator = vec![
            ("default_inputs", Figure::Count(self.default_inputs)),
            ("mean_age", Figure::Number(Some(self.age.mean()))),
            ("rejected", Figure::Count(self.rejected)),
            ("overflowed", Figure::Count(self.overflowed)),
            ("controller_clock_ahead", self.controller_clock.figure()),
        ];
        vec![
            self.punctuality.section(),
            ("actuator", actuator),
            ("control_frames", self.control_frames.figures()),
        ]
    }
}
