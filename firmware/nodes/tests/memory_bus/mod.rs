//! A CAN controller made of memory: what it has received, what it has sent, and how much room there is.

#[path = "../../../core/tests/can_bus/frame.rs"]
mod frame;
pub(crate) mod frames;

use embedded_can::{ErrorKind, Id, StandardId, nb::Can};
use slqg::blob::DesignId;
use slqg::nalgebra::SVector;
use slqg::wire::can::{Grid, Identifiers, LARGEST_OF_FULL_FRAME};
use slqg_nodes::can::Form;
use std::collections::VecDeque;

pub(crate) use frame::BusFrame;

/// A driver with transmit mailboxes. A frame with a lower identifier than all that wait takes the place of the last one.
#[derive(Debug)]
pub(crate) struct Memory {
    pub(crate) received: VecDeque<Result<BusFrame, ErrorKind>>,
    pub(crate) mailboxes: Vec<BusFrame>,
    pub(crate) room: usize,
}

impl Memory {
    pub(crate) fn with_room(room: usize) -> Self {
        Self { received: VecDeque::new(), mailboxes: Vec::new(), room }
    }
}

fn number(id: Id) -> u16 {
    match id {
        Id::Standard(id) => id.as_raw(),
        Id::Extended(_) => unreachable!("the tests have none"),
    }
}

impl Can for Memory {
    type Frame = BusFrame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &BusFrame) -> nb::Result<Option<BusFrame>, ErrorKind> {
        if self.mailboxes.len() < self.room {
            self.mailboxes.push(frame.clone());
            return Ok(None);
        }
        let is_most_urgent = self.mailboxes.iter().all(|other| number(frame.id) < number(other.id));
        let last = (0..self.mailboxes.len()).max_by_key(|place| number(self.mailboxes[*place].id));
        match last.filter(|_| is_most_urgent) {
            Some(place) => Ok(Some(std::mem::replace(&mut self.mailboxes[place], frame.clone()))),
            None => Err(nb::Error::WouldBlock),
        }
    }

    fn receive(&mut self) -> nb::Result<BusFrame, ErrorKind> {
        match self.received.pop_front() {
            Some(Ok(frame)) => Ok(frame),
            Some(Err(error)) => Err(nb::Error::Other(error)),
            None => Err(nb::Error::WouldBlock),
        }
    }
}

pub(crate) fn standard(id: u16) -> Id {
    Id::Standard(StandardId::new(id).expect("11 bits"))
}

/// The plant of the loop.
pub(crate) const DESIGN: DesignId = DesignId(0x1122_3344);

pub(crate) const CLOCK: u16 = 0x080;
pub(crate) const MEASUREMENT: u16 = 0x120;
pub(crate) const CONTROL: u16 = 0x121;
pub(crate) const ACKNOWLEDGEMENT: u16 = 0x122;

pub(crate) fn identifiers() -> Identifiers {
    Identifiers {
        measurement: standard(MEASUREMENT),
        control: standard(CONTROL),
        acknowledgement: standard(ACKNOWLEDGEMENT),
    }
}

pub(crate) fn grid<const D: usize>(step: f32) -> Grid<f32, D> {
    Grid { step: SVector::from_element(step), largest_count: LARGEST_OF_FULL_FRAME }
}

/// Inputs in steps of 1/8, outputs in steps of 1/4.
pub(crate) fn form<const NU: usize, const NY: usize>() -> Form<f32, NU, NY> {
    Form::new(DESIGN, standard(CLOCK), identifiers(), grid(0.125), grid(0.25)).expect("a form")
}
