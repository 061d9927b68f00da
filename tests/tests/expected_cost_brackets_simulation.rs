//! The simulated loop, estimator included, costs what (3.33) says: between the bounds that the report gives.

use gain_gen::{design::Design, report::Report, solve::Method};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    sample::{mean, standard_error},
};

const RUNS: usize = 1000;

/// Cycles of start-up, and those counted after it.
struct Horizon {
    start_up: usize,
    counted: usize,
}

fn costs(design: &Design, contender: &Contender, steps: usize) -> Vec<f64> {
    let plan = Plan { runs: RUNS, steps, seed: 5 };
    let simulate = Simulate { design, contender, plan, done: &|| () };
    simulate.outcome().expect("it can be simulated").costs
}

/// The simulated cost per step lies between the report's bounds, up to four standard errors.
fn brackets(text: &str, horizon: &Horizon) {
    let design = Design::parse(text, "design.toml").expect("a design");
    let estimation = Report::new(&design, Method::InFlight).estimation;
    let (lower, upper) = (estimation.cost_lower, estimation.cost_upper);
    let contender =
        Contender::new(Kind::Slqg, &design, horizon.start_up + horizon.counted).expect("a stabilised loop");
    // The same seed gives a long run the short one's beginning; in steady state both end with the same expected
    // terminal term, so their difference is the cost of the steps between.
    let early = costs(&design, &contender, horizon.start_up);
    let late = costs(&design, &contender, horizon.start_up + horizon.counted);
    let found: Vec<f64> =
        early.iter().zip(&late).map(|(early, late)| (late - early) / horizon.counted as f64).collect();
    let (mean, error) = (mean(&found), standard_error(&found));
    eprintln!("{}: {mean:.6} +- {error:.6} simulated, {lower:.6} to {upper:.6} in theory", design.name);
    assert!(lower - 4.0 * error <= mean && mean <= upper + 4.0 * error, "{}: {mean} +- {error}", design.name);
    assert!(upper < 1.05 * lower && error < 0.01 * mean, "{}: bounds too wide to tell", design.name);
}

#[test]
fn double_integrator_on_the_good_network_costs_what_the_bounds_say() {
    let horizon = Horizon { start_up: 200, counted: 1000 };
    brackets(include_str!("../../designs/double_integrator.toml"), &horizon);
}

#[test]
fn double_integrator_on_the_bad_network_costs_what_the_bounds_say() {
    let horizon = Horizon { start_up: 200, counted: 1000 };
    brackets(include_str!("../../designs/double_integrator_bad.toml"), &horizon);
}

#[test]
fn pendulum_on_the_good_network_costs_what_the_bounds_say() {
    let horizon = Horizon { start_up: 1000, counted: 1000 };
    brackets(include_str!("../../designs/pendulum.toml"), &horizon);
}
