//! What sending is worth is the difference of two expected costs, over every way in which the packets may arrive.

mod lent;
mod situation;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use situation::{CAPACITY, NOW, Situation, situations};
use slqg::checked::NonNegative;
use slqg::event::{Candidate, TableLengths, Tables, Trigger};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::sequence::ControlSequence;
use slqg::synthesis::{Dimensions, LinearCost, Problem, Stage, Synthesis};
use slqg::{Age, DefaultInput};
use std::collections::HashMap;

const NX: usize = 2;
/// Enough for every matrix, vector and reference of a plant of two inputs.
const NUMBERS: usize = 40;

/// A plant, its cost, an estimate and a reference, all random, for `NU` inputs.
struct Plant<const NU: usize> {
    a: SMatrix<f64, NX, NX>,
    b: SMatrix<f64, NX, NU>,
    q: SMatrix<f64, NX, NX>,
    r: SMatrix<f64, NU, NU>,
    state: SVector<f64, NX>,
    /// What the reference asks of state and input; the same in every cycle.
    state_reference: SVector<f64, NX>,
    input_reference: SVector<f64, NU>,
}

impl<const NU: usize> Plant<NU> {
    fn new(numbers: &[f64]) -> Self {
        let mut numbers = numbers.iter().copied();
        let mut next = || numbers.next().expect("enough numbers");
        let a = SMatrix::from_fn(|_, _| next());
        let b = SMatrix::from_fn(|_, _| next());
        let (q, r) =
            (SMatrix::<f64, NX, NX>::from_fn(|_, _| next()), SMatrix::<f64, NU, NU>::from_fn(|_, _| next()));
        Self {
            a,
            b,
            q: q * q.transpose() + SMatrix::identity() * 0.1,
            r: r * r.transpose() + SMatrix::identity() * 0.2,
            state: SVector::from_fn(|_, _| next()),
            state_reference: SVector::from_fn(|_, _| next()),
            input_reference: SVector::from_fn(|_, _| next()),
        }
    }
}

/// The cost-to-go from the next cycle on, by its parts.
struct CostToGo {
    p: Vec<f64>,
    s: Vec<f64>,
    y: Vec<f64>,
    n: Vec<Vec<f64>>,
    sx: Vec<f64>,
    sv: Vec<f64>,
}

/// `left^T matrix right`.
fn form(matrix: &[f64], left: &[f64], right: &[f64]) -> f64 {
    let rows = matrix.chunks(right.len().max(1)).zip(left);
    rows.map(|(row, left)| left * row.iter().zip(right).map(|(entry, right)| entry * right).sum::<f64>())
        .sum()
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(left, right)| left * right).sum()
}

/// The expected cost of this cycle and the cost-to-go after it, up to terms that no decision changes: by enumeration.
fn expected_cost<const NU: usize>(
    situation: &Situation,
    plant: &Plant<NU>,
    to_go: &CostToGo,
    sent_now: Option<&[SVector<f64, NU>]>,
) -> f64 {
    let count = situation.default_input.in_flight(situation.length);
    let packets: Vec<usize> = sent_now.map(|_| 0).into_iter().chain(situation.under_way()).collect();
    // What is played in each way: the ages that are told, and the inputs.
    let played: Vec<(f64, Vec<Age>, Vec<f64>)> = situation
        .ways(&packets)
        .into_iter()
        .map(|(probability, delays)| {
            let (mut actuator, _) = situation.actuator::<NU>();
            let (mut ages, mut inputs) = (vec![], vec![]);
            for m in 0..=count {
                for (b, _) in delays.iter().filter(|(b, delay)| *delay == b + m) {
                    match sent_now.filter(|_| *b == 0) {
                        Some(inputs) => actuator.offer(&ControlSequence { tick: NOW, inputs }).is_ok(),
                        None => situation.arrives(*b, &mut actuator),
                    };
                }
                let applied = actuator.step();
                ages.push(applied.age);
                inputs.extend(applied.input.iter());
            }
            (probability, ages, inputs)
        })
        .collect();
    // The mean of what is applied later, given what was told up to then.
    let mut told: HashMap<String, (f64, Vec<f64>)> = HashMap::new();
    for (probability, ages, inputs) in &played {
        for t in 0..count {
            let (total, sum) =
                told.entry(format!("{:?}", &ages[..=t])).or_insert((0.0, vec![0.0; count * NU]));
            *total += probability;
            sum.iter_mut().zip(&inputs[NU..]).for_each(|(sum, input)| *sum += probability * input);
        }
    }
    let mean = |ages: &[Age]| {
        let (total, sum) = &told[&format!("{ages:?}")];
        sum.iter().map(|sum| sum / total).collect::<Vec<f64>>()
    };
    let cost = |(probability, ages, inputs): &(f64, Vec<Age>, Vec<f64>)| {
        let (input, later) = inputs.split_at(NU);
        let input = SVector::<f64, NU>::from_column_slice(input);
        let state = plant.a * plant.state + plant.b * input;
        let state = state.as_slice();
        let mut cost = input.dot(&(plant.r * (input - plant.input_reference * 2.0)));
        cost += form(&to_go.p, state, state) - 2.0 * dot(&to_go.sx, state) + form(&to_go.y, later, later);
        for (t, n) in to_go.n.iter().enumerate() {
            let expected = mean(&ages[..=t]);
            cost -= form(n, &expected, &expected);
            if t == 0 {
                cost += 2.0 * form(&to_go.s, state, &expected) - 2.0 * dot(&to_go.sv, &expected);
            }
        }
        probability * cost
    };
    played.iter().map(cost).sum()
}

/// The benefit by the trigger, and by enumeration, with the size of the costs it is the difference of.
fn benefits<const NU: usize>(situation: &Situation, plant: &Plant<NU>) -> (f64, f64, f64) {
    let Situation { length, default_input, .. } = *situation;
    let dimensions = Dimensions { states: NX, inputs: NU, length, default_input };
    let (a, survival) = (plant.a.transpose(), situation.survival());
    let b: Vec<f64> = plant.b.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>()).collect();
    let (q, r) = (plant.q.as_slice(), plant.r.as_slice());
    let problem = Problem { dimensions, a: a.as_slice(), b: &b, q, r, survival: &survival };
    let mut workspace = vec![0.0; dimensions.workspace_len()];
    let mut synthesis = Synthesis::new(problem, &mut workspace).expect("slices of the right shape");
    let mut linear_workspace = vec![0.0; dimensions.linear_workspace_len()];
    let mut linear = LinearCost::new(&dimensions, &mut linear_workspace);
    let (state, input) = (plant.q * plant.state_reference, plant.r * plant.input_reference);
    let stage = Stage { state: state.as_slice(), input: input.as_slice(), constant: 0.0 };
    for _ in 0..6 {
        synthesis.optimal_step();
        linear.step_back(&mut synthesis, stage);
    }
    let value = synthesis.value().to_vec();
    let v = dimensions.in_flight_rows();
    let (p, rest) = value.split_at(NX * NX);
    let (s, rest) = rest.split_at(NX * v);
    // Triangles one after the other: `Y`, and `N_t` from in-flight input `t` on.
    let mut rest = rest.iter().copied();
    let mut square = |first: usize| {
        let mut matrix = vec![0.0; v * v];
        for row in first..v {
            for column in first..=row {
                let entry = rest.next().expect("an entry of the triangle");
                matrix[row * v + column] = entry;
                matrix[column * v + row] = entry;
            }
        }
        matrix
    };
    let to_go = CostToGo {
        p: p.to_vec(),
        s: s.to_vec(),
        y: square(0),
        n: (0..dimensions.in_flight()).map(|t| square(t * NU)).collect(),
        sx: linear.state().to_vec(),
        sv: linear.in_flight().to_vec(),
    };
    synthesis.optimal_step();
    linear.step_back(&mut synthesis, stage);
    // The tables are those of the cost-to-go that the law is optimal for.
    synthesis.value_mut().copy_from_slice(&value);
    let tables = OwnedTables::of(&mut synthesis);
    situation.with_law::<NX, NU, _>(synthesis.gains(), |gains, in_flight, played| {
        let expected = lent::expected(in_flight, gains, &played);
        let mut inputs = lent::sequence(gains, &plant.state, &expected);
        for (input, feedforward) in inputs.iter_mut().zip(linear.feedforward().chunks(NU)) {
            *input += SVector::<f64, NU>::from_column_slice(feedforward);
        }
        let displaced: Vec<_> = linear.displaced().chunks(NU).map(SVector::from_column_slice).collect();
        let candidate = Candidate {
            posterior_mean: &plant.state,
            expected: &expected,
            inputs: &inputs,
            displaced: &displaced,
            played,
        };
        let send_cost = NonNegative::<f64>::new(1.0);
        let trigger = Trigger::<f64, NX, NU>::check(length, default_input, send_cost, tables.borrow());
        let trigger = trigger.expect("tables of the right shape");
        let mut room = vec![SVector::zeros(); gains.in_flight()];
        let found = trigger.benefit(gains, in_flight, &candidate, &mut room, &mut []);
        let with = expected_cost(situation, plant, &to_go, Some(&inputs));
        let without = expected_cost(situation, plant, &to_go, None);
        (found, without - with, with.abs() + without.abs())
    })
}

struct OwnedTables {
    state: Vec<f64>,
    in_flight: Vec<f64>,
    sequence: Vec<f64>,
}

impl OwnedTables {
    fn of(synthesis: &mut Synthesis<'_, '_, f64>) -> Self {
        let Dimensions { states, inputs, length, default_input } = synthesis.dimensions();
        let lengths = TableLengths::of(length, default_input, states, inputs);
        let mut tables = Self {
            state: vec![0.0; lengths.state],
            in_flight: vec![0.0; lengths.in_flight],
            sequence: vec![0.0; lengths.sequence],
        };
        synthesis.fill_trigger(&mut tables.state, &mut tables.in_flight, &mut tables.sequence);
        tables
    }

    fn borrow(&self) -> Tables<'_, f64> {
        Tables::check(&self.state, &self.in_flight, &self.sequence).expect("finite")
    }
}

#[test]
fn the_benefit_is_the_difference_of_two_expected_costs() {
    let mut runner = TestRunner::deterministic();
    let inputs = (situations(3), proptest::collection::vec(-1.0..1.0, NUMBERS));
    for _ in 0..1000 {
        let (situation, numbers) = inputs.new_tree(&mut runner).expect("a situation").current();
        let found = [
            benefits(&situation, &Plant::<1>::new(&numbers)),
            benefits(&situation, &Plant::<2>::new(&numbers)),
        ];
        for (found, expected, size) in found {
            assert!((found - expected).abs() < 1e-12 * size, "{found} instead of {expected}: {situation:?}");
        }
    }
}

#[test]
fn a_packet_that_may_part_inputs_made_for_each_other_is_worth_less_than_nothing() {
    // Either (.., 1, -1) is played or (.., -1, 1): the plant, a sum, is back where it was after both, and the mean of
    // what is in flight is zero. Zeros that come one cycle late, half of the time, leave the first without the second.
    let mut numbers = vec![0.0; (CAPACITY + 1) * CAPACITY * 2];
    let mut set = |b: usize, entry: usize, value: f64| numbers[(b * CAPACITY + entry) * 2] = value;
    for (b, entry, value) in [(2, 2, 1.0), (2, 3, -1.0), (1, 1, -1.0), (1, 2, 1.0)] {
        set(b, entry, value);
    }
    let situation = Situation {
        length: 4,
        default_input: DefaultInput::Zero,
        delays: vec![0.0, 0.5],
        loss: 0.5,
        sent: vec![true, true, false, false, false],
        age: Age::Steps(1),
        numbers,
    };
    let plant = Plant {
        a: SMatrix::from_diagonal(&SVector::from([1.0, 0.0])),
        b: SVector::from([1.0, 0.0]),
        q: SMatrix::identity(),
        r: SMatrix::from_element(1e-3),
        state: SVector::zeros(),
        state_reference: SVector::zeros(),
        input_reference: SVector::zeros(),
    };
    let (found, expected, size) = benefits(&situation, &plant);
    assert!((found - expected).abs() < 1e-12 * size);
    assert!(found < -0.1, "{found}");
}
