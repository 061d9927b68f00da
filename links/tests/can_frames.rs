//! Lengths and bits of CAN frames, against the standard, published formulas and a frame from the literature.

use rand::{Rng, RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slqg_links::can::{FD_SIZES, Format, Frame, INTERMISSION, Id, Length, Rates, bits};

const FD: Format = Format::Fd { bit_rate_switch: false };
const SWITCHED: Format = Format::Fd { bit_rate_switch: true };

fn base(value: u16) -> Id {
    Id::base(value).unwrap()
}

fn extended(value: u32) -> Id {
    Id::extended(value).unwrap()
}

fn line(bits: &str) -> Vec<bool> {
    bits.chars().filter(|bit| *bit != ' ').map(|bit| bit == '1').collect()
}

/// CRC bit by bit, as the standard writes it down.
fn crc(bits: &[bool], width: u32, polynomial: u32, start: u32) -> u32 {
    let top = 1 << (width - 1);
    bits.iter().fold(start, |register, &bit| {
        let next = bit ^ (register & top != 0);
        ((register << 1) ^ if next { polynomial } else { 0 }) & (2 * top - 1)
    })
}

fn number(bits: &[bool]) -> u32 {
    bits.iter().fold(0, |value, &bit| value << 1 | u32::from(bit))
}

/// Takes dynamic stuff bits out of `line`; returns bits and the number of stuff bits.
fn destuffed(line: &[bool]) -> (Vec<bool>, u32) {
    let (mut plain, mut run, mut stuffed, mut last) = (Vec::new(), 0, 0, true);
    for &bit in line {
        let is_stuff = run == 5;
        assert!(!is_stuff || bit != last, "six equal bits");
        run = if bit == last { run + 1 } else { 1 };
        if is_stuff {
            stuffed += 1;
        } else {
            plain.push(bit);
        }
        last = bit;
    }
    (plain, stuffed)
}

fn random_frame(random: &mut ChaCha8Rng, format: Format) -> Frame {
    let sizes = if format == Format::Classic { &FD_SIZES[..=8] } else { &FD_SIZES[..] };
    let mut data = vec![0; sizes[random.random_range(0..sizes.len())]];
    // Runs of equal bits, so that there is much to stuff.
    for byte in &mut data {
        *byte =
            [0x00, 0xFF, 0x0F, 0xF0, 0x3C, 0xC3, (random.next_u32() >> 24) as u8][random.random_range(0..7)];
    }
    let id = if random.random() {
        base(random.random_range(0..1 << 11))
    } else {
        extended(random.random_range(0..1 << 29))
    };
    Frame::new(id, format, &data).unwrap()
}

#[test]
fn a_frame_from_the_literature_has_its_published_bits() {
    // Identifier 0x14, one byte 0x01: the example of K. Tindell's bit-banged CAN. The published line has the
    // acknowledgement slot recessive, as its sender sends it, and goes on into the intermission.
    let published = line("0000010010100000100010000010011110111010100111111111111111");
    let found = bits(&Frame::new(base(0x14), Format::Classic, &[1]).unwrap());
    let slot = found.len() - 9;
    assert!(!found[slot] && published[slot]);
    assert_eq!(found[..slot], published[..slot]);
    assert_eq!(found[slot + 1..], published[slot + 1..found.len()]);
}

#[test]
fn a_frame_stuffed_by_hand_has_these_bits() {
    // All zeros up to DLC 0, CRC 0: 34 zeros, with a recessive stuff bit after five and then after every five again,
    // since the bit after a recessive one starts a new run.
    let found = bits(&Frame::new(base(0), Format::Classic, &[]).unwrap());
    let zeros = "00000 1".repeat(6) + "0000";
    assert_eq!(found, line(&(zeros + "1 0 1 1111111")));
}

#[test]
fn worst_lengths_are_those_of_the_formulas() {
    for bytes in 0..=8 {
        let short = Length::worst(false, Format::Classic, bytes).unwrap().bits();
        let long = Length::worst(true, Format::Classic, bytes).unwrap().bits();
        let n = bytes as u32;
        assert_eq!(short + INTERMISSION, 55 + 10 * n, "Davis et al. 2007, 11-bit identifier, {bytes} bytes");
        assert_eq!(long + INTERMISSION, 80 + 10 * n, "Davis et al. 2007, 29-bit identifier, {bytes} bytes");
        assert_eq!(short + INTERMISSION, 34 + 8 * n + 13 + (34 + 8 * n - 1) / 4);
        assert_eq!(long + INTERMISSION, 54 + 8 * n + 13 + (54 + 8 * n - 1) / 4);
    }
}

#[test]
fn frames_of_can_fd_have_the_fields_of_the_standard() {
    // SOF to DLC 22 or 41 bits, stuff bit count 4, CRC 17 or 21, fixed stuff bits 6 or 7, delimiter 1, acknowledgement 2,
    // EOF 7.
    for bytes in FD_SIZES {
        let crc_field = if bytes <= 16 { 4 + 17 + 6 } else { 4 + 21 + 7 };
        for (id, header, before) in [(base(0x555), 22, 17), (extended(0x1555_5555), 41, 36)] {
            let plain = header + 8 * bytes as u32 + crc_field + 10;
            let data = vec![0x55; bytes];
            let actual = |format| Length::actual(&Frame::new(id, format, &data).unwrap());
            // Alternating data leave stuff bits to the header alone.
            assert!((plain..plain + 4).contains(&actual(FD).bits()), "{bytes} bytes, {id}");
            let exposed = header + 8 * bytes as u32;
            let worst = Length::worst(id.is_extended(), SWITCHED, bytes).unwrap();
            assert_eq!(worst.bits(), plain + (exposed - 2) / 4);
            assert_eq!((worst.head, worst.tail), (before + (before - 1) / 4, 10));
            assert_eq!(Length::worst(id.is_extended(), FD, bytes).unwrap().bits(), worst.bits());
        }
    }
}

#[test]
fn a_bit_rate_switch_splits_the_time_in_two() {
    let rates = Rates::new(500_000, Some(2_000_000)).unwrap();
    let frame = Frame::new(base(0x555), SWITCHED, &[0x55; 8]).unwrap();
    let length = Length::actual(&frame);
    // 17 bits up to BRS, then ESI, DLC (1000), data and CRC field, then 10 bits; no stuff bits anywhere.
    assert_eq!(length, Length { head: 17, fast: 1 + 4 + 64 + 27, tail: 10 });
    assert_eq!(length.duration(rates), (17 + 10) * 2000 + 96 * 500);
    assert_eq!(length.offset(18, rates), 17 * 2000 + 500);
    assert_eq!(length.offset(17 + 96 + 1, rates), 18 * 2000 + 96 * 500);
}

#[test]
fn no_frame_is_longer_than_the_worst_of_its_kind() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for format in [Format::Classic, FD, SWITCHED] {
        let mut closest = u32::MAX;
        for _ in 0..20_000 {
            let frame = random_frame(&mut random, format);
            let actual = Length::actual(&frame);
            let worst = Length::worst(frame.id().is_extended(), format, frame.data().len()).unwrap();
            assert!(actual.bits() <= worst.bits() && actual.head <= worst.head, "{frame:?}");
            assert_eq!(bits(&frame).len() as u32, actual.bits(), "{frame:?}");
            closest = closest.min(worst.bits() - actual.bits());
        }
        assert!(closest <= 3, "{format:?}: {closest} bits below the worst");
    }
}

#[test]
fn a_classical_crc_is_that_of_the_standard() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..1000 {
        let frame = random_frame(&mut random, Format::Classic);
        let line = bits(&frame);
        let (plain, _) = destuffed(&line[..line.len() - 10]);
        let (body, check) = plain.split_at(plain.len() - 15);
        assert_eq!(number(check), crc(body, 15, 0x4599, 0), "{frame:?}");
    }
}

#[test]
fn a_crc_of_can_fd_covers_stuff_bits_and_their_count() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let gray = [0b000, 0b001, 0b011, 0b010, 0b110, 0b111, 0b101, 0b100];
    for _ in 0..2000 {
        let frame = random_frame(&mut random, FD);
        let line = bits(&frame);
        let (width, polynomial, field) = match frame.data().len() {
            0..=16 => (17, 0x1685B, 27),
            _ => (21, 0x10_2899, 32),
        };
        let (body, rest) = line[..line.len() - 10].split_at(line.len() - 10 - field);
        // A fixed stuff bit before every four bits is the opposite of what precedes it.
        let mut plain = Vec::new();
        for (index, &bit) in rest.iter().enumerate() {
            let before = if index == 0 { body[body.len() - 1] } else { rest[index - 1] };
            if index % 5 == 0 {
                assert_eq!(bit, !before, "{frame:?}");
            } else {
                plain.push(bit);
            }
        }
        let (count, check) = plain.split_at(4);
        let (unstuffed, stuffed) = destuffed(body);
        assert_eq!(unstuffed.len(), frame.data().len() * 8 + if frame.id().is_extended() { 41 } else { 22 });
        let code: u32 = gray[stuffed as usize % 8];
        assert_eq!(number(count), (code << 1) | (code.count_ones() % 2), "{frame:?}");
        let covered = [body, count].concat();
        assert_eq!(number(check), crc(&covered, width, polynomial, 1 << (width - 1)), "{frame:?}");
    }
}

#[test]
fn a_payload_that_does_not_fit_is_refused_with_the_sizes_that_do() {
    let error = Frame::new(base(1), Format::Classic, &[0; 9]).unwrap_err().to_string();
    assert!(error.contains("9 bytes") && error.contains("0 to 8"), "{error}");
    let error = Frame::new(base(1), FD, &[0; 13]).unwrap_err().to_string();
    assert!(error.contains("13 bytes") && error.contains("16, 20"), "{error}");
    assert!(Frame::new(base(1), FD, &[0; 65]).is_err());
}

#[test]
fn bit_rates_with_whole_nanoseconds_only() {
    assert_eq!(Rates::new(125_000, None).unwrap(), Rates { bit: 8000, data_bit: 8000 });
    assert_eq!(Rates::new(500_000, Some(8_000_000)).unwrap(), Rates { bit: 2000, data_bit: 125 });
    for (nominal, data) in [(0, None), (83_333, None), (500_000, Some(250_000))] {
        assert!(Rates::new(nominal, data).is_err(), "{nominal} {data:?}");
    }
}
