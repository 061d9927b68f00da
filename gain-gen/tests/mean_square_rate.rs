//! The mean-square rate is the spectral radius of the loop's second moments, close to 1 too.
//!
//! For sequences of one input over a link that delivers a share `q` at once and loses the rest, second moments follow
//! `X+ = (1-q) A X A' + q F X F'` with `F = A + B Lx`: a dense operator, whose radius is known here from its matrix or, where its
//! eigenvalues are equal in blocks, which no computation in `f64` finds, from one with 60 digits.

use gain_gen::{
    design::DelayDistribution,
    solve::{LoopProblem, Method, Solution, solve},
};
use nalgebra::DMatrix;
use slqg::DefaultInput;

fn problem(a: DMatrix<f64>, b: DMatrix<f64>, price: f64, arrives: f64) -> LoopProblem {
    let (states, inputs) = b.shape();
    LoopProblem {
        a,
        b,
        q: DMatrix::identity(states, states),
        r: DMatrix::identity(inputs, inputs) * price,
        link: DelayDistribution::new(vec![arrives]).expect("a distribution"),
        length: 1,
        default_input: DefaultInput::Zero,
    }
}

fn closed(problem: &LoopProblem, solution: &Solution) -> DMatrix<f64> {
    &problem.a + &problem.b * &solution.law.lx
}

fn radius(matrix: &DMatrix<f64>) -> f64 {
    matrix.complex_eigenvalues().iter().map(|value| value.norm()).fold(0.0, f64::max)
}

fn turn(modulus: f64, angle: f64) -> DMatrix<f64> {
    let (sin, cos) = angle.sin_cos();
    DMatrix::from_row_slice(2, 2, &[cos, sin, -sin, cos]) * modulus
}

#[test]
fn over_a_lossy_link_it_is_the_radius_of_the_dense_operator() {
    // Damping from strong to hardly any; several pairs of complex eigenvalues at once.
    for (damping, angles) in [(1e-1, [0.4, 1.9]), (1e-3, [0.7, 0.71]), (1e-5, [1.5, 3.0]), (4e-7, [0.3, 2.0])]
    {
        let mut a = DMatrix::zeros(4, 4);
        for (block, angle) in angles.into_iter().enumerate() {
            a.view_mut((2 * block, 2 * block), (2, 2)).copy_from(&turn(1.0 - damping, angle));
        }
        let b = DMatrix::from_row_slice(4, 1, &[0.0, damping.sqrt(), 0.3 * damping.sqrt(), 0.1]);
        let problem = problem(a, b, 1.0 / damping, 0.8);
        let solution = solve(&problem, Method::InFlight);
        let f = closed(&problem, &solution);
        let operator = problem.a.kronecker(&problem.a) * 0.2 + f.kronecker(&f) * 0.8;
        let expected = radius(&operator);
        let difference = (solution.mean_square_rate - expected).abs();
        assert!(difference < 1e-8, "{damping}: {} {expected}", solution.mean_square_rate);
        assert!(difference < 1e-3 * (1.0 - expected), "{damping}: the distance from 1 counts");
    }
}

#[test]
fn equal_eigenvalues_in_blocks_do_not_disturb_it() {
    let block = |diagonal: f64, above: f64, size: usize| {
        DMatrix::from_fn(size, size, |i, j| match j as isize - i as isize {
            0 => diagonal,
            1 => above,
            _ => 0.0,
        })
    };
    let pair = DMatrix::from_row_slice(
        2,
        2,
        &[0.7648345388626157, 0.6442112450608187, -0.6442112450608187, 0.7648345388626157],
    );
    let mut pairs = DMatrix::identity(2, 2).kronecker(&pair);
    pairs.view_mut((0, 2), (2, 2)).copy_from(&(DMatrix::identity(2, 2) * 0.3));
    let last =
        |size: usize, value: f64| DMatrix::from_fn(size, 1, |i, _| if i + 1 == size { value } else { 0.0 });
    for (name, a, b, price, expected) in [
        ("block", block(0.9999995, 0.5, 2), last(2, 1e-3), 1e14, 0.9999906671078669),
        ("pair", pair, last(2, 0.01), 1e4, 0.9998759142458315),
        ("pairs in a block", pairs, last(4, 1e-4), 1e10, 0.999975133975259),
        ("chain", block(0.9995, 0.1, 3), last(3, 0.01), 1e6, 0.9955581567192078),
    ] {
        let found = solve(&problem(a, b, price, 0.75), Method::InFlight).mean_square_rate;
        assert!((found - expected).abs() < 1e-8, "{name}: {found} {expected}");
    }
}

#[test]
fn over_a_perfect_link_it_is_the_square_of_the_closed_loops_radius() {
    for angle in [0.0, 0.8, 3.1] {
        let problem = problem(turn(1.02, angle), DMatrix::from_row_slice(2, 1, &[0.1, 1.0]), 1e3, 1.0);
        let solution = solve(&problem, Method::InFlight);
        let expected = radius(&closed(&problem, &solution)).powi(2);
        assert!((solution.mean_square_rate - expected).abs() < 1e-12, "{angle}");
    }
}

#[test]
fn a_delay_line_over_any_link_has_rate_zero() {
    let shift = DMatrix::from_fn(40, 40, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
    let b = DMatrix::from_fn(40, 1, |i, _| if i == 39 { 1.0 } else { 0.0 });
    for arrives in [1.0, 0.6] {
        for length in [1, 3] {
            let problem = problem(shift.clone(), b.clone(), 1.0, arrives).with_length(length);
            let solution = solve(&problem, Method::InFlight);
            assert!(solution.is_stabilising());
            assert_eq!(solution.mean_square_rate, 0.0, "{arrives} {length}");
        }
    }
}

#[test]
fn a_plant_that_decays_is_stabilised_over_every_link() {
    for arrives in [1e-6, 0.01, 0.5] {
        for length in [1, 4] {
            let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
            let problem = problem(turn(0.99999, 0.6), b, 1e-6, arrives).with_length(length);
            assert!(solve(&problem, Method::InFlight).is_stabilising(), "{arrives} {length}");
        }
    }
}
