//! The event trigger's benefit is the thesis' difference of costs (Lemma 5.1), computed from its own matrices for each
//! history of decisions.

use gain_gen::{
    design::DelayDistribution,
    solve::{LoopProblem, Method, Rollout, Situation, TriggerTables, schedule, solve, trigger_tables},
};
use nalgebra::{DMatrix, DVector, SVector};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use slqg::{
    Age, DefaultInput, Tick,
    checked::NonNegative,
    event::{Candidate, Trigger},
    gains::{Gains, Tables},
    in_flight::InFlight,
    played::Played,
};

const STATES: usize = 3;
const INPUTS: usize = 2;
const LONGEST: usize = 5;
/// Loops per length and default input, and situations for each of them: 500 of each default input.
const LOOPS: usize = 10;
const SITUATIONS: usize = 10;
const NOW: Tick = Tick(1000);

fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-1.0..1.0, count)
}

fn weight(root: &[f64], size: usize, floor: f64) -> DMatrix<f64> {
    let root = DMatrix::from_row_slice(size, size, root);
    &root * root.transpose() + DMatrix::identity(size, size) * floor
}

fn problems(length: usize, default_input: DefaultInput) -> impl Strategy<Value = LoopProblem> {
    let matrices = (numbers(9), numbers(6), numbers(9), numbers(4));
    let link = (proptest::collection::vec(0u32..100, 1..7), 1u32..60);
    (matrices, link).prop_map(move |((a, b, q, r), (weights, loss))| {
        let total = f64::from(weights.iter().sum::<u32>() + loss);
        let delays = weights.iter().map(|&weight| f64::from(weight) / total).collect();
        LoopProblem {
            a: DMatrix::from_row_slice(STATES, STATES, &a),
            b: DMatrix::from_row_slice(STATES, INPUTS, &b),
            q: weight(&q, STATES, 0.1),
            r: weight(&r, INPUTS, 0.2),
            link: DelayDistribution::new(delays).expect("a distribution"),
            length,
            default_input,
        }
    })
}

/// What may be known when it is decided: estimate, packets of age 1 to N (by index), which of them were sent, the age
/// acknowledged, the input applied last.
#[derive(Debug, Clone)]
struct Known {
    state: SVector<f64, STATES>,
    packets: Vec<Vec<SVector<f64, INPUTS>>>,
    was_sent: Vec<bool>,
    age: usize,
    last_input: SVector<f64, INPUTS>,
}

fn knowns(length: usize) -> impl Strategy<Value = Known> {
    let sent = proptest::collection::vec(any::<bool>(), LONGEST);
    (numbers(STATES + INPUTS), numbers(LONGEST * LONGEST * INPUTS), sent, 0..=length).prop_map(
        move |(known, entries, mut was_sent, age)| {
            was_sent.truncate(length.saturating_sub(1));
            if let Some(played) = was_sent.get_mut(age) {
                // What was played was sent.
                *played = true;
            }
            Known {
                state: SVector::from_row_slice(&known[..STATES]),
                packets: (0..length)
                    .map(|packet| {
                        let entry = |at: usize| {
                            SVector::from_fn(|row, _| entries[(packet * LONGEST + at) * INPUTS + row])
                        };
                        (0..length).map(entry).collect()
                    })
                    .collect(),
                was_sent,
                age,
                last_input: SVector::from_row_slice(&known[STATES..]),
            }
        },
    )
}

impl Known {
    /// As the thesis writes it.
    fn situation(&self, default_input: DefaultInput) -> Situation {
        let length = self.packets.len();
        let packets = (1..length).flat_map(|age| &self.packets[age - 1][age..]);
        let held = (default_input == DefaultInput::Hold).then_some(&self.last_input);
        let sent: Vec<f64> = packets.chain(held).flat_map(|input| input.iter().copied()).collect();
        Situation {
            state: DVector::from_column_slice(self.state.as_slice()),
            sent: DVector::from_vec(sent),
            was_sent: self.was_sent.clone(),
            age: self.age,
        }
    }

    /// As a controller remembers it, and what was played.
    fn in_flight(&self) -> (InFlight<'static, f64, INPUTS>, Played<'static, f64, INPUTS>) {
        let length = self.packets.len();
        let (sent, inputs) = (vec![false; length + 1], vec![SVector::zeros(); (length + 1) * length]);
        let first = NOW - (length as u32 - 1);
        let mut in_flight = InFlight::new(length, first, sent.leak(), inputs.leak());
        for age in (1..length).rev() {
            in_flight.candidate().copy_from_slice(&self.packets[age - 1]);
            in_flight.push(self.was_sent[age - 1]);
        }
        let age = if self.age < length { Age::Steps(self.age as u8) } else { Age::Empty };
        (in_flight, Played::Known(age, self.last_input))
    }
}

/// The benefit as a device computes it, in `f64`.
fn benefit(gains: &Gains<'_, f64, STATES, INPUTS>, tables: &TriggerTables, known: &Known) -> f64 {
    let tables = tables.as_tables().expect("finite tables");
    let price = NonNegative::<f64>::new(1.0);
    let trigger = Trigger::<f64, STATES, INPUTS>::check(gains.length(), gains.default_input(), price, tables)
        .expect("tables of the right shape");
    let (in_flight, played) = known.in_flight();
    let [mut room, mut inputs, mut scratch] = [[SVector::zeros(); LONGEST]; 3];
    let expected = in_flight.fill_expected(gains, &played, &mut room);
    gains.fill_sequence(&known.state, expected, &mut inputs);
    let inputs = &inputs[..gains.length()];
    let candidate = Candidate { posterior_mean: &known.state, expected, inputs, displaced: &[], played };
    trigger.benefit(gains, &in_flight, &candidate, &mut scratch, &mut [])
}

fn agrees(default_input: DefaultInput) {
    let mut runner = TestRunner::deterministic();
    let (mut compared, mut worst) = (0, 0.0_f64);
    for length in 1..=LONGEST {
        let mut loops = 0;
        while loops < LOOPS {
            let problem = problems(length, default_input).new_tree(&mut runner).expect("a problem").current();
            let solution = solve(&problem, Method::InFlight);
            let (Some(tables), Some(rollout)) = (trigger_tables(&problem, &solution), Rollout::new(&problem))
            else {
                continue;
            };
            loops += 1;
            let law = &solution.law;
            let (lx, m) = (law.lx.transpose(), law.m.transpose());
            let arrays = Tables::check(lx.as_slice(), m.as_slice(), &law.arrival).expect("numbers");
            let gains = Gains::<f64, STATES, INPUTS>::check(length, default_input, arrays).expect("gains");
            for _ in 0..SITUATIONS {
                let known = knowns(length).new_tree(&mut runner).expect("a situation").current();
                let expected = rollout.benefit(&known.situation(default_input));
                let found = benefit(&gains, &tables, &known);
                let difference = (found - expected).abs() / expected.abs().max(1e-3);
                worst = worst.max(difference);
                assert!(difference < 1e-9, "N = {length}: {found} for {expected}, {known:?}");
                compared += 1;
            }
        }
    }
    eprintln!("{default_input:?}: {compared} situations, worst relative difference {worst:.1e}");
}

#[test]
fn with_zero_default_input_on_500_random_situations() {
    agrees(DefaultInput::Zero);
}

#[test]
fn with_hold_default_input_on_500_random_situations() {
    agrees(DefaultInput::Hold);
}

/// Longest period of the schedules that later packets follow.
const LONGEST_PERIOD: usize = 6;

/// Against a rollout over every p-th packet: the price at which sending now is as good as the best moment to wait for.
fn agrees_over_schedules(default_input: DefaultInput) {
    let mut runner = TestRunner::deterministic();
    let (mut compared, mut worst) = (0, 0.0_f64);
    for length in 1..=LONGEST {
        let mut loops = 0;
        while loops < LOOPS {
            let problem = problems(length, default_input).new_tree(&mut runner).expect("a problem").current();
            let period = 1 + (loops + length) % LONGEST_PERIOD;
            let Some(found) = schedule(&problem, period).filter(|found| found.mean_square_rate < 0.97) else {
                continue;
            };
            let rollout = Rollout::over_schedule(&problem, period).expect("it converges");
            loops += 1;
            let nothing = DMatrix::zeros(STATES, STATES);
            let tables = found.trigger(&problem, &nothing, &nothing);
            let trigger = Trigger::<f64, STATES, INPUTS>::check_schedule(
                length,
                default_input,
                NonNegative::<f64>::new(1.0),
                tables.as_tables().expect("finite tables"),
            )
            .expect("tables of the right shape");
            let (lx, m) = (found.law.lx.transpose(), found.law.m.transpose());
            let arrays = Tables::check(lx.as_slice(), m.as_slice(), &found.law.arrival).expect("numbers");
            let gains = Gains::<f64, STATES, INPUTS>::check(length, default_input, arrays).expect("gains");
            for _ in 0..SITUATIONS {
                let known = knowns(length).new_tree(&mut runner).expect("a situation").current();
                let savings = rollout.savings(&known.situation(default_input));
                let price = |(wait, saving): (usize, &f64)| saving * period as f64 / (wait + 1) as f64;
                let expected = savings.iter().enumerate().map(price).fold(f64::INFINITY, f64::min);
                let (in_flight, played) = known.in_flight();
                let [mut room, mut inputs, mut scratch] = [[SVector::zeros(); LONGEST]; 3];
                let expected_inputs = in_flight.fill_expected(&gains, &played, &mut room);
                gains.fill_sequence(&known.state, expected_inputs, &mut inputs);
                let candidate = Candidate {
                    posterior_mean: &known.state,
                    expected: expected_inputs,
                    inputs: &inputs[..length],
                    displaced: &[],
                    played,
                };
                let mut numbers = vec![0.0; trigger.numbers_len()];
                let benefit = trigger.benefit(&gains, &in_flight, &candidate, &mut scratch, &mut numbers);
                let size = savings.iter().fold(1e-3, |size: f64, saving| size.max(saving.abs()));
                let difference = (benefit - expected).abs() / size;
                worst = worst.max(difference);
                assert!(difference < 1e-9, "N = {length}, p = {period}: {benefit} for {expected}, {known:?}");
                compared += 1;
            }
        }
    }
    eprintln!(
        "{default_input:?}: {compared} situations over schedules, worst relative difference {worst:.1e}"
    );
}

#[test]
fn with_later_packets_on_a_schedule_and_zero_default_input() {
    agrees_over_schedules(DefaultInput::Zero);
}

#[test]
fn with_later_packets_on_a_schedule_and_hold_default_input() {
    agrees_over_schedules(DefaultInput::Hold);
}
