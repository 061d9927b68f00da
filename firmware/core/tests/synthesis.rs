//! The in-flight recursion on random plants and links: solutions solve their equation and mean what they say.

#[path = "random/case.rs"]
mod case;

use case::{Case, some_cases};
use slqg::synthesis::{Dimensions, InvalidProblem, Problem, Synthesis};
use slqg::{DefaultInput, Scalar, arrival, nalgebra};

/// The same with another link.
fn with_delays(mut case: Case, delays: &[f64], loss: f64) -> Case {
    arrival::survival(delays, loss, &mut case.survival);
    case
}

fn workspace(dimensions: Dimensions) -> Vec<f64> {
    vec![0.0; dimensions.workspace_len()]
}

/// Largest difference, relative to the largest value.
fn relative_difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |most: f64, value| most.max(value));
    let difference = largest(&mut found.iter().zip(expected).map(|(f, e)| (f - e).abs()));
    difference / largest(&mut expected.iter().map(|value| value.abs())).max(f64::MIN_POSITIVE)
}

#[test]
fn most_recursions_settle_at_a_fixed_point_with_a_positive_cost() {
    let all = some_cases(300);
    let mut settled = 0;
    for case in &all {
        let mut workspace = workspace(case.dimensions);
        let Some(mut synthesis) = case.solve(&mut workspace) else { continue };
        settled += 1;
        let before = synthesis.value().to_vec();
        assert!(synthesis.optimal_step() < 1e-10);
        assert!(relative_difference(synthesis.value(), &before) < 1e-10, "{case:?}");
        let nx = case.dimensions.states;
        // Padding with zeros adds zero eigenvalues and changes no other.
        let p = nalgebra::SMatrix::<f64, 4, 4>::from_fn(|row, column| {
            if row < nx && column < nx { synthesis.cost_to_go()[row * nx + column] } else { 0.0 }
        });
        assert_eq!(p, p.transpose());
        assert!(p.symmetric_eigenvalues().min() >= -1e-12 * p.norm(), "{p}");
    }
    assert!(settled * 10 >= all.len() * 7, "{settled} of {}", all.len());
}

#[test]
fn the_optimal_gains_cost_what_the_minimum_promises() {
    for case in some_cases(300) {
        let mut workspace = workspace(case.dimensions);
        let mut synthesis =
            Synthesis::new(case.problem(), &mut workspace).expect("slices of the right shape");
        for steps in 0..12 {
            let before = synthesis.value().to_vec();
            synthesis.optimal_step();
            let promised = synthesis.value().to_vec();
            synthesis.value_mut().copy_from_slice(&before);
            synthesis.fixed_step();
            let difference = relative_difference(synthesis.value(), &promised);
            assert!(difference < 1e-10, "{difference:e} after {steps} steps: {case:?}");
        }
    }
}

#[test]
fn any_other_gain_costs_more() {
    for case in some_cases(100) {
        let mut workspace = workspace(case.dimensions);
        let mut synthesis =
            Synthesis::new(case.problem(), &mut workspace).expect("slices of the right shape");
        for _ in 0..5 {
            synthesis.optimal_step();
        }
        let before = synthesis.value().to_vec();
        synthesis.optimal_step();
        let (nx, columns) = (case.dimensions.states, case.dimensions.gain_columns());
        let trace = |p: &[f64]| (0..nx).map(|row| p[row * nx + row]).sum::<f64>();
        let (least, optimal) = (trace(synthesis.cost_to_go()), synthesis.gains().to_vec());
        for row in 0..case.dimensions.sequence_rows() {
            for change in [-0.1, 0.1] {
                let mut gains = optimal.clone();
                gains[row * columns] += change;
                synthesis.value_mut().copy_from_slice(&before);
                synthesis.set_gains(&gains);
                synthesis.fixed_step();
                let cost = trace(synthesis.cost_to_go());
                assert!(cost >= least * (1.0 - 1e-12), "{cost} is less than {least}");
            }
        }
    }
}

/// Runs `steps` steps in `T` and returns the gains.
fn gains_in<T: Scalar>(case: &Case, steps: usize) -> Vec<f64> {
    let narrow = |values: &[f64]| values.iter().map(|value| T::nearest(*value)).collect::<Vec<T>>();
    let (a, b, q, r, survival) =
        (narrow(&case.a), narrow(&case.b), narrow(&case.q), narrow(&case.r), narrow(&case.survival));
    let problem = Problem { dimensions: case.dimensions, a: &a, b: &b, q: &q, r: &r, survival: &survival };
    let mut workspace = vec![T::zero(); case.dimensions.workspace_len()];
    let mut synthesis = Synthesis::new(problem, &mut workspace).expect("slices of the right shape");
    for _ in 0..steps {
        synthesis.optimal_step();
    }
    synthesis.gains().iter().map(|gain| gain.widen()).collect()
}

#[test]
fn single_precision_agrees_with_double_precision() {
    for case in some_cases(200) {
        // Half of the packets arrive at once: every input is applied often enough to be known well.
        let case = with_delays(case, &[0.5, 0.2, 0.1, 0.05, 0.05], 0.1);
        let difference = relative_difference(&gains_in::<f32>(&case, 30), &gains_in::<f64>(&case, 30));
        assert!(difference < 1e-3, "{difference:e}: {case:?}");
    }
}

#[test]
fn one_input_over_a_perfect_link_is_the_linear_quadratic_regulator() {
    for mut case in some_cases(100) {
        case.dimensions.length = 1;
        case.survival = vec![0.0; 1];
        let case = with_delays(case, &[1.0], 0.0);
        let mut workspace = workspace(case.dimensions);
        let Some(mut synthesis) = case.solve(&mut workspace) else {
            panic!("random plants are stabilisable")
        };
        let Dimensions { states: nx, inputs: nu, .. } = case.dimensions;
        // Zero-padded to one size; a unit weight keeps the inputs that do not exist at zero.
        let pad = |values: &[f64], rows: usize, columns: usize| {
            nalgebra::SMatrix::<f64, 4, 4>::from_fn(|row, column| {
                if row < rows && column < columns { values[row * columns + column] } else { 0.0 }
            })
        };
        let (a, b, p) = (pad(&case.a, nx, nx), pad(&case.b, nx, nu), pad(synthesis.cost_to_go(), nx, nx));
        let mut r = pad(&case.r, nu, nu);
        (nu..4).for_each(|input| r[(input, input)] = 1.0);
        let inverse = (r + b.transpose() * p * b).try_inverse().expect("positive definite");
        let gain = -inverse * b.transpose() * p * a;
        let residual = pad(&case.q, nx, nx) + a.transpose() * p * a + a.transpose() * p * b * gain - p;
        assert!(residual.norm() < 1e-10 * p.norm());
        for (row, found) in synthesis.gains().chunks(case.dimensions.gain_columns()).enumerate() {
            let (state, in_flight) = found.split_at(nx);
            assert!(in_flight.iter().all(|gain| *gain == 0.0), "nothing is ever in flight");
            let expected: Vec<f64> = (0..nx).map(|column| gain[(row, column)]).collect();
            assert!(relative_difference(state, &expected) < 1e-9);
        }
    }
}

#[test]
fn inputs_that_can_never_be_applied_have_exactly_zero_gain() {
    // Delays, and the entries of a sequence that are over when it comes, or replaced for certain by then.
    let links: [(&[f64], f64, &[usize]); 4] = [
        (&[0.0, 0.6, 0.2], 0.2, &[0]),
        (&[0.0, 0.0, 0.7], 0.3, &[0, 1]),
        (&[0.7, 0.3], 0.0, &[2, 3, 4]),
        (&[0.0, 0.4, 0.6], 0.0, &[0, 3, 4]),
    ];
    for case in some_cases(100) {
        for (delays, loss, idle) in links {
            let case = with_delays(case.clone(), delays, loss);
            let mut workspace = workspace(case.dimensions);
            let mut synthesis =
                Synthesis::new(case.problem(), &mut workspace).expect("slices of the right shape");
            for _ in 0..20 {
                synthesis.optimal_step();
            }
            let rows = synthesis.gains().chunks(case.dimensions.gain_columns());
            for (row, gains) in rows.enumerate() {
                let entry = row / case.dimensions.inputs;
                if idle.contains(&entry) {
                    assert!(gains.iter().all(|gain| *gain == 0.0), "entry {entry} of {case:?}");
                } else if delays.len() <= case.dimensions.length {
                    assert!(gains.iter().any(|gain| *gain != 0.0), "entry {entry} of {case:?}");
                }
            }
        }
    }
}

#[test]
fn a_recursion_that_has_overflowed_never_looks_settled() {
    // Growth by 2 a step, and four of five packets lost: no gain stabilises this in the mean square.
    let mut case = some_cases(1).remove(0);
    case.dimensions = Dimensions { states: 1, inputs: 1, length: 2, default_input: DefaultInput::Zero };
    case.survival = vec![0.0; 2];
    let case = Case { a: vec![2.0], b: vec![1.0], q: vec![1.0], r: vec![1.0], ..case };
    let case = with_delays(case, &[0.1, 0.1], 0.8);
    let mut workspace = workspace(case.dimensions);
    let mut synthesis = Synthesis::new(case.problem(), &mut workspace).expect("slices of the right shape");
    for step in 0..5000 {
        assert!(synthesis.optimal_step() > 0.1, "step {step}");
    }
    assert!(!synthesis.cost_to_go()[0].is_finite());
}

#[test]
fn a_slice_of_the_wrong_length_is_refused_by_name() {
    let case = some_cases(1).remove(0);
    let good = case.problem();
    let mut space = workspace(case.dimensions);
    let mut refused = |problem| Synthesis::new(problem, &mut space).err();
    assert_eq!(refused(good), None);
    assert_eq!(refused(Problem { a: &good.a[1..], ..good }), Some(InvalidProblem::A));
    assert_eq!(refused(Problem { b: &good.b[1..], ..good }), Some(InvalidProblem::B));
    assert_eq!(refused(Problem { q: &good.q[1..], ..good }), Some(InvalidProblem::Q));
    assert_eq!(refused(Problem { r: &good.r[1..], ..good }), Some(InvalidProblem::R));
    assert_eq!(refused(Problem { survival: &[], ..good }), Some(InvalidProblem::Survival));
    for empty in [
        Dimensions { states: 0, ..good.dimensions },
        Dimensions { inputs: 0, ..good.dimensions },
        Dimensions { length: 0, ..good.dimensions },
    ] {
        assert_eq!(refused(Problem { dimensions: empty, ..good }), Some(InvalidProblem::Empty));
    }
    let short = space.len() - 1;
    let refused = Synthesis::new(good, &mut space[..short]).err();
    assert_eq!(refused, Some(InvalidProblem::Workspace));
}
