//! Full frames, and lines between drivers made of memory.

use super::{BusFrame, Memory, form, standard};
use embedded_can::Frame;
use slqg::Age;
use slqg::Tick;
use slqg::nalgebra::{SVector, Vector2};
use slqg::sequence::ControlSequence;
use slqg::wire::{self, Acknowledgement, Clock, Kind, Measurement};
use slqg_nodes::can::{LONGEST, Line};

pub(crate) type Loop = Line<Memory, f32, 1, 2>;

pub(crate) fn line(takes: &'static [Kind]) -> Loop {
    Line::new(Memory::with_room(3), form(), takes)
}

pub(crate) fn clock(tick: u32, clock: Clock) -> Vec<u8> {
    wire::encode_service::<f32, _>(Tick(tick), &clock, &mut [0; 64]).expect("room").to_vec()
}

pub(crate) fn begins(tick: u32) -> Vec<u8> {
    clock(tick, Clock { begins: true, period_us: 20_000 })
}

pub(crate) fn measurement(tick: u32, output: [f32; 2]) -> Vec<u8> {
    let output = Vector2::from(output);
    wire::encode_measurement(&Measurement { tick: Tick(tick), output }, &mut [0; 64]).expect("room").to_vec()
}

pub(crate) fn control<const NU: usize>(tick: u32, inputs: &[f32]) -> Vec<u8> {
    let inputs = inputs.iter().map(|&input| SVector::<f32, NU>::from_element(input)).collect::<Vec<_>>();
    let sequence = ControlSequence { tick: Tick(tick), inputs: &inputs };
    wire::encode_control(&sequence, &mut [0; 256]).expect("room").to_vec()
}

pub(crate) fn acknowledgement(tick: u32, ages: &[Age]) -> Vec<u8> {
    let told = Acknowledgement { tick: Tick(tick), ages: ages.iter().copied().collect() };
    wire::encode_acknowledgement::<f32>(&told, &mut [0; 64]).expect("room").to_vec()
}

/// What is in the mailboxes goes over the bus, into the drivers of both.
pub(crate) fn carry(from: &mut Loop, to: &mut Loop) -> Vec<BusFrame> {
    let sent: Vec<BusFrame> = from.bus().mailboxes.drain(..).collect();
    to.bus().received.extend(sent.iter().cloned().map(Ok));
    sent
}

pub(crate) fn all_received(line: &mut Loop) -> Vec<Vec<u8>> {
    let mut buffer = [0; LONGEST];
    std::iter::from_fn(|| line.receive(&mut buffer).map(<[u8]>::to_vec)).collect()
}

/// A full frame as it is on the bus.
pub(crate) fn packed(frame: &[u8]) -> BusFrame {
    form::<1, 2>().pack(frame).expect("fits")
}

pub(crate) fn hear(line: &mut Loop, id: u16, data: &[u8]) {
    let frame = BusFrame::new(standard(id), data).expect("8 bytes at most");
    line.bus().received.push_back(Ok(frame));
}
