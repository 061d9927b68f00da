//! Frames on a CAN bus: what is unpacked packs into the same CAN frame again, and what is packed comes out as the grid rounds it.

mod bus;

use crate::script::{any_bytes, any_frame, byte, tick_near, up_to, vector};
use arbitrary::{Result, Unstructured};
use bus::{BusFrame, DESIGN, KINDS, identifiers};
use slqg::nalgebra::SVector;
use slqg::sequence::ControlSequence;
use slqg::wire::can::{Check, Compact, FD_CAPACITY, Grid, MOST_VALUES, nearest_tick, pad, unpad};
use slqg::wire::{self, Kind, Measurement};
use slqg::{Scalar, Tick};

/// Bytes of a full frame, and room for more.
const BUFFER: usize = 96;

/// Plays a script: the first bytes say which loop it is, the others what comes over its bus.
pub fn check(bytes: &[u8]) {
    in_flexible_frames(bytes);
    let mut script = Unstructured::new(bytes);
    // A script that ends early has ended.
    let _ = match byte(&mut script).map(|choice| choice % 4) {
        Ok(0) => play::<f32, 1, 2>(&mut script),
        Ok(1) => play::<f64, 2, 1>(&mut script),
        Ok(2) => play::<f32, 3, 3>(&mut script),
        _ => play::<f64, 1, 4>(&mut script),
    };
}

fn play<T: Scalar, const NU: usize, const NY: usize>(script: &mut Unstructured<'_>) -> Result<()> {
    let (inputs, outputs) = (grid::<T, NU>(script)?, grid::<T, NY>(script)?);
    let now = tick_near(script, Tick(1 << 16))?;
    let Ok(compact) = Compact::new(DESIGN, identifiers(), inputs, outputs) else { return Ok(()) };
    while !script.is_empty() {
        match up_to(script, 4)? {
            0 | 1 => arrives(&compact, &bus_frame(script, now)?, now),
            2 => leaves(&compact, &(inputs, outputs), &any_frame(script, now)?),
            3 => {
                let measurement =
                    Measurement::<T, NY> { tick: tick_near(script, now)?, output: vector(script)? };
                let frame =
                    wire::encode_measurement(&measurement, &mut [0; BUFFER]).expect("there is room").to_vec();
                leaves(&compact, &(inputs, outputs), &frame);
            }
            _ => {
                let tick = tick_near(script, now)?;
                let sequence: Vec<SVector<T, NU>> =
                    (0..up_to(script, 4)?).map(|_| vector(script)).collect::<Result<_>>()?;
                let sequence = ControlSequence { tick, inputs: &sequence };
                let frame = wire::encode_control(&sequence, &mut [0; 128]).expect("there is room").to_vec();
                leaves(&compact, &(inputs, outputs), &frame);
            }
        }
    }
    Ok(())
}

fn grid<T: Scalar, const D: usize>(script: &mut Unstructured<'_>) -> Result<Grid<T, D>> {
    Ok(Grid { step: vector::<T, D>(script)?.abs(), largest_count: script.arbitrary::<i16>()? })
}

/// A classic CAN frame: of an identifier of the loop or of another, and mostly with the check that it should have.
fn bus_frame(script: &mut Unstructured<'_>, now: Tick) -> Result<BusFrame> {
    let choice = byte(script)?;
    let mut data = any_bytes(script)?.to_vec();
    // Drivers differ in what they let through: longer ones, too.
    data.truncate(9);
    let which = usize::from(choice % 4);
    let (id, kind) = (bus::id(which), KINDS.get(which));
    let is_checked = choice & 0x40 == 0;
    if let (Some(kind), true, Some((check, rest))) = (kind, is_checked, data.split_last_mut())
        && let Some(low) = rest.first_chunk()
    {
        *check = Check::new(DESIGN).of(*kind, nearest_tick(u16::from_le_bytes(*low), now), rest);
    }
    Ok(BusFrame { id, is_remote: choice & 0x80 != 0, data })
}

/// What is taken from the bus is a frame of this loop, and goes back as it came.
fn arrives<T: Scalar, const NU: usize, const NY: usize>(
    compact: &Compact<T, NU, NY>,
    frame: &BusFrame,
    now: Tick,
) {
    let mut buffer = [0; BUFFER];
    let full = match compact.unpack(frame, now, &mut buffer) {
        Ok(full) => full.to_vec(),
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    assert!(!frame.is_remote && frame.data.len() <= 8);
    assert_ne!(Kind::of(&full), None);
    assert_eq!(compact.pack::<BusFrame>(&full).as_ref(), Ok(frame), "the same frame again");
    assert!(compact.unpack(frame, now, &mut buffer[..full.len() - 1]).is_err(), "no shorter buffer holds it");
}

/// What is put on the bus arrives, rounded to the grid.
fn leaves<T: Scalar, const NU: usize, const NY: usize>(
    compact: &Compact<T, NU, NY>,
    (inputs, outputs): &(Grid<T, NU>, Grid<T, NY>),
    full: &[u8],
) {
    let frame = match compact.pack::<BusFrame>(full) {
        Ok(frame) => frame,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let tick = wire::RawFrame::of(full).expect("a frame").tick();
    let mut buffer = [0; BUFFER];
    let arrived = compact.unpack(&frame, tick, &mut buffer).expect("what was packed");
    match Kind::of(full) {
        Some(Kind::Measurement) => {
            let (sent, arrived) = (measured(full), measured::<T, NY>(arrived));
            assert_eq!(arrived.tick, sent.tick);
            rounded(outputs, &sent.output, &arrived.output);
        }
        Some(Kind::Control) => {
            let mut rooms = [[SVector::zeros(); MOST_VALUES]; 2];
            let [one, other] = &mut rooms;
            let sent = wire::decode_control::<T, NU>(full, one).expect("it was packed");
            let arrived = wire::decode_control::<T, NU>(arrived, other).expect("it has arrived");
            assert_eq!((arrived.tick, arrived.inputs.len()), (sent.tick, sent.inputs.len()));
            sent.inputs.iter().zip(arrived.inputs).for_each(|(sent, arrived)| rounded(inputs, sent, arrived));
        }
        _ => assert_eq!(arrived, full, "an acknowledgement says what it said"),
    }
}

fn measured<T: Scalar, const NY: usize>(frame: &[u8]) -> Measurement<T, NY> {
    wire::decode_measurement(frame).expect("a measurement")
}

/// On the grid, as near as the largest count lets it; and there rounding changes nothing.
fn rounded<T: Scalar, const D: usize>(grid: &Grid<T, D>, sent: &SVector<T, D>, arrived: &SVector<T, D>) {
    assert_eq!(*arrived, grid.round(sent));
    assert_eq!(grid.round(arrived), *arrived, "it stays on the grid");
    for ((sent, arrived), step) in sent.iter().zip(arrived.iter()).zip(grid.step.iter()) {
        let most = T::nearest(f64::from(grid.largest_count)) * *step;
        assert!(arrived.abs() <= most, "no more than the largest count");
        // Half a step, and what the scalar rounds.
        let slack = *step * T::nearest(0.5) + arrived.abs() * T::nearest(4.0) * T::EPSILON;
        assert!(sent.abs() > most || (*sent - *arrived).abs() <= slack, "the nearest on the grid");
    }
}

/// CAN FD: a frame that ends where the padding begins comes out as it was, and nothing else comes out.
fn in_flexible_frames(data: &[u8]) {
    if let Some(frame) = unpad(data) {
        assert_eq!(pad(frame, &mut [0xa5; FD_CAPACITY]), Some(data));
    }
    let mut buffer = [0xa5; FD_CAPACITY];
    let padded = pad(data, &mut buffer).map(<[u8]>::to_vec);
    assert_eq!(padded.is_some(), data.len() <= FD_CAPACITY);
    if let Some(padded) = padded
        && wire::frame_len(data) == Some(data.len())
    {
        assert_eq!(unpad(&padded), Some(data), "the frame ends where it ended");
    }
}
