//! Thesis 3.4.2, Figure 3.9 on the project's networks: what longer sequences bring, and that nothing beats no network.

use gain_gen::design::Design;
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    sample::mean,
};

const GOOD: &str = include_str!("../../designs/double_integrator.toml");
const BAD: &str = include_str!("../../designs/double_integrator_bad.toml");

fn mean_cost(text: &str, kind: Kind, length: usize) -> f64 {
    let mut design = Design::parse(text, "double_integrator.toml").expect("a design");
    design.controller.sequence_length = length;
    let plan = Plan { runs: 200, steps: 200, seed: 1 };
    let contender = Contender::new(kind, &design, plan.steps).expect("a stabilised loop");
    let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
    mean(&simulate.outcome().expect("it can be simulated").costs)
}

fn costs_by_length(text: &str) -> Vec<f64> {
    (1..=6).map(|length| mean_cost(text, Kind::Slqg, length)).collect()
}

#[test]
fn on_the_bad_network_every_longer_sequence_costs_less() {
    let costs = costs_by_length(BAD);
    assert!(costs.windows(2).all(|pair| pair[1] < pair[0]), "{costs:?}");
}

#[test]
fn on_the_good_network_three_inputs_are_as_good_as_six() {
    let costs = costs_by_length(GOOD);
    let flat = costs[5];
    assert!(costs[2..].iter().all(|cost| (cost / flat - 1.0).abs() < 0.02), "{costs:?}");
}

#[test]
fn no_network_is_never_worse_than_a_network() {
    for text in [GOOD, BAD] {
        let bound = mean_cost(text, Kind::Lqg, 1);
        let costs = costs_by_length(text);
        assert!(costs.iter().all(|cost| *cost > bound), "{costs:?} against {bound}");
    }
}
