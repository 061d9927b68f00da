//! Sealed frames are their holder's: nobody makes, changes, repeats or moves one.

mod guarded;

use guarded::{Counter, IDENTITY, Pair, control, end_of, frames, gains, keys};
use proptest::prelude::RngCore;
use proptest::test_runner::{RngAlgorithm, TestRng};
use slqg::Tick;
use slqg::authentication::{
    Alarm, Association, HELLO_LEN, Identity, Key, NotSealed, Opened, Refused, SEALED, Side, TAG_LEN,
    sealed_len,
};
use slqg::blob::DesignId;
use slqg::wire::can::{FD_CAPACITY, pad};

fn dice() -> TestRng {
    TestRng::from_seed(RngAlgorithm::ChaCha, &[42; 32])
}

#[test]
fn a_sealed_frame_is_opened_once_and_to_the_byte() {
    for (kind, association, sender, frame) in frames(7) {
        let mut pair = Pair::standing(association);
        let sealed = pair.seal(sender, &frame);
        assert_eq!(sealed.len(), frame.len() + 9, "{kind}");
        assert_eq!(pair.give(sender, &sealed), Ok(Opened::Frame(&frame)), "{kind}");
        if kind != "gains" {
            assert_eq!(pair.give(sender, &sealed), Err(Refused::Repeated), "{kind}");
        }
    }
}

#[test]
fn a_plain_frame_is_taken_by_no_guard() {
    for (kind, association, sender, frame) in frames(7) {
        let mut pair = Pair::standing(association);
        assert_eq!(pair.give(sender, &frame), Err(Refused::Form), "{kind}");
    }
}

/// The fastest attacker, and the luckiest place: right in everything but the tag, right after a frame that was taken.
#[test]
fn of_a_million_random_forgeries_of_each_kind_none_is_taken() {
    let mut dice = dice();
    for (kind, association, sender, frame) in frames(7) {
        let mut pair = Pair::standing(association);
        let first = pair.seal(sender, &frame);
        pair.give(sender, &first).expect("it is right");
        let (.., next) = frames(8).into_iter().find(|(other, ..)| *other == kind).expect("the same kinds");
        let mut forged = [&[SEALED; 9][..], &next].concat();
        for _ in 0..1_000_000 {
            dice.fill_bytes(&mut forged[1..=TAG_LEN]);
            assert_eq!(pair.give(sender, &forged), Err(Refused::Forged), "{kind}");
        }
        let right = pair.seal(sender, &next);
        assert_eq!(pair.give(sender, &right), Ok(Opened::Frame(&next)), "{kind}: the loop goes on");
    }
}

#[test]
fn of_a_hundred_thousand_random_hellos_none_is_taken_and_none_ends_a_session() {
    let mut dice = dice();
    let mut pair = Pair::standing(Association::Loop);
    let mut forged = [0; HELLO_LEN];
    for _ in 0..100_000 {
        dice.fill_bytes(&mut forged);
        forged[..3].copy_from_slice(&[0xa2, Association::Loop as u8, Side::Upstream as u8]);
        assert_eq!(pair.give(Side::Upstream, &forged), Err(Refused::Forged));
    }
    let sealed = pair.seal(Side::Upstream, &control(Tick(1), 1.0));
    assert!(pair.give(Side::Upstream, &sealed).is_ok());
}

#[test]
fn a_frame_that_was_changed_in_any_bit_is_refused_even_with_a_checksum_that_fits() {
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI);
    for (kind, association, sender, frame) in frames(7) {
        let mut pair = Pair::standing(association);
        let sealed = pair.seal(sender, &frame);
        for bit in 8..8 * (sealed.len() - 4) {
            let mut changed = sealed.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            let (content, sum) = changed.split_at_mut(sealed.len() - 4);
            sum.copy_from_slice(&checksum.checksum(&content[9..]).to_le_bytes());
            // The kind is in the tag, too, but some kinds are not this association's.
            let refused = pair.give(sender, &changed);
            assert!(
                matches!(refused, Err(Refused::Forged | Refused::Kind)),
                "{kind}, bit {bit}: {refused:?}"
            );
        }
        assert!(pair.give(sender, &sealed).is_ok(), "{kind}");
    }
}

/// The frame of the next cycle is easily foretold where inputs hardly change.
#[test]
fn a_frame_moved_to_the_next_cycle_is_refused() {
    let mut pair = Pair::standing(Association::Loop);
    let sealed = pair.seal(Side::Upstream, &control(Tick(7), 2.0));
    let moved = [&sealed[..9], &control(Tick(8), 2.0)].concat();
    assert_eq!(pair.give(Side::Upstream, &moved), Err(Refused::Forged));
}

#[test]
fn a_frame_is_of_its_direction_key_loop_and_plant_alone() {
    let association = Association::Loop;
    let of = |identity, first, side| end_of(identity, keys(first), association, side);
    let others = [
        ("another key", of(IDENTITY, 99, Side::Upstream)),
        ("another loop", of(Identity { loop_id: 8, ..IDENTITY }, 20, Side::Upstream)),
        ("another plant", of(Identity { design: DesignId(1), ..IDENTITY }, 20, Side::Upstream)),
    ];
    for (who, mut other) in others {
        // It has a session with an end of its own, and the nonces of that are those of ours: nothing but `who` differs.
        let mut pair = Pair::standing(association);
        let mut nonces = Counter(1000);
        let hello = other.due(&mut nonces).expect("at the start");
        assert_eq!(pair.give(Side::Upstream, &hello), Err(Refused::Forged), "{who}");
        assert!(pair.downstream.stands(), "{who}");
    }
    // An acknowledgement comes back to who has sent it.
    let mut pair = Pair::standing(association);
    let (.., frame) = frames(7).into_iter().find(|(kind, ..)| *kind == "acknowledgement").expect("a kind");
    let sealed = pair.seal(Side::Downstream, &frame);
    assert_eq!(pair.give(Side::Upstream, &sealed), Err(Refused::Kind));
    let hello =
        pair.record.iter().find(|(sender, _)| *sender == Side::Upstream).expect("it has said hello").clone();
    assert_eq!(pair.give(Side::Downstream, &hello.1), Err(Refused::Forged), "a hello that comes back");
}

/// Whoever holds the key and nothing else still needs the other end's nonce.
#[test]
fn nothing_is_taken_or_sealed_before_both_ends_have_proven_to_be_there() {
    let mut pair = Pair::new(Association::Loop);
    let frame = control(Tick(0), 1.0);
    assert_eq!(pair.upstream.seal(&frame, &mut [0; 64]), Err(NotSealed::NoSession));
    let sealed = Pair::standing(Association::Loop).seal(Side::Upstream, &frame);
    assert_eq!(pair.give(Side::Upstream, &sealed), Err(Refused::NoSession));
}

#[test]
fn a_recording_of_a_whole_session_is_of_no_use_after_a_restart() {
    for (kind, association, sender, _) in frames(0) {
        let mut pair = Pair::standing(association);
        for tick in 0..20 {
            let (.., frame) = frames(tick).into_iter().find(|(other, ..)| *other == kind).expect("a kind");
            let sealed = pair.seal(sender, &frame);
            pair.give(sender, &sealed).ok();
        }
        let recording = std::mem::take(&mut pair.record);
        // The receiver has lost its memory, and the sender is not there: the recording plays its part.
        match sender {
            Side::Upstream => pair.downstream = guarded::end(association, Side::Downstream),
            Side::Downstream => pair.upstream = guarded::end(association, Side::Upstream),
        }
        for _ in 0..3 {
            pair.due();
            for (_, bytes) in recording.iter().filter(|(from, _)| *from == sender) {
                let taken = pair.give(sender, bytes);
                assert!(!matches!(taken, Ok(Opened::Frame(_))), "{kind}: {taken:?}");
            }
            let receiver = if sender == Side::Upstream { &pair.downstream } else { &pair.upstream };
            assert!(!receiver.stands(), "{kind}: a recording has proven to be alive");
        }
    }
}

#[test]
fn frames_of_an_older_session_are_refused_in_the_next() {
    let mut pair = Pair::standing(Association::Loop);
    let old = pair.seal(Side::Upstream, &control(Tick(100), 1.0));
    let recording = pair.record.clone();
    pair.upstream = guarded::end(Association::Loop, Side::Upstream);
    pair.shake();
    assert!(pair.downstream.stands());
    assert_eq!(pair.give(Side::Upstream, &old), Err(Refused::Forged));
    // Hellos of before end nothing, and lead back to nothing.
    for (sender, bytes) in &recording {
        pair.give(*sender, bytes).ok();
    }
    let new = pair.seal(Side::Upstream, &control(Tick(100), 1.0));
    assert!(matches!(pair.give(Side::Upstream, &new), Ok(Opened::Frame(_))));
    assert_eq!(pair.give(Side::Upstream, &old), Err(Refused::Forged));
}

/// A frame of 2^16 cycles ago has the same lower half of its tick, one of 2^32 ago all of it.
#[test]
fn a_frame_does_not_come_again_as_the_tick_wraps() {
    let mut pair = Pair::standing(Association::Loop);
    let mut recorded: Vec<Vec<u8>> = Vec::new();
    let mut cycle = 0_u64;
    while cycle <= 1 << 33 {
        let frame = control(Tick(cycle as u32), 1.0);
        let sealed = if pair.upstream.stands() { pair.seal(Side::Upstream, &frame) } else { Vec::new() };
        let taken = pair.give(Side::Upstream, &sealed);
        for old in &recorded {
            let again = pair.give(Side::Upstream, old);
            assert!(
                matches!(again, Err(Refused::Repeated | Refused::Forged | Refused::NoSession)),
                "{again:?}"
            );
        }
        if taken.is_ok() {
            recorded.push(sealed);
        }
        for _ in 0..20 {
            pair.upstream.cycle();
            pair.downstream.cycle();
        }
        pair.shake();
        cycle += if cycle < 1 << 18 { 1 << 16 } else { 1 << 28 };
    }
    assert!(recorded.len() > 30, "the loop goes on: {}", recorded.len());
}

#[test]
fn an_end_that_comes_back_without_memory_is_in_a_session_again_whoever_it_is() {
    for side in [Side::Upstream, Side::Downstream] {
        let mut pair = Pair::standing(Association::Loop);
        match side {
            Side::Upstream => pair.upstream = guarded::end(Association::Loop, side),
            Side::Downstream => pair.downstream = guarded::end(Association::Loop, side),
        }
        pair.shake();
        let sealed = pair.seal(Side::Upstream, &control(Tick(7), 1.0));
        assert!(pair.give(Side::Upstream, &sealed).is_ok());
    }
}

/// Hellos are lost as any frame is.
#[test]
fn a_session_comes_about_whichever_hellos_are_lost() {
    for lost in 0..256_u32 {
        let mut pair = Pair::new(Association::Loop);
        let (mut count, mut under_way) = (0, pair.due());
        for cycle in 0..400 {
            while let Some((sender, hello)) = under_way.pop() {
                count += 1;
                if count <= 8 && lost >> (count - 1) & 1 == 1 {
                    continue;
                }
                if let Ok(Opened::Hello(Some(answer))) = pair.give(sender, &hello) {
                    under_way.push((sender.other(), answer.to_vec()));
                }
            }
            // Ends that believe to be in a session send in it.
            for (sender, frame) in [
                (Side::Upstream, control(Tick(cycle), 1.0)),
                (Side::Downstream, guarded::acknowledgement(Tick(cycle))),
            ] {
                let stands =
                    if sender == Side::Upstream { pair.upstream.stands() } else { pair.downstream.stands() };
                if stands {
                    let sealed = pair.seal(sender, &frame);
                    pair.give(sender, &sealed).ok();
                }
            }
            pair.upstream.cycle();
            pair.downstream.cycle();
            under_way = pair.due();
        }
        for (sender, frame) in [
            (Side::Upstream, control(Tick(500), 1.0)),
            (Side::Downstream, guarded::acknowledgement(Tick(500))),
        ] {
            let sealed = pair.seal(sender, &frame);
            assert_eq!(pair.give(sender, &sealed), Ok(Opened::Frame(&frame)), "{lost:08b} lost");
        }
    }
}

#[test]
fn repeated_hellos_are_answered_four_times_a_cycle_and_no_more() {
    let mut pair = Pair::standing(Association::Loop);
    let (sender, hello) = pair.record[0].clone();
    let mut answers = 0;
    for _ in 0..1000 {
        answers += usize::from(matches!(pair.give(sender, &hello), Ok(Opened::Hello(Some(_)))));
    }
    assert!(answers <= 4, "{answers}");
    assert!(pair.upstream.stands() && pair.downstream.stands());
}

#[test]
fn garbage_raises_an_alarm_and_stops_nothing() {
    let mut dice = dice();
    let mut pair = Pair::standing(Association::Loop);
    for tick in 0..200 {
        let mut forged = [&[SEALED; 9][..], &control(Tick(tick), 9.0)].concat();
        dice.fill_bytes(&mut forged[1..=TAG_LEN]);
        for _ in 0..50 {
            assert_eq!(pair.give(Side::Upstream, &forged), Err(Refused::Forged));
        }
        let frame = control(Tick(tick), 1.0);
        let sealed = pair.seal(Side::Upstream, &frame);
        assert_eq!(pair.give(Side::Upstream, &sealed), Ok(Opened::Frame(&frame)));
        pair.downstream.cycle();
        assert_eq!(pair.downstream.alarm(), Some(Alarm::Forged));
    }
    assert_eq!(pair.downstream.failures().forged, 10_000);
    (0..200).for_each(|_| pair.downstream.cycle());
    assert_eq!(pair.downstream.alarm(), None);
}

#[test]
fn gains_that_are_not_newer_than_the_newest_are_refused_over_a_restart_too() {
    let mut pair = Pair::standing(Association::Service);
    pair.downstream.keep_version(41);
    let give = |pair: &mut Pair, version, offset| {
        let sealed = pair.seal(Side::Upstream, &gains(version, offset));
        pair.give(Side::Upstream, &sealed).map(|_| ())
    };
    assert_eq!(give(&mut pair, 41, 0), Err(Refused::Version));
    assert_eq!(give(&mut pair, 42, 0), Ok(()));
    assert_eq!(give(&mut pair, 42, 0), Ok(()), "its answer may have been lost");
    assert_eq!(give(&mut pair, 44, 0), Ok(()));
    assert_eq!(give(&mut pair, 42, 4), Err(Refused::Version), "newer ones are under way");
    pair.downstream.keep_version(44);
    assert_eq!(give(&mut pair, 44, 0), Err(Refused::Version), "they are in force");
    pair.downstream = guarded::end(Association::Service, Side::Downstream);
    pair.downstream.keep_version(44);
    pair.shake();
    assert_eq!(give(&mut pair, 44, 0), Err(Refused::Version));
    assert_eq!(give(&mut pair, 45, 0), Ok(()));
}

#[test]
fn a_sender_that_counts_its_cycles_anew_begins_a_new_session() {
    let mut pair = Pair::standing(Association::Loop);
    pair.seal(Side::Upstream, &control(Tick(7), 1.0));
    for tick in [7, 3] {
        assert!(pair.upstream.seal(&control(Tick(tick), 2.0), &mut [0; 64]).is_err(), "{tick}");
    }
    assert!(!pair.upstream.stands());
    pair.shake();
    let sealed = pair.seal(Side::Upstream, &control(Tick(3), 2.0));
    assert!(pair.give(Side::Upstream, &sealed).is_ok());
}

#[test]
fn on_can_fd_the_end_of_a_sealed_frame_is_found_behind_its_padding() {
    let mut pair = Pair::standing(Association::Loop);
    let sealed = pair.seal(Side::Upstream, &control(Tick(7), 1.0));
    for bytes in [&pair.record[0].1, &sealed] {
        let mut room = [0; FD_CAPACITY];
        let padded = pad(bytes, &mut room).expect("it fits");
        assert!(padded.len() > bytes.len());
        assert_eq!(sealed_len(padded), Some(bytes.len()));
    }
    assert_eq!(sealed_len(&control(Tick(7), 1.0)), None);
}

/// `docs/wire-format.md`: loop 7, plant 0x12345678; keys of sixteen bytes 0x14 downstream, 0x15 upstream; nonces 1001 and 2001.
#[test]
fn the_bytes_are_those_of_the_page() {
    let mut pair = Pair::new(Association::Loop);
    let offer = pair.upstream.due(&mut pair.nonces[0]).expect("at the start").to_vec();
    pair.record.push((Side::Upstream, offer));
    while let (sender, bytes) = pair.record.last().expect("the offer").clone()
        && let Ok(Opened::Hello(Some(answer))) = pair.give(sender, &bytes)
    {
        pair.record.push((sender.other(), answer.to_vec()));
    }
    pair.seal(Side::Upstream, &control(Tick(0x0102_0304), 2.0));
    let page = include_str!("../../../docs/wire-format.md").split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(pair.record.len(), 4);
    let hexadecimal =
        |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ");
    let told: Vec<String> = pair.record.iter().map(|(_, bytes)| hexadecimal(bytes)).collect();
    assert!(told.iter().all(|bytes| page.contains(bytes)), "{told:#?}");
}

#[test]
fn nothing_prints_a_key() {
    let key = Key::new([0xab; 16]);
    let printed = format!("{key:?} {:?} {:?}", keys(0xab), Pair::standing(Association::Loop).upstream);
    for told in ["ab", "AB", "171"] {
        assert!(!printed.contains(told), "{printed}");
    }
}
