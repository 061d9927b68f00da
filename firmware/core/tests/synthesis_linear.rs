//! What a reference adds to the cost is what a task really costs: over every way in which its packets may arrive.

#[path = "random/case.rs"]
mod case;
mod lent;

use case::{Case, some_cases};
use slqg::actuator::Settings;
use slqg::gains::{Gains, Tables};
use slqg::in_flight::InFlight;
use slqg::nalgebra::{SMatrix, SVector};
use slqg::played::Played;
use slqg::synthesis::{LinearCost, Stage, Synthesis};
use slqg::{DefaultInput, Tick, arrival, sequence::ControlSequence};

const NX: usize = 2;
const NU: usize = 2;
const LONGEST: usize = 3;
/// Cycles of a task.
const CYCLES: usize = 4;

/// Where the state is to be and which input costs nothing, for each cycle; the state also at the end.
struct Task<'c> {
    case: &'c Case,
    states: [SVector<f64, NX>; CYCLES + 1],
    inputs: [SVector<f64, NU>; CYCLES],
}

/// A task with the law for it, cycle by cycle.
struct Solved<'c> {
    task: Task<'c>,
    /// `[Lx M]`.
    gains: Vec<Vec<f64>>,
    feedforward: Vec<Vec<f64>>,
    /// `Rbar`.
    sequence_cost: Vec<Vec<f64>>,
    /// What the start at `x` with nothing in flight is expected to cost: `x^T P x - 2 sx^T x + s`.
    p: SMatrix<f64, NX, NX>,
    sx: SVector<f64, NX>,
    constant: f64,
}

impl<'c> Task<'c> {
    fn new(case: &'c Case, seed: usize) -> Self {
        let number = |k: usize, row: usize| ((seed * 7 + k * 3 + row * 5) as f64).sin() * 3.0;
        Self {
            case,
            states: std::array::from_fn(|k| SVector::from_fn(|row, _| number(k, row))),
            inputs: std::array::from_fn(|k| SVector::from_fn(|row, _| number(k + 100, row))),
        }
    }

    fn weights(&self) -> (SMatrix<f64, NX, NX>, SMatrix<f64, NU, NU>) {
        (SMatrix::from_row_slice(&self.case.q), SMatrix::from_row_slice(&self.case.r))
    }

    fn solve(self) -> Solved<'c> {
        let (q, r) = self.weights();
        let dimensions = self.case.dimensions;
        let mut workspace = vec![0.0; dimensions.workspace_len()];
        let mut synthesis =
            Synthesis::new(self.case.problem(), &mut workspace).expect("slices of the right shape");
        let mut linear_workspace = vec![1.0; dimensions.linear_workspace_len()];
        let mut linear = LinearCost::new(&dimensions, &mut linear_workspace);
        let end = self.states[CYCLES];
        synthesis.restart(&self.case.q);
        linear.restart((q * end).as_slice(), end.dot(&(q * end)));
        let (mut gains, mut feedforward, mut sequence_cost) = (vec![], vec![], vec![]);
        for (state, input) in self.states.iter().zip(&self.inputs).rev() {
            synthesis.optimal_step();
            let (state_part, input_part) = (q * state, r * input);
            let constant = state.dot(&state_part) + input.dot(&input_part);
            linear.step_back(
                &mut synthesis,
                Stage { state: state_part.as_slice(), input: input_part.as_slice(), constant },
            );
            gains.insert(0, synthesis.gains().to_vec());
            feedforward.insert(0, linear.feedforward().to_vec());
            sequence_cost.insert(0, synthesis.sequence_cost().to_vec());
        }
        let p = SMatrix::from_row_slice(synthesis.cost_to_go());
        let (sx, constant) = (SVector::from_column_slice(linear.state()), linear.constant());
        Solved { task: self, gains, feedforward, sequence_cost, p, sx, constant }
    }
}

/// Every way in which the packets of a task may arrive: its probability, and the delay of each.
fn ways(survival: &[f64]) -> Vec<(f64, Vec<Option<usize>>)> {
    let before = |d: usize| if d == 0 { 1.0 } else { survival[d - 1] };
    let mut delays: Vec<_> = (0..survival.len()).map(|d| (before(d) - survival[d], Some(d))).collect();
    delays.push((survival[survival.len() - 1], None));
    delays.retain(|(probability, _)| *probability > 0.0);
    let mut ways = vec![(1.0, vec![])];
    for _ in 0..CYCLES {
        let longer = |(so_far, known): &(f64, Vec<Option<usize>>)| {
            let one = |(p, delay): &(f64, Option<usize>)| (so_far * p, [&known[..], &[*delay]].concat());
            delays.iter().map(one).collect::<Vec<_>>()
        };
        ways = ways.iter().flat_map(longer).collect();
    }
    ways
}

impl Solved<'_> {
    /// What is sent in `cycle`, after `played` in the one before.
    fn sequence(
        &self,
        cycle: usize,
        state: &SVector<f64, NX>,
        in_flight: &InFlight<'_, f64, NU>,
        played: &Played<'_, f64, NU>,
    ) -> Vec<SVector<f64, NU>> {
        let dimensions = self.task.case.dimensions;
        let mut table = vec![0.0; arrival::table_len(dimensions.length)];
        arrival::fill_table(&self.task.case.survival, &mut table);
        let rows = || self.gains[cycle].chunks(dimensions.gain_columns());
        let lx: Vec<f64> = rows().flat_map(|row| &row[..NX]).copied().collect();
        let m: Vec<f64> = rows().flat_map(|row| &row[NX..]).copied().collect();
        let tables = Tables::check(&lx, &m, &table).expect("finite, and probabilities");
        let gains =
            Gains::<f64, NX, NU>::check(dimensions.length, dimensions.default_input, tables).expect("valid");
        let mut inputs = lent::sequence(&gains, state, &lent::expected(in_flight, &gains, played));
        for (input, feedforward) in inputs.iter_mut().zip(self.feedforward[cycle].chunks(NU)) {
            *input += SVector::<f64, NU>::from_column_slice(feedforward);
        }
        inputs
    }

    /// The expected cost of the task from `state` on, by playing it in every way; without noise, and the state known.
    fn played(&self, start: &SVector<f64, NX>) -> f64 {
        let case = self.task.case;
        let a = SMatrix::<f64, NX, NX>::from_row_slice(&case.a);
        let b = SMatrix::<f64, NX, NU>::from_row_slice(&case.b);
        let (q, r) = self.task.weights();
        let settings = Settings { default_input: case.dimensions.default_input, limits: None, safe: None };
        let one_way = |(probability, delays): (f64, Vec<Option<usize>>)| {
            let mut actuator = lent::actuator(settings, Tick(0), LONGEST);
            let mut in_flight = lent::in_flight(case.dimensions.length, LONGEST, Tick(0));
            let mut played = Played::nothing();
            let (mut state, mut cost, mut sent) = (*start, 0.0, vec![]);
            for cycle in 0..CYCLES {
                let inputs = self.sequence(cycle, &state, &in_flight, &played);
                lent::push(&mut in_flight, Some(&inputs));
                sent.push(inputs);
                for (made, inputs) in sent.iter().enumerate() {
                    if delays[made].is_some_and(|delay| made + delay == cycle) {
                        let _ = actuator.offer(&ControlSequence { tick: Tick(made as u32), inputs });
                    }
                }
                let applied = actuator.step();
                played = Played::Known(applied.age, applied.input);
                let (off, extra) = (state - self.task.states[cycle], applied.input - self.task.inputs[cycle]);
                cost += off.dot(&(q * off)) + extra.dot(&(r * extra));
                state = a * state + b * applied.input;
            }
            let off = state - self.task.states[CYCLES];
            probability * (cost + off.dot(&(q * off)))
        };
        ways(&case.survival).into_iter().map(one_way).sum()
    }

    fn promised(&self, start: &SVector<f64, NX>) -> f64 {
        start.dot(&(self.p * start)) - 2.0 * self.sx.dot(start) + self.constant
    }
}

/// Random plants of two states and two inputs, with sequences of up to three.
fn small_cases(count: usize) -> Vec<Case> {
    let fits = |case: &Case| {
        let sizes = case.dimensions;
        sizes.states == NX && sizes.inputs == NU && sizes.length <= LONGEST
    };
    some_cases(30 * count).into_iter().filter(fits).take(count).collect()
}

const START: SVector<f64, NX> = SVector::<f64, NX>::new(1.0, -2.0);

#[test]
fn a_task_costs_what_the_linear_part_says() {
    let cases = small_cases(60);
    assert!([DefaultInput::Zero, DefaultInput::Hold].iter().all(|wanted| {
        cases
            .iter()
            .filter(|case| case.dimensions.default_input == *wanted && case.dimensions.length > 1)
            .count()
            > 10
    }));
    for (seed, case) in cases.iter().enumerate() {
        let solved = Task::new(case, seed).solve();
        let (played, promised) = (solved.played(&START), solved.promised(&START));
        assert!((played - promised).abs() < 1e-11 * promised, "{played} instead of {promised}: {case:?}");
    }
}

#[test]
fn any_other_feedforward_costs_more_by_its_quadratic() {
    for (seed, case) in small_cases(30).iter().enumerate() {
        let mut solved = Task::new(case, seed).solve();
        let least = solved.promised(&START);
        for cycle in 0..CYCLES {
            let rows = case.dimensions.sequence_rows();
            let change: Vec<f64> = (0..rows).map(|row| ((seed + cycle + 3 * row) as f64).cos()).collect();
            let optimal = solved.feedforward[cycle].clone();
            for (value, change) in solved.feedforward[cycle].iter_mut().zip(&change) {
                *value += change;
            }
            let more: f64 = solved.sequence_cost[cycle]
                .chunks(rows)
                .zip(&change)
                .map(|(row, left)| {
                    left * row.iter().zip(&change).map(|(cost, right)| cost * right).sum::<f64>()
                })
                .sum();
            let found = solved.played(&START) - least;
            assert!((found - more).abs() < 1e-10 * least, "{found} instead of {more}: {case:?}");
            assert!(more >= 0.0);
            solved.feedforward[cycle] = optimal;
        }
    }
}

/// A state that a constant input keeps where it is, with that input.
fn equilibrium(case: &Case) -> (SVector<f64, NX>, SVector<f64, NU>) {
    let a = SMatrix::<f64, NX, NX>::from_row_slice(&case.a);
    let b = SMatrix::<f64, NX, NU>::from_row_slice(&case.b);
    let input = SVector::<f64, NU>::new(1.0, -0.5);
    let state = (SMatrix::identity() - a).try_inverse().expect("no eigenvalue is 1") * b * input;
    (state, input)
}

/// The feedforward for standing at `(state, input)` for ever, and what a cycle of it costs, relative to a cycle at rest.
fn standing(
    case: &Case,
    synthesis: &mut Synthesis<'_, '_, f64>,
    state: &SVector<f64, NX>,
    input: &SVector<f64, NU>,
) -> (Vec<f64>, f64) {
    let (q, r) =
        (SMatrix::<f64, NX, NX>::from_row_slice(&case.q), SMatrix::<f64, NU, NU>::from_row_slice(&case.r));
    let (state_part, input_part) = (q * state, r * input);
    let constant = state.dot(&state_part) + input.dot(&input_part);
    let stage = Stage { state: state_part.as_slice(), input: input_part.as_slice(), constant };
    let mut workspace = vec![0.0; case.dimensions.linear_workspace_len()];
    let mut linear = LinearCost::new(&case.dimensions, &mut workspace);
    let mut per_cycle = 0.0;
    for _ in 0..2000 {
        let before = linear.constant();
        linear.step_back(synthesis, stage);
        per_cycle = linear.constant() - before;
    }
    (linear.feedforward().to_vec(), per_cycle / constant)
}

/// Calls `check` with the feedforward for an equilibrium, what the law adds to it there, and what a cycle of it costs.
fn at_equilibrium(default_input: DefaultInput, check: impl Fn(&Case, &[f64], &[f64], f64)) -> usize {
    let mut checked = 0;
    for case in small_cases(80) {
        if case.dimensions.default_input != default_input {
            continue;
        }
        let mut workspace = vec![0.0; case.dimensions.workspace_len()];
        let Some(mut synthesis) = case.solve(&mut workspace) else { continue };
        let (state, input) = equilibrium(&case);
        let (feedforward, per_cycle) = standing(&case, &mut synthesis, &state, &input);
        // What the law makes of standing there, with nothing but that input in flight.
        let standing: Vec<f64> = state
            .iter()
            .chain((0..case.dimensions.in_flight()).flat_map(|_| input.iter()))
            .copied()
            .collect();
        let law: Vec<f64> = synthesis
            .gains()
            .chunks(case.dimensions.gain_columns())
            .map(|row| row.iter().zip(&standing).map(|(gain, value)| gain * value).sum())
            .collect();
        check(&case, &feedforward, &law, per_cycle);
        checked += 1;
    }
    checked
}

#[test]
fn with_hold_standing_at_an_equilibrium_is_its_input_again_and_again_and_costs_nothing() {
    let checked = at_equilibrium(DefaultInput::Hold, |case, feedforward, law, per_cycle| {
        let (_, input) = equilibrium(case);
        for (row, (feedforward, law)) in feedforward.iter().zip(law).enumerate() {
            // Inputs that are never applied have no gains, and no feedforward.
            let never = *feedforward == 0.0 && *law == 0.0;
            let sent = feedforward + law;
            assert!(never || (sent - input[row % NU]).abs() < 1e-8, "input {row} is {sent}: {case:?}");
        }
        assert!(per_cycle.abs() < 1e-9, "{per_cycle}: {case:?}");
    });
    assert!(checked > 20, "{checked}");
}

#[test]
fn with_zero_default_a_link_that_loses_packets_makes_standing_there_cost_something() {
    let checked = at_equilibrium(DefaultInput::Zero, |case, _, _, per_cycle| {
        // Every one of these links may lose all packets of a buffer's length.
        assert!(per_cycle > 1e-6, "{per_cycle}: {case:?}");
    });
    assert!(checked > 20, "{checked}");
}
