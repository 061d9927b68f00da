//! Tests: a bit that flips in what an actuator stands on.

use super::{Actuator, Applied, Limits, Safe, Settings, memory_len};
use crate::{
    Age, DefaultInput, Scalar, Tick,
    health::{Cause, Health},
    sequence::ControlSequence,
};
use nalgebra::SVector;

const LENGTH: usize = 4;
const SAFE: f64 = -0.5;
const LOST: Health = Health::Lost(Cause::Memory);

fn input<T: Scalar>(value: f64) -> SVector<T, 1> {
    SVector::from([T::nearest(value)])
}

fn settings<T: Scalar>(rate: Option<f64>) -> Settings<T, 1> {
    Settings {
        default_input: DefaultInput::Hold,
        limits: Some(Limits { min: input(-2.0), max: input(2.0), rate: rate.map(input) }),
        safe: Some(Safe { after: 5, input: input(SAFE) }),
    }
}

type Change<T> = fn(&mut Actuator<'_, T, 1>, bool, u32);

/// Runs `look` with an actuator that plays 1, 1.5 and has them in its buffer, each time with another change to it.
fn with_changes<T: Scalar>(changes: &[Change<T>], look: impl Fn(&mut Actuator<'_, T, 1>)) {
    for change in changes {
        for (of_copy, bit) in (0..u32::from(T::BYTES) * 8).flat_map(|bit| [(false, bit), (true, bit)]) {
            let mut memory = [input(f64::NAN); memory_len(LENGTH)];
            let mut actuator = Actuator::new(settings(None), Tick(7), &mut memory);
            let inputs = [1.0, 1.5, 1.75, 1.875].map(input);
            actuator.offer(&ControlSequence { tick: Tick(7), inputs: &inputs }).expect("of use");
            assert_eq!(actuator.step().input, inputs[0]);
            assert!(actuator.health().is_nominal());
            change(&mut actuator, of_copy, bit);
            look(&mut actuator);
        }
    }
}

/// With one bit of it flipped.
fn flipped<T: Scalar>(number: T, bit: u32) -> T {
    match T::BYTES {
        4 => T::nearest(f64::from(f32::from_bits((number.widen() as f32).to_bits() ^ 1 << bit))),
        _ => T::nearest(f64::from_bits(number.widen().to_bits() ^ 1 << bit)),
    }
}

/// Every kept scalar in turn.
fn kept<T: Scalar>() -> [Change<T>; 9] {
    [
        |actuator, of_copy, bit| {
            actuator.standing.damage(of_copy, |standing| standing.tick.0 ^= 1 << (bit % 32))
        },
        |actuator, of_copy, bit| {
            actuator
                .standing
                .damage(of_copy, |standing| standing.last_input[0] = flipped(standing.last_input[0], bit));
        },
        |actuator, of_copy, bit| {
            actuator.standing.damage(of_copy, |standing| standing.idle ^= 1 << (bit % 16))
        },
        |actuator, of_copy, bit| {
            actuator.standing.damage(of_copy, |standing| {
                standing.buffered =
                    standing.buffered.map(|(tick, length)| (Tick(tick.0 ^ 1 << (bit % 32)), length));
            });
        },
        |actuator, of_copy, bit| {
            actuator.standing.damage(of_copy, |standing| {
                standing.buffered = standing.buffered.map(|(tick, length)| (tick, length ^ 1 << (bit % 32)));
            });
        },
        |actuator, of_copy, _| actuator.standing.damage(of_copy, |standing| standing.buffered = None),
        |actuator, of_copy, bit| {
            actuator.settings.damage(of_copy, |settings| {
                let limits = settings.limits.as_mut().expect("there are limits");
                limits.max[0] = flipped(limits.max[0], bit);
            });
        },
        |actuator, of_copy, _| actuator.settings.damage(of_copy, |settings| settings.limits = None),
        |actuator, of_copy, _| {
            actuator.settings.damage(of_copy, |settings| settings.default_input = DefaultInput::Zero)
        },
    ]
}

fn is_lost_and_safe<T: Scalar>(actuator: &mut Actuator<'_, T, 1>) {
    assert_eq!(actuator.health(), LOST, "told before anything is applied");
    for _ in 0..3 {
        let Applied { input: applied, age, .. } = actuator.step();
        assert_eq!((applied, age), (input(SAFE), Age::Empty));
        assert_eq!(actuator.acknowledgement(8), None);
        let tick = actuator.tick();
        let newer = ControlSequence { tick, inputs: &[input(1.0)] };
        actuator.offer(&newer).expect_err("it takes nothing any more");
    }
    actuator.restart(Tick(100));
    assert_eq!(actuator.step().tick, Tick(100));
    assert_eq!(actuator.health(), LOST, "a clock that jumps mends no memory");
}

#[test]
fn a_bit_in_any_kept_scalar_makes_the_actuator_lost_and_the_plant_safe() {
    with_changes::<f32>(&kept(), is_lost_and_safe);
    with_changes::<f64>(&kept(), is_lost_and_safe);
}

#[test]
fn a_bit_in_the_input_that_is_due_is_not_applied() {
    fn due<T: Scalar>() -> [Change<T>; 1] {
        [|actuator, of_copy, bit| {
            let room = if of_copy { &mut actuator.copy } else { &mut actuator.buffer };
            room[1][0] = flipped(room[1][0], bit);
        }]
    }
    fn look<T: Scalar>(actuator: &mut Actuator<'_, T, 1>) {
        assert_eq!(actuator.step().input, input(SAFE));
        is_lost_and_safe(actuator);
    }
    with_changes::<f32>(&due(), look);
    with_changes::<f64>(&due(), look);
}

#[test]
fn a_bit_in_the_input_for_lost_memory_leaves_that_of_the_settings() {
    let change: Change<f32> = |actuator, of_copy, bit| {
        actuator.safe_input.damage(of_copy, |safe| safe[0] = flipped(safe[0], bit));
        actuator.report_memory_fault();
    };
    with_changes(&[change], is_lost_and_safe);
}

#[test]
fn settings_that_were_wrong_from_the_start_are_found_before_the_first_cycle() {
    let right = settings::<f32>(Some(0.1));
    let expected = right.checksum();
    let wrong = |change: fn(&mut Settings<f32, 1>)| {
        let mut settings = right;
        change(&mut settings);
        let mut memory = [input(0.0); memory_len(LENGTH)];
        let mut actuator = Actuator::new(settings, Tick(0), &mut memory);
        assert!(actuator.check_memory(expected, usize::MAX), "a round has ended");
        actuator.health()
    };
    assert!(wrong(|_| ()).is_nominal());
    assert_eq!(wrong(|settings| settings.default_input = DefaultInput::Zero), LOST);
    assert_eq!(wrong(|settings| settings.limits = None), LOST);
    assert_eq!(wrong(|settings| settings.safe = None), LOST);
    assert_eq!(wrong(|settings| settings.safe.as_mut().expect("there").after ^= 1), LOST);
    assert_eq!(wrong(|settings| settings.safe.as_mut().expect("there").input[0] += 0.25), LOST);
    assert_eq!(wrong(|settings| settings.limits.as_mut().expect("there").min[0] *= 2.0), LOST);
    assert_eq!(wrong(|settings| settings.limits.as_mut().expect("there").rate = None), LOST);
}

#[test]
fn the_safe_input_is_reached_as_slowly_as_inputs_may_change() {
    let mut memory = [input::<f32>(0.0); memory_len(LENGTH)];
    let mut actuator = Actuator::new(settings(Some(0.2)), Tick(0), &mut memory);
    actuator.report_memory_fault();
    let applied = [(); 4].map(|()| actuator.step().input[0]);
    assert_eq!(applied, [-0.2, -0.4, -0.5, -0.5]);
}
