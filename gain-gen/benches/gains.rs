//! How long gains take, in ratios measured in one run on one thread: `cargo xtask bench gains`.
//!
//! Medians of wall time. A solution is gains, cost-to-go and mean-square rate, at a relative residual of 1e-13. Absolute
//! times are this machine's; what is meant to be quoted are ratios and growth.

use gain_gen::{
    design::Design,
    solve::{LoopProblem, Method, Solution, solve},
};
use std::{
    hint::black_box,
    time::{Duration, Instant},
};

const DOUBLE_INTEGRATOR: &str = include_str!("../../designs/double_integrator_bad.toml");
const PENDULUM: &str = include_str!("../../designs/pendulum.toml");

/// Repeat for about this long, but at least [`FEWEST`] times.
const PATIENCE: Duration = Duration::from_millis(600);
const FEWEST: usize = 3;
/// Longest sequence the coupled solver is timed at: beyond, a solution takes minutes.
const LONGEST_COUPLED: usize = 20;

fn problem(text: &str) -> LoopProblem {
    LoopProblem::of(&Design::parse(text, "design.toml").expect("a design of the project"))
}

/// Median time of a solution in seconds, and the solution.
fn median(problem: &LoopProblem, method: Method) -> (f64, Solution) {
    let mut times = Vec::new();
    let begin = Instant::now();
    loop {
        let start = Instant::now();
        let solution = black_box(solve(black_box(problem), method));
        times.push(start.elapsed().as_secs_f64());
        if times.len() >= FEWEST && begin.elapsed() >= PATIENCE {
            times.sort_by(f64::total_cmp);
            return (times[times.len() / 2], solution);
        }
    }
}

fn largest_difference(found: &Solution, expected: &Solution) -> f64 {
    let (found, expected) = (found.mode_gains(), expected.mode_gains());
    let pairs = found.iter().zip(expected.iter());
    pairs.map(|(found, expected)| (found - expected).amax() / expected.amax()).fold(0.0, f64::max)
}

fn main() {
    let double_integrator = problem(DOUBLE_INTEGRATOR);
    println!("Double integrator on `bad`, zero default\n");
    println!("    N     in-flight  steps  policy        coupled     ratio");
    let mut times = Vec::new();
    for length in [1, 5, 10, 20, 40, 50, 80, 100] {
        let problem = double_integrator.with_length(length);
        let (time, solution) = median(&problem, Method::InFlight);
        assert!(solution.is_stabilising(), "N = {length}");
        let own = format!(
            "{length:>5}  {:>9.3} ms  {:>5}  {:>6}",
            time * 1e3,
            solution.iterations,
            solution.policy_iterations
        );
        if length <= LONGEST_COUPLED {
            let (coupled, reference) = median(&problem, Method::Coupled);
            let difference = largest_difference(&solution, &reference);
            assert!(difference < 1e-9, "N = {length}: gains differ by {difference:e}");
            println!("{own}  {:>10.1} ms  {:>8.0}", coupled * 1e3, coupled / time);
        } else {
            println!("{own}             -         -");
        }
        times.push((length, time));
    }
    let time_at =
        |wanted: usize| times.iter().find(|(length, _)| *length == wanted).map_or(f64::NAN, |entry| entry.1);
    let exponent = (time_at(80) / time_at(20)).ln() / 4f64.ln();
    println!("\n    growth from N = 20 to N = 80: N^{exponent:.2}");

    let boundary = solve(&double_integrator.with_length(1), Method::InFlight);
    let reference = solve(&double_integrator.with_length(1), Method::Coupled);
    println!(
        "    N = 1, near the boundary: rate {:.10} after {} steps, coupled {:.10} after {}",
        boundary.mean_square_rate, boundary.iterations, reference.mean_square_rate, reference.iterations
    );

    let pendulum = problem(PENDULUM);
    let (time, found) = median(&pendulum, Method::InFlight);
    let (coupled, reference) = median(&pendulum, Method::Coupled);
    println!("\nPendulum on `good`, N = {}\n", pendulum.length);
    println!(
        "    in-flight {:.2} ms, {} steps of which {} policy iterations; coupled {:.1} ms, {} value steps; ratio {:.0}",
        time * 1e3,
        found.iterations,
        found.policy_iterations,
        coupled * 1e3,
        reference.iterations,
        coupled / time
    );
    println!(
        "    largest relative difference of a gain to value iteration: {:.1e}",
        largest_difference(&found, &reference)
    );
}
