//! The simulated loop costs what the recursion says: tr(P W) per step with the state measured.

use gain_gen::{
    design::{Base, DelayDistribution, Design, Event, Link},
    estimation::Estimation,
    solve::{LoopProblem, Method, schedule, solve},
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    sample::{mean, standard_error},
};

const CRITICAL: &str = include_str!("../../designs/critical.toml");
const RUNS: usize = 4000;
/// Steps after which the start is forgotten: second moments shrink by 0.604 a step.
const START_UP: usize = 100;
const STEPS: usize = 500;

fn costs(design: &Design, contender: &Contender, steps: usize) -> Vec<f64> {
    let plan = Plan { runs: RUNS, steps, seed: 3 };
    let simulate = Simulate { design, contender, plan, done: &|| () };
    simulate.outcome().expect("it can be simulated").costs
}

/// Cost per step of each run once the start-up is over. The same seed gives a long run the short one's beginning, and
/// in steady state both end with the same expected terminal term, so their difference is the cost of the steps between.
fn cost_per_step(design: &Design, contender: &Contender) -> Vec<f64> {
    let early = costs(design, contender, START_UP);
    let late = costs(design, contender, START_UP + STEPS);
    early.iter().zip(&late).map(|(early, late)| (late - early) / STEPS as f64).collect()
}

fn meets_closed_form(design: &Design) {
    let problem = LoopProblem::of(design);
    let expected = solve(&problem, Method::InFlight).control_cost(&design.plant.process_noise);
    meets(design, Kind::Slqg, expected);
}

fn meets(design: &Design, kind: Kind, expected: f64) {
    let contender = Contender::new(kind, design, STEPS).expect("a stabilised loop");
    let found = cost_per_step(design, &contender);
    let (mean, error) = (mean(&found), standard_error(&found));
    eprintln!("{}: {mean:.3} +- {error:.3} simulated, {expected:.3} in closed form", design.name);
    assert!((mean - expected).abs() <= 4.0 * error, "{}: {mean} +- {error} against {expected}", design.name);
    assert!(error < 0.02 * expected, "{}: too few runs to tell", design.name);
}

#[test]
fn critical_plant_with_its_state_measured_costs_tr_pw_a_step() {
    let mut design = Design::parse(CRITICAL, "critical.toml").expect("a design");
    design.network.sensor_to_controller = Link::perfect();
    assert_eq!(design.controller.sequence_length, 4);
    meets_closed_form(&design);
}

#[test]
fn critical_plant_with_hold_input_costs_tr_pw_a_step() {
    let mut design = Design::parse(CRITICAL, "critical.toml").expect("a design");
    design.network.sensor_to_controller = Link::perfect();
    design.network.controller_to_actuator =
        Link::independent(DelayDistribution::new(vec![0.25, 0.25, 0.2, 0.1]).expect("a distribution"));
    design.controller.default_input = slqg::DefaultInput::Hold;
    meets_closed_form(&design);
}

#[test]
fn a_packet_in_every_second_step_costs_what_the_schedule_says() {
    for default_input in [slqg::DefaultInput::Zero, slqg::DefaultInput::Hold] {
        let text = include_str!("../../designs/double_integrator.toml");
        let mut design = Design::parse(text, "double_integrator.toml").expect("a design");
        design.network.sensor_to_controller = Link::perfect();
        // The start, far away, is another thing.
        design.plant.initial_mean.fill(0.0);
        design.controller.default_input = default_input;
        design.event = Some(Event { base: Base::Every(2), ..Event::at(0.0) });
        let problem = LoopProblem::of(&design);
        let found = schedule(&problem, 2).expect("a stabilised loop");
        // What the state is measured with is not without noise.
        let error = Estimation::of(&design, &solve(&problem, Method::InFlight)).error_covariance();
        let estimated = found.error_weight(&problem).component_mul(&error).sum() / 2.0;
        let expected = found.control_cost(&design.plant.process_noise) + estimated;
        meets(&design, Kind::SlqgPeriodic, expected);
    }
}
