//! The actuator plays the newest sequence out, then its default input, whatever the link does.

mod lent;

use nalgebra::SVector;
use proptest::prelude::*;
use slqg::actuator::{self, Actuator, Applied, Limits, RejectedFrame, RejectedSequence, Settings};
use slqg::wire::{self, Acknowledgement, DecodeError, MOST_AGES};
use slqg::{Age, DefaultInput, Tick, nalgebra, sequence::ControlSequence};

const CAPACITY: usize = 4;
type Device = Actuator<'static, f32, 1>;
type Sequence = ControlSequence<'static, f32, 1>;

fn device(default_input: DefaultInput, tick: Tick) -> Device {
    lent::actuator(Settings { default_input, limits: None, safe: None }, tick, CAPACITY)
}

fn sequence(tick: Tick, inputs: &[f32]) -> Sequence {
    let inputs: Vec<_> = inputs.iter().map(|&input| SVector::from([input])).collect();
    Sequence { tick, inputs: inputs.leak() }
}

fn frame(sequence: &Sequence) -> Vec<u8> {
    let mut buffer = [0; wire::control_len(1, CAPACITY, 4)];
    wire::encode_control(sequence, &mut buffer).expect("the buffer is made for it").to_vec()
}

/// Plays `cycles` cycles and returns what was applied.
fn play(device: &mut Device, cycles: usize) -> Vec<(f32, Age)> {
    (0..cycles).map(|_| device.step()).map(|Applied { input, age, .. }| (input[0], age)).collect()
}

#[test]
fn a_sequence_is_played_out_and_then_the_default_input() {
    for (default_input, after) in [(DefaultInput::Zero, 0.0), (DefaultInput::Hold, 3.0)] {
        let start = Tick(u32::MAX - 1);
        let mut device = device(default_input, start);
        assert_eq!(play(&mut device, 1), [(0.0, Age::Empty)], "nothing has arrived");
        assert_eq!(device.offer(&sequence(start + 1, &[1.0, 2.0, 3.0])), Ok(()));
        let played = [(1.0, Age::Steps(0)), (2.0, Age::Steps(1)), (3.0, Age::Steps(2))];
        assert_eq!(play(&mut device, 3), played);
        assert_eq!(play(&mut device, 3), [(after, Age::Empty); 3]);
        assert_eq!(device.tick(), start + 7);
    }
}

#[test]
fn what_left_the_actuator_names_its_cycle() {
    let mut device = device(DefaultInput::Zero, Tick(u32::MAX));
    assert_eq!(device.step().tick, Tick(u32::MAX));
    assert_eq!(device.step().tick, Tick(0));
}

#[test]
fn a_late_sequence_begins_with_the_input_meant_for_now() {
    let mut device = device(DefaultInput::Zero, Tick(10));
    assert_eq!(device.offer(&sequence(Tick(8), &[1.0, 2.0, 3.0, 4.0])), Ok(()));
    assert_eq!(play(&mut device, 2), [(3.0, Age::Steps(2)), (4.0, Age::Steps(3))]);
}

#[test]
fn late_packet_does_not_replace_a_newer_one() {
    let mut device = device(DefaultInput::Zero, Tick(10));
    assert_eq!(device.receive(&frame(&sequence(Tick(10), &[5.0, 6.0]))), Ok(()));
    let past = Err(RejectedFrame::Sequence(RejectedSequence::Past));
    assert_eq!(device.receive(&frame(&sequence(Tick(9), &[1.0; 4]))), past);
    assert_eq!(device.receive(&frame(&sequence(Tick(10), &[1.0; 4]))), past, "the same packet again");
    assert_eq!(device.rejected_frames(), 2);
    assert_eq!(play(&mut device, 2), [(5.0, Age::Steps(0)), (6.0, Age::Steps(1))]);
    assert_eq!(
        device.receive(&frame(&sequence(Tick(9), &[1.0; 4]))),
        past,
        "not even when the newer one has run out"
    );
    assert_eq!(play(&mut device, 1), [(0.0, Age::Empty)]);
}

#[test]
fn sequences_of_no_use_are_rejected_by_name() {
    let now = Tick(1);
    let mut device = device(DefaultInput::Zero, now);
    let mut offer = |tick, inputs: &[f32]| device.offer(&sequence(tick, inputs));
    assert_eq!(offer(now - 2, &[1.0; 2]), Err(RejectedSequence::RunOut));
    assert_eq!(offer(now - 4, &[1.0; 4]), Err(RejectedSequence::RunOut));
    assert_eq!(offer(now + 1, &[1.0; 4]), Err(RejectedSequence::Future));
    assert_eq!(offer(now + i32::MAX as u32, &[1.0; 4]), Err(RejectedSequence::Future));
    assert_eq!(offer(now + (1 << 31), &[1.0; 4]), Err(RejectedSequence::RunOut), "half the circle away");
    assert_eq!(offer(now, &[]), Err(RejectedSequence::NoInputs));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(offer(now, &[1.0, bad]), Err(RejectedSequence::NotFinite));
    }
    assert_eq!(play(&mut device, 1), [(0.0, Age::Empty)], "none of them left anything");
}

#[test]
fn a_sequence_longer_than_the_memory_lent_is_refused_and_one_as_long_is_not() {
    for (inputs, most) in [(0, 0), (2, 0), (3, 1), (11, 3), (12, 4), (1000, 255)] {
        let settings = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
        let mut device = Device::new(settings, Tick(0), lent::inputs(inputs));
        let (longest, longer) = (vec![1.0; most], vec![2.0; most + 1]);
        assert_eq!(device.offer(&sequence(Tick(0), &longer)), Err(RejectedSequence::TooLong));
        if most < 255 {
            let mut buffer = [0; wire::control_len(1, 5, 4)];
            let frame =
                wire::encode_control(&sequence(Tick(0), &longer), &mut buffer).expect("there is room");
            let found = DecodeError::Capacity(most as u8 + 1);
            assert_eq!(device.receive(frame), Err(RejectedFrame::Decode(found)));
        }
        if most > 0 {
            assert_eq!(device.offer(&sequence(Tick(0), &longest)), Ok(()), "{inputs} inputs lent");
            assert_eq!(play(&mut device, most)[most - 1], (1.0, Age::Steps(most as u8 - 1)));
        }
        assert_eq!(play(&mut device, 1), [(0.0, Age::Empty)]);
    }
}

#[test]
fn a_damaged_frame_leaves_the_sequence_that_is_played_alone() {
    let mut device = device(DefaultInput::Zero, Tick(0));
    assert_eq!(device.receive(&frame(&sequence(Tick(0), &[1.0, 2.0, 3.0]))), Ok(()));
    // Its checksum is right, and its last number is none: all before it have been read.
    let poisoned = frame(&sequence(Tick(1), &[7.0, 8.0, f32::NAN]));
    assert_eq!(device.receive(&poisoned), Err(RejectedFrame::Decode(DecodeError::NotFinite)));
    let past = frame(&sequence(Tick(0), &[9.0; 4]));
    assert_eq!(device.receive(&past), Err(RejectedFrame::Sequence(RejectedSequence::Past)));
    assert_eq!(play(&mut device, 3), [(1.0, Age::Steps(0)), (2.0, Age::Steps(1)), (3.0, Age::Steps(2))]);
}

#[test]
fn an_actuator_that_is_restarted_is_a_new_one() {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        let mut restarted = device(default_input, Tick(0));
        assert_eq!(restarted.offer(&sequence(Tick(0), &[5.0; CAPACITY])), Ok(()));
        restarted.receive(&[]).expect_err("no frame");
        play(&mut restarted, 2);
        let start = Tick(u32::MAX - 1);
        restarted.restart(start);
        let mut fresh = device(default_input, start);
        assert_eq!(restarted.acknowledgement(MOST_AGES), None);
        assert_eq!(restarted.rejected_frames(), 0);
        for device in [&mut restarted, &mut fresh] {
            assert_eq!(device.tick(), start);
            assert_eq!(play(device, 1), [(0.0, Age::Empty)]);
            assert_eq!(device.offer(&sequence(start, &[1.0, 2.0])), Ok(()), "older ones are forgotten");
            play(device, 3);
        }
        assert_eq!(restarted.step(), fresh.step());
        assert_eq!(restarted.acknowledgement(MOST_AGES), fresh.acknowledgement(MOST_AGES));
    }
}

#[test]
fn saturation_bounds_every_input_and_hold_holds_the_bounded_one() {
    let limits = Some(Limits { min: SVector::from([0.5]), max: SVector::from([2.0]), rate: None });
    for (default_input, after) in [(DefaultInput::Zero, 0.5), (DefaultInput::Hold, 2.0)] {
        let mut device = lent::actuator(Settings { default_input, limits, safe: None }, Tick(0), CAPACITY);
        assert_eq!(play(&mut device, 1), [(0.5, Age::Empty)], "zero is out of bounds");
        assert_eq!(device.offer(&sequence(Tick(1), &[-9.0, 1.0, f32::MAX])), Ok(()));
        let played: Vec<f32> = play(&mut device, 5).iter().map(|(input, _)| *input).collect();
        assert_eq!(played, [0.5, 1.0, 2.0, after, after]);
    }
}

#[test]
fn limits_in_the_wrong_order_do_not_panic() {
    let limits = Some(Limits { min: SVector::from([1.0]), max: SVector::from([-1.0]), rate: None });
    let mut device =
        lent::actuator(Settings { default_input: DefaultInput::Hold, limits, safe: None }, Tick(0), CAPACITY);
    assert_eq!(play(&mut device, 2), [(-1.0, Age::Empty); 2]);
}

#[test]
fn a_sequence_is_forgotten_long_before_its_tick_can_wrap() {
    // All state is in the debug form: equal forms behave alike for ever, so that what is forgotten after
    // some idle cycles cannot come back after 2^31 of them.
    let settings = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
    // What is lent holds the sequence's own inputs, so that only what is remembered of them makes a difference.
    let lent = || vec![SVector::from([1.0]); actuator::memory_len(CAPACITY)].leak();
    let mut used = Device::new(settings, Tick(0), lent());
    assert_eq!(used.offer(&sequence(Tick(0), &[1.0; CAPACITY])), Ok(()));
    play(&mut used, CAPACITY);
    assert!(format!("{used:?}").contains("buffered: Some"), "it still guards against older packets");
    play(&mut used, 1);
    assert!(format!("{used:?}").contains("buffered: None"));
    // What was played is remembered for as long as it may have to be acknowledged.
    let mut fresh = Device::new(settings, used.tick(), lent());
    play(&mut used, MOST_AGES);
    play(&mut fresh, MOST_AGES);
    assert_eq!(format!("{used:?}"), format!("{fresh:?}"));
}

/// What `device` acknowledges of `cycles` cycles, which must be about the last one it played.
fn acknowledged(device: &Device, cycles: usize) -> Vec<Age> {
    let acknowledgement = device.acknowledgement(cycles).expect("a cycle was played");
    assert_eq!(acknowledgement.tick, device.tick() - 1);
    acknowledgement.ages.to_vec()
}

#[test]
fn there_is_nothing_to_acknowledge_before_the_first_cycle() {
    let mut device = device(DefaultInput::Zero, Tick(0));
    assert_eq!(device.acknowledgement(MOST_AGES), None);
    assert_eq!(device.offer(&sequence(Tick(0), &[1.0])), Ok(()));
    assert_eq!(device.acknowledgement(MOST_AGES), None, "it has arrived and is not played yet");
    device.step();
    assert_eq!(device.acknowledgement(1), Some(Acknowledgement::of(Tick(0), Age::Steps(0))));
}

#[test]
fn an_acknowledgement_says_what_was_played_newest_first() {
    // Zero and hold differ in the input, not in the age.
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        let start = Tick(u32::MAX - 1);
        let mut device = device(default_input, start);
        device.step();
        assert_eq!(device.offer(&sequence(start + 1, &[1.0, 2.0])), Ok(()));
        play(&mut device, 3);
        assert_eq!(device.offer(&sequence(start + 3, &[3.0; CAPACITY])), Ok(()));
        device.step();
        let ages = [Age::Steps(1), Age::Empty, Age::Steps(1), Age::Steps(0), Age::Empty];
        assert_eq!(device.acknowledgement(5).expect("played").tick, start + 4, "past the wrap of ticks");
        for cycles in 1..=5 {
            assert_eq!(acknowledged(&device, cycles), ages[..cycles]);
        }
        assert_eq!(acknowledged(&device, 6), ages, "no more than were played");
    }
}

#[test]
fn an_acknowledgement_is_about_one_to_eight_cycles_whatever_is_asked_for() {
    let mut device = device(DefaultInput::Zero, Tick(0));
    for cycle in 1..=2 * MOST_AGES {
        device.step();
        assert_eq!(acknowledged(&device, 0).len(), 1);
        assert_eq!(acknowledged(&device, MOST_AGES).len(), cycle.min(MOST_AGES));
        assert_eq!(acknowledged(&device, usize::MAX).len(), cycle.min(MOST_AGES));
    }
}

#[test]
fn asking_for_an_acknowledgement_changes_nothing() {
    let mut device = device(DefaultInput::Hold, Tick(0));
    assert_eq!(device.offer(&sequence(Tick(0), &[1.0, 2.0, 3.0])), Ok(()));
    device.step();
    assert_eq!(device.acknowledgement(3), device.acknowledgement(3));
    assert_eq!(play(&mut device, 1), [(2.0, Age::Steps(1))]);
    assert_eq!(acknowledged(&device, 3), [Age::Steps(1), Age::Steps(0)]);
}

/// A link's doing with one packet.
#[derive(Debug, Clone)]
struct Packet {
    inputs: usize,
    /// `None` if it is lost.
    delay: Option<usize>,
    /// Place among the packets that arrive in the same cycle.
    place: u32,
}

fn packets() -> impl Strategy<Value = Vec<Packet>> {
    let delay = prop_oneof![1 => Just(None), 6 => (0usize..7).prop_map(Some)];
    let packet = (1..=CAPACITY, delay, any::<u32>()).prop_map(|(inputs, delay, place)| Packet {
        inputs,
        delay,
        place,
    });
    proptest::collection::vec(packet, 1..40)
}

/// A different input for every packet and entry.
fn input(sent: usize, entry: usize) -> f32 {
    1.0 + (sent * CAPACITY + entry) as f32
}

/// The packets that arrive in `cycle`, in the order of their places.
fn arrivals(packets: &[Packet], cycle: usize) -> Vec<usize> {
    let arrives = |sent: &usize| packets[*sent].delay.is_some_and(|delay| sent + delay == cycle);
    let mut arriving: Vec<usize> = (0..packets.len()).filter(arrives).collect();
    arriving.sort_by_key(|&sent| packets[sent].place);
    arriving
}

/// The packet played in `cycle`, thesis (3.11): the newest of all that arrived in time to be of use.
fn played(packets: &[Packet], cycle: usize) -> Option<usize> {
    let useful = |sent: &usize| {
        let Packet { inputs, delay, .. } = packets[*sent];
        delay.is_some_and(|delay| delay < inputs && sent + delay <= cycle)
    };
    let newest = (0..=cycle.min(packets.len() - 1)).filter(useful).max()?;
    (cycle - newest < packets[newest].inputs).then_some(newest)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_newest_sequence_wins_whatever_the_link_does(
        packets in packets(),
        start in prop_oneof![Just(u32::MAX - 15), any::<u32>()],
        hold in any::<bool>(),
        damage in any::<prop::sample::Index>(),
    ) {
        let default_input = if hold { DefaultInput::Hold } else { DefaultInput::Zero };
        let mut device = device(default_input, Tick(start));
        let mut last = 0.0;
        let mut ages = vec![];
        let mut damaged_frames = 0;
        for cycle in 0..packets.len() + 8 {
            for sent in arrivals(&packets, cycle) {
                let inputs: Vec<f32> = (0..packets[sent].inputs).map(|entry| input(sent, entry)).collect();
                let frame = frame(&sequence(Tick(start) + sent as u32, &inputs));
                // Damaged copies of the packet, before it: taken for it, they would make it a past one.
                let mut flipped = frame.clone();
                flipped[damage.index(frame.len())] ^= 1 << (cycle % 8);
                prop_assert!(matches!(device.receive(&flipped), Err(RejectedFrame::Decode(_))));
                let cut = damage.index(frame.len());
                prop_assert!(matches!(device.receive(&frame[..cut]), Err(RejectedFrame::Decode(_))));
                damaged_frames += 2;
                let before = device.rejected_frames();
                let taken = device.receive(&frame).is_ok();
                prop_assert_eq!(device.rejected_frames(), before + u32::from(!taken));
            }
            let applied = device.step();
            let default = if hold { last } else { 0.0 };
            let (expected, age) = played(&packets, cycle).map_or((default, Age::Empty), |sent| {
                (input(sent, cycle - sent), Age::Steps((cycle - sent) as u8))
            });
            prop_assert_eq!(applied, Applied {
                tick: Tick(start) + cycle as u32, input: SVector::from([expected]), age,
            });
            last = expected;
            ages.insert(0, age);
            let told = device.acknowledgement(MOST_AGES).expect("a cycle was played");
            prop_assert_eq!(told.tick, applied.tick);
            prop_assert_eq!(&told.ages[..], &ages[..ages.len().min(MOST_AGES)]);
        }
        prop_assert!(device.rejected_frames() >= damaged_frames);
    }
}
