//! The main loop of a node on the bus, and what the node sees of the part.
//!
//! It polls: the CAN controller filters and keeps three frames by itself, and a node that sleeps saves nothing that a plant
//! would notice. One frame, then the timer, then the next: no burst on the bus holds up the cycle or the watchdog.

use crate::{bus, output, part, part::Part};
use bxcan::Can;
use slqg::{actuator::Applied, wire::Role};
use slqg_nodes::{
    board::{Board, Node, Notice, Usage},
    can::{LONGEST, Line, taken_by},
    design::{INPUTS, OUTPUTS, Scalar},
};
use stm32f4xx_hal::can::Can1;

/// Runs a node, for ever.
pub fn run<N: Node>(mut node: N, role: Role) -> ! {
    let (part, can) = Part::start(role);
    let mut machine = Machine { part, line: Line::new(can, bus::form(), taken_by(role)) };
    let mut buffer = [0; LONGEST];
    node.start(&mut machine);
    loop {
        machine.part.feed_watchdog();
        machine.line.flush();
        if let Some(frame) = machine.line.receive(&mut buffer) {
            node.take(frame, &mut machine);
        }
        if machine.part.period_is_over() {
            node.period_over(&mut machine);
        }
    }
}

/// The part and the bus as the node sees them.
struct Machine {
    part: Part,
    line: Line<Can<Can1>, Scalar, INPUTS, OUTPUTS>,
}

impl Board for Machine {
    fn send(&mut self, frame: &[u8]) {
        self.line.send(frame);
    }

    fn restart_period(&mut self) {
        self.part.restart_period();
    }

    fn apply(&mut self, applied: &Applied<Scalar, INPUTS>) {
        output::put(&mut self.part.output, applied);
    }

    fn ticks(&self) -> u32 {
        part::ticks()
    }

    fn elapsed(&self, begin: u32) -> u32 {
        part::ticks().wrapping_sub(begin)
    }

    fn usage(&self) -> Usage {
        // Nobody on the bus asks for the memory; a debugger shows it better.
        Usage { overruns: self.line.lost().total(), ..Usage::default() }
    }

    fn note(&mut self, notice: Notice) {
        match notice {
            Notice::Aligned(_) => self.part.led.set_low(),
            Notice::Realigned(_) | Notice::ClockRefused(_) | Notice::Safe => self.part.led.set_high(),
            Notice::Health(health) if health.is_nominal() => self.part.led.set_low(),
            Notice::Health(_) => self.part.led.set_high(),
            Notice::Gains(_) | Notice::Tuned(_) | Notice::Rejected(_) => (),
        }
    }
}
