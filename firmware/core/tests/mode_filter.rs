//! The joint estimate of state and ages against the exact one: every way the packets may have come, a Kalman filter for
//! each.

#[path = "random/dice.rs"]
mod dice;
mod driven;
mod lent;
mod mixture;
#[path = "driven/plain.rs"]
mod plain;

use dice::Dice;
use driven::{Driven, MERGINGS, ages};
use mixture::{BOTH, LENGTH, Scenario};
use plain::{Plain, agree, widened};
use slqg::estimator::Merging;
use slqg::{DefaultInput, Scalar, Tick};

type Filter<T> = Driven<T, 2, 1, 1, LENGTH, 8>;

/// Runs an estimator through the scenario and looks at it in every cycle but the first.
fn run<T: Scalar>(
    scenario: &Scenario<T>,
    merging: Merging,
    is_acknowledged: impl Fn(usize) -> bool,
    is_measured: impl Fn(usize) -> bool,
    look: impl FnMut(usize, &mut Filter<T>),
) {
    run_in(scenario.link.driven(merging, 7, Tick(0)), scenario, is_acknowledged, is_measured, look);
}

/// The same with this estimator.
fn run_in<T: Scalar>(
    mut driven: Filter<T>,
    scenario: &Scenario<T>,
    is_acknowledged: impl Fn(usize) -> bool,
    is_measured: impl Fn(usize) -> bool,
    mut look: impl FnMut(usize, &mut Filter<T>),
) {
    for now in 0..=scenario.sent.len() {
        if is_measured(now) {
            driven.filter.measure(Tick(now as u32), scenario.outputs[now]).expect("in time");
        }
        if let Some(last) = now.checked_sub(1).filter(|last| is_acknowledged(*last)) {
            assert!(driven.filter.acknowledge(Tick(last as u32), scenario.applied[last].age));
        }
        driven.filter();
        if now > 0 {
            look(now, &mut driven);
        }
        if let Some(sent) = scenario.sent.get(now) {
            driven.advance(*sent);
        }
    }
}

/// Random scenarios of `cycles` cycles.
fn scenarios<T: Scalar>(
    count: usize,
    cycles: usize,
    mut check: impl FnMut(DefaultInput, Scenario<T>, &mut Dice),
) {
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    for _ in 0..count {
        for default_input in BOTH {
            check(default_input, Scenario::new(&mut dice, default_input, cycles), &mut dice);
        }
    }
}

#[test]
fn without_measurements_ages_are_as_likely_as_all_ways_to_arrive_make_them() {
    scenarios::<f64>(60, 6, |_, scenario, dice| {
        let ways = scenario.ways();
        let share = [0.0, 0.3, 0.7][(dice.roll() * 3.0) as usize];
        let acknowledged = [(); 6].map(|()| dice.roll() < share);
        for merging in MERGINGS {
            run::<f64>(
                &scenario,
                merging,
                |at| acknowledged[at],
                |_| false,
                |now, driven| {
                    let known = scenario.known(&ways, now, |at| acknowledged[at], |_| false);
                    let found = driven.probabilities();
                    assert!(
                        agree(&found, &known.probabilities, 1e-12),
                        "{found:?} {:?}",
                        known.probabilities
                    );
                    assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                    let input = driven.expected_input(Tick(now as u32 - 1)).expect("filtered")[0];
                    assert!((input - known.input).abs() < 1e-12, "{input} instead of {}", known.input);
                },
            );
        }
    });
}

#[test]
fn an_acknowledged_age_is_certain() {
    scenarios::<f32>(20, 8, |_, scenario, dice| {
        let acknowledged = [(); 8].map(|()| dice.roll() < 0.5);
        for merging in MERGINGS {
            run::<f32>(
                &scenario,
                merging,
                |at| acknowledged[at],
                |_| true,
                |now, driven| {
                    if acknowledged[now - 1] {
                        let played = scenario.applied[now - 1].age;
                        let certain: Vec<f64> =
                            ages::<LENGTH>().map(|age| f64::from(age == played)).collect();
                        assert_eq!(driven.probabilities(), certain);
                        assert_eq!(driven.filter.modes().and_then(|modes| modes.known()), Some(played));
                    }
                },
            );
        }
    });
}

/// With every age known; `tolerance` is relative.
fn is_the_kalman_filter<T: Scalar>(kept: impl Fn(Merging) -> usize, tolerance: f64) {
    scenarios::<T>(50, 40, |_, scenario, dice| {
        let measured: Vec<bool> = (0..=40).map(|_| dice.roll() < 0.7).collect();
        for merging in MERGINGS {
            let model = &widened(&scenario.link.model);
            let [inputs, outputs] = [
                scenario.applied.iter().map(|applied| applied.input.map(T::widen)).collect::<Vec<_>>(),
                scenario.outputs.iter().map(|output| output.map(T::widen)).collect(),
            ];
            let mut plain = Plain::new(model);
            if measured[0] {
                plain.update(model, outputs[0]);
            }
            run_in(
                scenario.link.driven_keeping(kept(merging), merging, 7, Tick(0)),
                &scenario,
                |_| true,
                |at| measured[at],
                |now, driven| {
                    plain.predict(model, inputs[now - 1]);
                    if measured[now] {
                        plain.update(model, outputs[now]);
                    }
                    let found: Vec<f64> = driven.numbers().iter().map(|number| number.widen()).collect();
                    let expected = plain.numbers();
                    assert!(
                        agree(&found, &expected, tolerance),
                        "cycle {now} with {merging:?}: {found:?} {expected:?}"
                    );
                },
            );
        }
    });
}

#[test]
fn with_every_age_known_it_is_the_kalman_filter() {
    is_the_kalman_filter::<f32>(|_| 1, 1e-5);
    is_the_kalman_filter::<f64>(|_| 1, 1e-11);
    is_the_kalman_filter::<f32>(|merging| merging.estimates(LENGTH), 1e-5);
    is_the_kalman_filter::<f64>(|merging| merging.estimates(LENGTH), 1e-11);
}

#[test]
fn with_every_age_known_what_would_be_kept_apart_changes_no_bit() {
    scenarios::<f32>(50, 40, |_, scenario, dice| {
        let measured: Vec<bool> = (0..=40).map(|_| dice.roll() < 0.7).collect();
        let mut single = Vec::new();
        run(&scenario, Merging::Single, |_| true, |at| measured[at], |_, driven| single.push(driven.bits()));
        for merging in MERGINGS {
            run(
                &scenario,
                merging,
                |_| true,
                |at| measured[at],
                |now, driven| assert_eq!(driven.bits(), single[now - 1], "cycle {now} with {merging:?}"),
            );
        }
    });
}

/// Compares with the exact mixture in the last `cycles` cycles, of whose ages some are known; before them all are.
fn is_exact_for(cycles: usize, merging: Merging, is_measured_at_last: bool) {
    const CYCLES: usize = 6;
    let mut uncertain = 0;
    scenarios::<f64>(150, CYCLES, |default_input, scenario, dice| {
        let ways = scenario.ways();
        let known_by_chance = dice.roll() < 0.3;
        let acknowledged =
            |at: usize| at + cycles < CYCLES || (known_by_chance && at + 1 == CYCLES && cycles > 1);
        let gaps = [(); CYCLES + 1].map(|()| dice.roll() < 0.2);
        let measured = |at: usize| !gaps[at] && (at < CYCLES || is_measured_at_last);
        run::<f64>(&scenario, merging, acknowledged, measured, |now, driven| {
            let known = scenario.known(&ways, now, acknowledged, measured);
            let (found, context) = (driven.numbers(), (merging, default_input, now));
            assert!(agree(&found, &known.numbers, 1e-9), "{context:?}: {found:?} {:?}", known.numbers);
            if merging != Merging::Single {
                let found = driven.probabilities();
                assert!(agree(&found, &known.probabilities, 1e-9), "{context:?}: {found:?}");
            }
            uncertain += usize::from(known.probabilities.iter().all(|probability| *probability < 0.9));
        });
    });
    assert!(uncertain > 50, "{uncertain}");
}

#[test]
fn keeping_two_ages_apart_is_exact_for_two_cycles() {
    is_exact_for(2, Merging::Gpb2, true);
}

#[test]
fn keeping_one_age_apart_is_exact_for_one_cycle() {
    is_exact_for(1, Merging::Imm, true);
    is_exact_for(1, Merging::Gpb2, true);
}

#[test]
fn one_estimate_is_exact_for_one_cycle_until_that_is_measured() {
    is_exact_for(1, Merging::Single, false);
}
