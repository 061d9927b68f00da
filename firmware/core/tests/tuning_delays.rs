//! The delay estimate against packets that are drawn: what is counted of them is unbiased.

#[path = "random/dice.rs"]
mod dice;
mod lent;

use dice::Dice;
use slqg::tuning::{DelayEstimate, delays_len};
use slqg::{Age, Scalar};
use std::collections::VecDeque;

const LENGTH: usize = 5;
const CYCLES: usize = 20_000;

/// Ages that an actuator plays whose packets are sent in every cycle for which `sent` and arrive after a delay of
/// `hazards`; none else do.
fn played(hazards: &[f64; LENGTH], dice: &mut Dice, sent: impl Fn(usize) -> bool) -> Vec<Age> {
    let mut left = 1.0;
    let probabilities = hazards.map(|hazard| {
        let probability = left * hazard;
        left -= probability;
        probability
    });
    let mut delays: VecDeque<Option<usize>> = VecDeque::new();
    let mut newest: Option<usize> = None;
    let mut ages = Vec::new();
    for cycle in 0..CYCLES {
        delays.push_front(dice.delay(&probabilities).filter(|_| sent(cycle)));
        delays.truncate(LENGTH);
        let arrived = (0..delays.len()).find(|&d| delays[d] == Some(d)).map(|d| cycle - d);
        newest = newest.max(arrived);
        let age = newest.map(|made| cycle - made).filter(|age| *age < LENGTH);
        ages.push(age.map_or(Age::Empty, |age| Age::Steps(age as u8)));
    }
    ages
}

/// Deviations of what was counted from what is to be expected, in standard deviations, by age.
fn deviations(estimate: &DelayEstimate<'_, f64>, hazards: &[f64; LENGTH]) -> [f64; LENGTH] {
    core::array::from_fn(|d| {
        let count = estimate.counted(d);
        let variance = count.under_way * hazards[d] * (1.0 - hazards[d]);
        (count.arrived - count.under_way * hazards[d]) / variance.max(1e-9).sqrt()
    })
}

fn estimate<T: Scalar>(survival: [T; LENGTH], packets: T, memory: T) -> DelayEstimate<'static, T> {
    let room = lent::entries(lent::rubbish(), delays_len(LENGTH));
    DelayEstimate::new(&survival, packets, memory, room).expect("room enough")
}

fn check(known: impl Fn(usize) -> bool, sent: impl Fn(usize) -> bool + Copy) {
    let mut dice = Dice(0x5eed);
    let mut sums = [0.0; LENGTH];
    const LINKS: usize = 40;
    for _ in 0..LINKS {
        let hazards: [f64; LENGTH] = core::array::from_fn(|_| 0.05 + 0.6 * dice.roll());
        let mut estimate = estimate([0.5; LENGTH], 0.0, f64::INFINITY);
        for (cycle, age) in played(&hazards, &mut dice, sent).into_iter().enumerate() {
            estimate.told(Some(age).filter(|_| known(cycle)), |d| cycle >= d && sent(cycle - d));
        }
        for (d, deviation) in deviations(&estimate, &hazards).into_iter().enumerate() {
            assert!(deviation.abs() < 4.5, "age {d}: {deviation} of {hazards:?}");
            sums[d] += deviation;
        }
    }
    // Biases add up over the links, chance does not.
    for (d, sum) in sums.into_iter().enumerate() {
        let mean = sum / (LINKS as f64).sqrt();
        assert!(mean.abs() < 4.0, "age {d}: {mean}");
    }
}

#[test]
fn counted_hazards_are_unbiased_where_every_age_is_known() {
    check(|_| true, |_| true);
}

#[test]
fn ages_that_are_never_told_leave_the_counts_unbiased() {
    // Three of seven cycles, next to each other and alone.
    check(|cycle| ![1, 2, 5].contains(&(cycle % 7)), |_| true);
}

#[test]
fn cycles_without_a_packet_leave_the_counts_unbiased() {
    check(|_| true, |cycle| cycle % 3 != 1);
}

#[test]
fn the_estimate_comes_to_the_link_and_follows_it_when_it_changes() {
    let (first, second) = ([0.7, 0.4, 0.3, 0.2, 0.2], [0.05, 0.1, 0.2, 0.3, 0.2]);
    let mut dice = Dice(0xfade);
    let mut estimate = estimate([0.3_f32, 0.18, 0.126, 0.1, 0.08], 10.0, 1000.0);
    let mut survival = [0.0; LENGTH];
    for hazards in [first, second] {
        for age in played(&hazards, &mut dice, |_| true) {
            estimate.told(Some(age), |_| true);
        }
        estimate.fill_survival(&mut survival);
        let mut left = 1.0;
        for (found, hazard) in survival.iter().zip(hazards) {
            left *= 1.0 - hazard;
            assert!((f64::from(*found) - left).abs() < 0.06, "{survival:?} for {hazards:?}");
        }
    }
}
