//! The check of compact frames: what it is computed from, and that frames that are old, another plant's, of another kind or
//! damaged are refused.

mod can_bus;
#[path = "random/dice.rs"]
mod dice;
mod lent;

use can_bus::{BusFrame, DESIGN, compact, compact_of, standard};
use crc::{CRC_8_GSM_A, CRC_8_SAE_J1850, Crc};
use dice::Dice;
use embedded_can::Frame;
use nalgebra::SVector;
use slqg::actuator::Settings;
use slqg::blob::DesignId;
use slqg::wire::can::{Check, UnpackError};
use slqg::wire::{
    Acknowledgement, Kind, Measurement, encode_acknowledgement, encode_control, encode_measurement,
};
use slqg::{Age, DefaultInput, Tick, nalgebra, sequence::ControlSequence};

const KINDS: [(Kind, u16); 3] =
    [(Kind::Measurement, 0x120), (Kind::Control, 0x121), (Kind::Acknowledgement, 0x122)];
const NOW: Tick = Tick(0x0102_4000);

fn word(dice: &mut Dice) -> u32 {
    dice.roll();
    (dice.0 >> 32) as u32
}

/// Bit by bit, as the polynomial division is written down.
fn bitwise(bytes: &[u8]) -> u8 {
    let divided = bytes.iter().fold(0xff_u8, |rest, byte| {
        (0..8).fold(rest ^ byte, |rest, _| if rest & 0x80 == 0 { rest << 1 } else { rest << 1 ^ 0x1d })
    });
    !divided
}

/// One frame of every kind and length that the loop has, of cycle `tick`.
fn frames(tick: Tick) -> Vec<BusFrame> {
    let mut buffer = [0; 64];
    let output = SVector::from([1.0_f32, -2.5]);
    let mut full =
        vec![encode_measurement(&Measurement { tick, output }, &mut buffer).expect("room").to_vec()];
    let inputs = [3.0_f32, -6.0, 12.0].map(|input| SVector::from([input]));
    for length in 1..=3 {
        let sequence = ControlSequence { tick, inputs: &inputs[..length] };
        full.push(encode_control(&sequence, &mut buffer).expect("room").to_vec());
    }
    for cycles in 1..=5 {
        let told = Acknowledgement { tick, ages: [Age::Steps(1); 5].into_iter().take(cycles).collect() };
        full.push(encode_acknowledgement::<f32>(&told, &mut buffer).expect("room").to_vec());
    }
    full.iter().map(|frame| compact::<f32>().pack(frame).expect("fits")).collect()
}

fn refusal(frame: &BusFrame, now: Tick) -> Option<UnpackError> {
    compact::<f32>().unpack(frame, now, &mut [0; 64]).err()
}

#[test]
fn the_checksum_is_that_of_the_published_tables() {
    let crate_of = Crc::<u8>::new(&CRC_8_SAE_J1850);
    // AUTOSAR, specification of the CRC library: examples of the 8-bit SAE J1850 CRC; the last one is the catalogue's.
    for (bytes, expected) in [
        (&[0, 0, 0, 0][..], 0x59),
        (&[0xf2, 0x01, 0x83], 0x37),
        (&[0x0f, 0xaa, 0x00, 0x55], 0x79),
        (&[0x00, 0xff, 0x55, 0x11], 0xb8),
        (&[0x33, 0x22, 0x55, 0xaa, 0xbb, 0xcc, 0xdd, 0xee, 0xff], 0xcb),
        (&[0x92, 0x6b, 0x55], 0x8c),
        (&[0xff, 0xff, 0xff, 0xff], 0x74),
        (b"123456789", 0x4b),
    ] {
        assert_eq!((crate_of.checksum(bytes), bitwise(bytes)), (expected, expected), "{bytes:02x?}");
    }
    // AUTOSAR, E2E protocol, example of profile 1: Data ID 0x0123, both bytes, counter 0, all data 0. Its start value and
    // final xor cancel each other, the polynomial is the same.
    assert_eq!(Crc::<u8>::new(&CRC_8_GSM_A).checksum(&[0x23, 0x01, 0, 0, 0, 0, 0, 0, 0]), 0xcc);
}

#[test]
fn the_check_is_over_form_design_kind_upper_half_of_the_tick_and_all_that_is_sent() {
    let mut dice = Dice(1);
    for _ in 0..2000 {
        let (design, tick) = (word(&mut dice), word(&mut dice));
        let data = [word(&mut dice).to_le_bytes(), word(&mut dice).to_le_bytes()].concat();
        for (kind, _) in KINDS {
            let mut all = vec![2];
            all.extend(design.to_be_bytes());
            all.push(kind as u8);
            all.extend([(tick >> 24) as u8, (tick >> 16) as u8]);
            all.extend(&data);
            assert_eq!(Check::new(DesignId(design)).of(kind, Tick(tick), &data), bitwise(&all));
        }
    }
}

#[test]
fn a_frame_from_another_round_of_the_lower_half_is_refused_where_it_used_to_be_applied() {
    for tick in [0, 1, 0x0000_ffff, 0x0102_0304, 0x7fff_ffff, 0x8000_0000, u32::MAX].map(Tick) {
        for frame in frames(tick) {
            assert_eq!(refusal(&frame, tick), None);
            // One, two, four, .. rounds later, and earlier: always.
            for rounds in (0..16).map(|power| 1_u32 << (16 + power)) {
                for now in [tick + rounds, tick - rounds] {
                    assert_eq!(refusal(&frame, now), Some(UnpackError::Check), "{tick:?} at {now:?}");
                }
            }
        }
    }
    // Of all other rounds one in 256 passes, for every frame: 255 of 65535.
    for frame in frames(NOW) {
        let passes = (1..=0xffff_u32)
            .filter(|rounds| refusal(&frame, NOW + (rounds << 16)).is_none())
            .collect::<Vec<_>>();
        assert_eq!(passes.len(), 255, "{frame:?}");
        // The first one that passes is 284 rounds old or more: more than five hours at 1 kHz.
        assert!(passes[0] >= 284, "{}", passes[0]);
    }
}

#[test]
fn a_controller_for_another_plant_is_not_obeyed() {
    for frame in frames(NOW) {
        let passes =
            |design: u32| compact_of::<f32>(DesignId(design)).unpack(&frame, NOW, &mut [0; 64]).is_ok();
        assert!(passes(DESIGN.0));
        // Ids that differ within eight bits in a row: always.
        for shift in 0..=24 {
            assert!((1..=255_u32).all(|other| !passes(DESIGN.0 ^ other << shift)), "{frame:?}");
        }
        // Of all others one in 256.
        let passed = (1..=0xffff_u32).filter(|other| passes(DESIGN.0 ^ other)).count();
        assert_eq!(passed, 255);
    }
}

#[test]
fn a_frame_of_another_kind_is_refused_under_every_identifier() {
    for frame in frames(NOW) {
        let others = KINDS.iter().map(|(_, id)| standard(*id)).filter(|id| *id != frame.id());
        for id in others {
            let moved = BusFrame { id, ..frame.clone() };
            let found = refusal(&moved, NOW);
            assert!(
                matches!(found, Some(UnpackError::Check | UnpackError::Length(_))),
                "{moved:?}: {found:?}"
            );
        }
    }
}

/// Whether a frame with these bits wrong is refused. Those of the tick may lead into another round, whose upper half goes into
/// the check: then it may also be one of a cycle that is thousands away, which both ends reject.
fn is_refused(frame: &BusFrame, wrong: &[usize]) -> bool {
    let mut frame = frame.clone();
    wrong.iter().for_each(|bit| frame.data[bit / 8] ^= 0x80 >> (bit % 8));
    match compact::<f32>().unpack(&frame, NOW, &mut [0; 64]) {
        Err(found) => found == UnpackError::Check,
        Ok(full) => {
            let tick = Tick(u32::from_le_bytes([full[3], full[4], full[5], full[6]]));
            tick.0 >> 16 != NOW.0 >> 16 && tick.since(NOW).unsigned_abs() > 4096
        }
    }
}

#[test]
fn one_or_two_wrong_bits_and_every_burst_of_eight_are_refused() {
    for frame in frames(NOW) {
        let bits = 8 * frame.data.len();
        for first in 0..bits {
            assert!(is_refused(&frame, &[first]), "bit {first} of {frame:?}");
            for second in first + 1..bits {
                assert!(is_refused(&frame, &[first, second]), "bits {first}, {second} of {frame:?}");
            }
            // A burst of up to eight bits begins with a wrong one.
            for rest in 0..128_usize {
                let rest = (0..7).filter(|bit| rest >> bit & 1 == 1).map(|bit| first + 1 + bit);
                let burst: Vec<_> = std::iter::once(first).chain(rest).collect();
                if burst.iter().all(|bit| *bit < bits) {
                    assert!(is_refused(&frame, &burst), "bits {burst:?} of {frame:?}");
                }
            }
        }
    }
}

#[test]
fn random_bytes_are_applied_once_in_millions() {
    const FRAMES: u32 = 1 << 23;
    let settings = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
    let mut dice = Dice(7);
    let (mut unpacked, mut applied) = (0_u32, 0);
    let mut actuator = lent::actuator::<f32, 1>(settings, NOW, 3);
    let (form, mut buffer) = (compact::<f32>(), [0; 64]);
    for _ in 0..FRAMES {
        dice.roll();
        let data = dice.0.to_le_bytes().to_vec();
        let frame = BusFrame { id: standard(0x121), is_remote: false, data };
        if let Ok(full) = form.unpack(&frame, NOW, &mut buffer) {
            unpacked += 1;
            if actuator.receive(full).is_ok() {
                applied += 1;
                actuator.restart(NOW);
            }
        }
    }
    // The check lets one in 256 pass, the bit that must be zero one in two, -4096 all but a few.
    let expected = f64::from(FRAMES) / 512.0;
    assert!((f64::from(unpacked) - expected).abs() < 5.0 * expected.sqrt() + 0.01 * expected, "{unpacked}");
    // Three cycles of 65536 are of use: one in eleven million. Without a check it was one in eighteen thousand, 466 of these.
    assert!(applied <= 6, "{applied}");
}
