//! The programs of both boards on one line with frames of every kind, whose checksums are right: what they send is a frame of the loop and
//! finite, a cycle is applied once, and the time changes only if several clock frames say so.

mod desk;

use crate::script::{any_bytes, any_frame, number, tick_near, up_to, whole, with_checksum};
use arbitrary::{Result, Unstructured};
use desk::Desk;
use slqg::nalgebra::SVector;
use slqg::wire::{self, Clock, GainsPart, Kind, Measurement, Reference};
use slqg::{Tick, blob};
use slqg_nodes::board::Node;
use slqg_nodes::design::{ACTUATOR_MEMORY, GAINS, INPUTS, Memory, OUTPUTS, STATES, Scalar};
use slqg_nodes::dimensions::DESIGN_ID;
use slqg_nodes::laws::{BANK_MEMORY, LARGEST_PART, Sent};
use slqg_nodes::{actuator, controller};

/// Bytes of a frame, and room for more.
const BUFFER: usize = 96;

/// Plays a script of what comes over the line.
pub fn check(bytes: &[u8]) {
    // A script that ends early has ended.
    let _ = play(&mut Unstructured::new(bytes));
}

fn play(script: &mut Unstructured<'_>) -> Result<()> {
    let (mut memory, mut bank, mut of_actuator) = (Memory::new(), [0.0; BANK_MEMORY], ACTUATOR_MEMORY);
    let mut laws = Sent::new(&mut bank);
    let mut ends = Ends {
        controller: controller::Node::new(&mut memory, &mut laws),
        actuator: actuator::Node::new(&mut of_actuator),
        of_controller: Desk::default(),
        of_actuator: Desk::default(),
        next: tick_near(script, Tick(0))?,
    };
    ends.controller.start(&mut ends.of_controller);
    ends.actuator.start(&mut ends.of_actuator);
    while !script.is_empty() {
        ends.of_controller.sent();
        ends.of_actuator.sent();
        event(&mut ends, script)?;
    }
    Ok(())
}

/// Both ends, and the line between them.
struct Ends<'m> {
    controller: controller::Node<'m, Sent<'m>>,
    actuator: actuator::Node<'m>,
    of_controller: Desk,
    of_actuator: Desk,
    /// The cycle that the clock is to tell next.
    next: Tick,
}

fn event(ends: &mut Ends<'_>, script: &mut Unstructured<'_>) -> Result<()> {
    let mut buffer = [0; BUFFER];
    match up_to(script, 9)? {
        0..=2 => {
            ends.tell(ends.next, Clock { begins: true, period_us: 20_000 });
            ends.next += 1;
            let is_lost = up_to(script, 3)? == 0;
            ends.exchange(is_lost);
        }
        3 => {
            let (tick, kind) = (tick_near(script, ends.next)?, up_to(script, 3)?);
            ends.tell(tick, Clock { begins: kind & 1 == 1, period_us: u32::from(kind & 2) });
        }
        4 => {
            ends.controller.period_over(&mut ends.of_controller);
            ends.actuator.period_over(&mut ends.of_actuator);
        }
        5 => {
            let output = SVector::<Scalar, OUTPUTS>::from_fn(|_, _| number(script).unwrap_or_default());
            let measurement = Measurement { tick: tick_near(script, ends.next)?, output };
            let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
            ends.controller.take(frame, &mut ends.of_controller);
        }
        6 => {
            let inputs = [SVector::<Scalar, INPUTS>::repeat(number(script)?); 2];
            let sequence =
                slqg::sequence::ControlSequence { tick: tick_near(script, ends.next)?, inputs: &inputs };
            let frame = wire::encode_control(&sequence, &mut buffer).expect("there is room");
            ends.actuator.take(frame, &mut ends.of_actuator);
        }
        7 => ends.gains(script)?,
        8 => {
            let frame = match up_to(script, 2)? {
                0 => any_frame(script, ends.next)?,
                1 => whole(any_bytes(script)?),
                _ => {
                    let reference = Reference::<Scalar, 1, 4> {
                        tick: tick_near(script, ends.next)?,
                        samples: (0..up_to(script, 4)?)
                            .filter_map(|_| Some(SVector::repeat(number(script).ok()?)))
                            .collect(),
                    };
                    wire::encode_reference(&reference, &mut buffer).expect("there is room").to_vec()
                }
            };
            ends.take(&frame);
        }
        _ => {
            let question =
                [&[1, Kind::Question as u8, 4][..], any_bytes(script)?.get(..4).unwrap_or(&[0; 4])].concat();
            ends.take(&with_checksum(&question));
        }
    }
    Ok(())
}

impl Ends<'_> {
    /// Hands a frame to both.
    fn take(&mut self, frame: &[u8]) {
        self.controller.take(frame, &mut self.of_controller);
        self.actuator.take(frame, &mut self.of_actuator);
    }

    fn tell(&mut self, tick: Tick, clock: Clock) {
        let mut buffer = [0; BUFFER];
        let frame =
            wire::encode_service::<Scalar, _>(tick, &clock, &mut buffer).expect("there is room").to_vec();
        self.take(&frame);
    }

    /// Hands what one end has sent to the other.
    fn exchange(&mut self, is_lost: bool) {
        let (down, up) = (self.of_controller.sent(), self.of_actuator.sent());
        for frame in down.iter().filter(|_| !is_lost) {
            self.actuator.take(frame, &mut self.of_actuator);
            self.of_actuator.sent();
        }
        for frame in up.iter().filter(|_| !is_lost) {
            self.controller.take(frame, &mut self.of_controller);
            self.of_controller.sent();
        }
    }

    /// Gains of the node's own design, in parts, of which one may be another.
    fn gains(&mut self, script: &mut Unstructured<'_>) -> Result<()> {
        let shape = blob::Shape {
            length: GAINS.length(),
            states: STATES,
            inputs: INPUTS,
            default_input: GAINS.default_input(),
        };
        let number = number::<Scalar>(script)?;
        let numbers = vec![if number.is_finite() { number } else { 0.5 }; blob::storage_len(&shape)];
        let (lx, rest) = numbers.split_at(shape.length * INPUTS * STATES);
        let (m, _) = rest.split_at(shape.length * INPUTS * GAINS.in_flight() * INPUTS);
        let chances = vec![0.5; GAINS.arrival_table().len()];
        let tables = slqg::gains::Tables::check(lx, m, &chances).expect("finite");
        let mut bytes = vec![0; blob::encoded_len(&shape, 4)];
        blob::encode(DESIGN_ID, &shape, &tables, &mut bytes).expect("there is room");
        let (transfer, wrong, change) =
            (up_to(script, 3)?, up_to(script, u8::MAX)?, script.arbitrary::<u8>()?);
        if let Some(byte) = bytes.get_mut(usize::from(wrong)) {
            *byte ^= change;
        }
        for (place, part) in bytes.chunks(LARGEST_PART).enumerate() {
            let part = GainsPart {
                transfer: transfer.into(),
                offset: (place * LARGEST_PART) as u16,
                total: bytes.len() as u16,
                bytes: part,
            };
            let mut buffer = [0; BUFFER];
            let frame = wire::encode_gains_part::<Scalar>(&part, &mut buffer).expect("there is room");
            self.controller.take(frame, &mut self.of_controller);
            self.of_controller.sent();
        }
        Ok(())
    }
}
