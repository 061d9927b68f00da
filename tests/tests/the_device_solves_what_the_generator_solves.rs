//! The gains that a device solves for itself in `f32`, slice by slice, are those of the generator, and its bound on the
//! mean-square rate is one: on random plants, costs and links that follow each other, zero and hold.

use gain_gen::{
    design::{DelayDistribution, Design},
    solve::{LoopProblem, Method, Outcome, Solution, mean_square_rate, solve},
};
use nalgebra::{DMatrix, SMatrix, SVector};
use proptest::{
    prelude::*,
    strategy::ValueTree,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};
use slqg::{
    DefaultInput, Scalar, arrival,
    estimator::Model,
    tuning::{Basis, Progress, Solved, Solver, Unsolved, workspace_len},
};

/// Most steps of a solution, and of its proof.
const MOST_STEPS: u32 = 8000;

/// Longest sequences for which the rate is taken from the dense closed loop, which is slow.
const LONGEST_DENSE: usize = 4;

/// What the device came to on one link: outcome, `Lx` and `M` by rows.
struct Found<T> {
    outcome: Result<Solved<T>, Unsolved>,
    lx: DMatrix<f64>,
    m: DMatrix<f64>,
}

/// A device that meets these links one after the other.
fn device<T: Scalar, const NX: usize, const NU: usize>(
    problem: &LoopProblem,
    links: &[&DelayDistribution],
) -> Vec<Found<T>> {
    let by_rows =
        |matrix: &DMatrix<f64>| -> Vec<T> { matrix.transpose().iter().map(|&v| T::nearest(v)).collect() };
    let survival = |link: &DelayDistribution| {
        let problem = LoopProblem { link: link.clone(), ..problem.clone() };
        problem.survival().iter().map(|&left| T::nearest(left)).collect::<Vec<T>>()
    };
    let model = Model::<T, NX, NU, 1> {
        a: SMatrix::from_fn(|row, column| T::nearest(problem.a[(row, column)])),
        b: SMatrix::from_fn(|row, column| T::nearest(problem.b[(row, column)])),
        c: SMatrix::zeros(),
        process_noise: SMatrix::zeros(),
        measurement_noise: SMatrix::zeros(),
        initial_mean: SVector::zeros(),
        initial_covariance: SMatrix::zeros(),
    };
    let (q, r, g) = (by_rows(&problem.q), by_rows(&problem.r), survival(links[0]));
    let default_input = problem.default_input;
    let basis = Basis { state_cost: &q, input_cost: &r, survival: &g, default_input };
    let dimensions = basis.dimensions(NX, NU);
    let (rows, expected) = (dimensions.sequence_rows(), dimensions.in_flight_rows());
    let mut memory = vec![T::zero(); workspace_len(&dimensions)];
    let mut solver =
        Solver::<T, NX, NU>::new(&model, basis, MOST_STEPS, &mut memory).expect("slices that fit");
    let mut found = Vec::new();
    for link in links {
        solver.begin(&survival(link));
        let outcome = loop {
            match solver.slice() {
                Progress::Working => {}
                Progress::Solved(solved) => break Ok(solved),
                Progress::Unsolved(why) => break Err(why),
                Progress::Idle => unreachable!("it has begun"),
            }
        };
        let mut law = vec![T::zero(); rows * (NX + expected) + arrival::table_len(problem.length)];
        solver.write_law(&mut law);
        let law: Vec<f64> = law.iter().map(|value| value.widen()).collect();
        let (lx, rest) = law.split_at(rows * NX);
        found.push(Found {
            outcome,
            lx: DMatrix::from_row_slice(rows, NX, lx),
            m: DMatrix::from_row_slice(rows, expected, &rest[..rows * expected]),
        });
    }
    found
}

/// Largest difference of two gains, relative to the largest entry of the first one's inputs.
fn difference<T>(found: &Found<T>, solution: &Solution) -> f64 {
    // Nothing can be done over a link on which no packet is in time: all gains are zero.
    let scale = solution.law.lx.amax().max(f64::MIN_POSITIVE);
    (&found.lx - &solution.law.lx).amax() / scale
}

/// The generator's own word on how the loop does under the device's gains.
fn true_rate<T>(found: &Found<T>, problem: &LoopProblem, solution: &Solution) -> f64 {
    let mut law = solution.law.clone();
    law.lx.copy_from(&found.lx);
    law.m.copy_from(&found.m);
    mean_square_rate(problem, &law.mode_gains())
}

fn check<const NX: usize, const NU: usize>(
    problem: &LoopProblem,
    links: &[&DelayDistribution],
) -> [usize; 3] {
    let (single, double) = (device::<f32, NX, NU>(problem, links), device::<f64, NX, NU>(problem, links));
    let [mut solved, mut unstable, mut not_proved] = [0; 3];
    for ((link, single), double) in links.iter().zip(&single).zip(&double) {
        let problem = LoopProblem { link: (*link).clone(), ..problem.clone() };
        let solution = solve(&problem, Method::InFlight);
        if solution.outcome != Outcome::Converged {
            assert!(single.outcome.is_err() && double.outcome.is_err(), "{problem:?}");
            unstable += 1;
            continue;
        }
        if let Ok(Solved { rate, .. }) = double.outcome {
            assert!(difference(double, &solution) < 1e-6, "{:e}: {problem:?}", difference(double, &solution));
            assert!(solution.mean_square_rate < rate + 1e-9, "{problem:?}");
        }
        match single.outcome {
            Ok(Solved { rate, .. }) => {
                let difference = difference(single, &solution);
                assert!(difference < 2e-3, "{difference:e}: {problem:?}");
                if problem.length <= LONGEST_DENSE {
                    let truth = true_rate(single, &problem, &solution);
                    assert!(truth <= f64::from(rate), "{truth} above the bound {rate}: {problem:?}");
                }
                solved += 1;
            }
            Err(_) => not_proved += 1,
        }
    }
    [solved, unstable, not_proved]
}

fn delays(design: &str) -> DelayDistribution {
    let path = format!("{}/../designs/{design}.toml", env!("CARGO_MANIFEST_DIR"));
    Design::load(path.as_ref()).expect("a design").network.controller_to_actuator.delays
}

#[test]
fn the_pendulums_gains_on_either_link_are_the_generators() {
    let (good, bad) = (delays("pendulum"), delays("pendulum_bad"));
    let path = format!("{}/../designs/pendulum.toml", env!("CARGO_MANIFEST_DIR"));
    let problem = LoopProblem::of(&Design::load(path.as_ref()).expect("a design"));
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        for length in [1, 4, 6, 8] {
            let problem = LoopProblem { default_input, ..problem.with_length(length) };
            let [solved, unstable, not_proved] = check::<4, 1>(&problem, &[&good, &bad, &good, &bad]);
            assert_eq!((solved, unstable, not_proved), if length == 1 { (2, 2, 0) } else { (4, 0, 0) });
        }
    }
}

fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0f64, rows * columns)
        .prop_map(move |entries| DMatrix::from_row_slice(rows, columns, &entries))
}

fn link() -> impl Strategy<Value = DelayDistribution> {
    let weights = prop::collection::vec(prop_oneof![4 => 0.0..1.0f64, 1 => Just(0.0)], 1..=8);
    (weights, 0.0..0.4f64).prop_filter_map("something must arrive", |(weights, loss)| {
        let sum: f64 = weights.iter().sum();
        let probabilities = weights.iter().map(|weight| weight / sum * (1.0 - loss)).collect();
        (sum > 1e-3).then(|| DelayDistribution::new(probabilities).ok()).flatten()
    })
}

/// Plants with a spectral radius between 0.5 and 1.2, and three links.
fn problem(states: usize, inputs: usize) -> impl Strategy<Value = (LoopProblem, Vec<DelayDistribution>)> {
    let plant = (matrix(states, states), matrix(states, inputs), 0.5..1.2f64);
    let roots = (matrix(states, states), matrix(inputs, inputs));
    let links = prop::collection::vec(link(), 3);
    (plant, roots, links, 1..=8usize, any::<bool>()).prop_map(
        move |((shape, b, radius), (q, r), links, length, hold)| {
            let largest = shape.complex_eigenvalues().iter().map(|value| value.norm()).fold(1e-3, f64::max);
            let definite = |root: DMatrix<f64>, floor: f64| {
                &root * root.transpose() + DMatrix::identity(root.nrows(), root.nrows()) * floor
            };
            let problem = LoopProblem {
                a: shape * (radius / largest),
                b,
                q: definite(q, 1e-2),
                r: definite(r, 0.1),
                link: links[0].clone(),
                length,
                default_input: if hold { DefaultInput::Hold } else { DefaultInput::Zero },
            };
            (problem, links)
        },
    )
}

#[test]
fn random_designs_in_single_precision_come_to_the_generators_gains() {
    let mut runner =
        TestRunner::new_with_rng(Config::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[11; 32]));
    let mut counts = [0; 3];
    let mut add = |found: [usize; 3]| counts.iter_mut().zip(found).for_each(|(sum, count)| *sum += count);
    for _ in 0..40 {
        let (of, links) = problem(2, 1).new_tree(&mut runner).expect("a problem").current();
        add(check::<2, 1>(&of, &links.iter().collect::<Vec<_>>()));
        let (of, links) = problem(4, 2).new_tree(&mut runner).expect("a problem").current();
        add(check::<4, 2>(&of, &links.iter().collect::<Vec<_>>()));
    }
    let [solved, unstable, not_proved] = counts;
    println!("{solved} solved, {unstable} cannot be stabilised, {not_proved} not proved");
    assert!(solved > 150 && not_proved * 10 < solved, "{solved} solved, {unstable}, {not_proved} not proved");
}
