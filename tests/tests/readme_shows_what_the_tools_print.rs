//! Every figure in the README that does not depend on the machine is what the tools print today.

use gain_gen::{
    design::Design,
    solve::{LoopProblem, Method, solve},
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    output::{Simulation, table},
};

const README: &str = include_str!("../../README.md");
const DOUBLE_INTEGRATOR: &str = include_str!("../../designs/double_integrator.toml");
const DOUBLE_INTEGRATOR_BAD: &str = include_str!("../../designs/double_integrator_bad.toml");
const PENDULUM_EVENT: &str = include_str!("../../designs/pendulum_event.toml");
const DRIVE: &str = include_str!("../../designs/drive_tracking.toml");
const DRIVE_EVENT: &str = include_str!("../../designs/drive_event.toml");
const PENDULUM: &str = include_str!("../../designs/pendulum.toml");

/// The lines of `host-sim run` that hold results, header first.
fn results(design: &Design, plan: Plan, kinds: &[Kind]) -> Vec<String> {
    let outcomes = kinds.iter().map(|&kind| {
        let contender = Contender::new(kind, design, plan.steps).expect("a stabilised loop");
        let simulate = Simulate { design, contender: &contender, plan, done: &|| () };
        simulate.outcome().expect("it can be simulated")
    });
    let simulation = Simulation {
        name: &design.name,
        sample_time: design.plant.sample_time,
        goal: design.tracking.as_ref().map(|tracking| &tracking.goal),
        plan,
        outcomes: outcomes.collect(),
    };
    table(&simulation).lines().skip_while(|line| !line.starts_with("controller")).map(String::from).collect()
}

fn design(text: &str) -> Design {
    Design::parse(text, "design.toml").expect("a design")
}

#[test]
fn the_demonstration_prints_the_table_of_the_readme() {
    let plan = Plan { runs: 200, steps: 500, seed: 1 };
    for line in results(&design(PENDULUM), plan, &[Kind::Slqg, Kind::Lqg]) {
        assert!(README.contains(&line), "not in the README: {line}");
    }
}

#[test]
fn longer_sequences_on_the_bad_network_cost_what_the_readme_says() {
    let plan = Plan { runs: 200, steps: 200, seed: 1 };
    for length in [1, 2, 3, 4, 6] {
        let mut design = design(DOUBLE_INTEGRATOR_BAD);
        design.controller.sequence_length = length;
        for line in results(&design, plan, &[Kind::Slqg, Kind::Lqg]).iter().skip(1) {
            // Column widths depend on the other rows.
            let shown = README.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()));
            assert!(shown, "not in the README: {line}");
        }
    }
}

#[test]
fn the_tables_are_as_small_as_the_readme_says() {
    let problem = LoopProblem::of(&design(DOUBLE_INTEGRATOR)).with_length(20);
    let law = solve(&problem, Method::InFlight).law;
    assert_eq!((law.table_floats(), law.coupled_table_floats()), (610, 80_640));
    assert!(README.contains("610 numbers instead of 80640"));
}

#[test]
fn following_and_keeping_silent_come_to_what_the_readme_says() {
    let shown = |design: &Design, steps, kinds: &[Kind]| {
        results(design, Plan { runs: 200, steps, seed: 1 }, kinds)[1..]
            .iter()
            .map(|line| line.split_whitespace().map(String::from).collect::<Vec<_>>())
            .collect::<Vec<_>>()
    };
    let lines = shown(&design(DRIVE), 400, &[Kind::Slqg, Kind::SlqgNoPreview]);
    assert!(README.contains(&format!("{} to {} (", lines[1][2], lines[0][2])), "{lines:?}");
    let lines = shown(&design(PENDULUM_EVENT), 200, &[Kind::Slqg, Kind::SlqgAlways]);
    assert!(README.contains(&format!("sends in {} % of the cycles", lines[0][7])), "{lines:?}");
    assert!(README.contains(&format!("cost {} instead of {} (", lines[0][10], lines[1][10])), "{lines:?}");
    let lines = shown(&design(DRIVE_EVENT), 400, &[Kind::Slqg, Kind::SlqgAlways]);
    let [with, always] = [&lines[0][2], &lines[1][2]].map(|cost| cost.parse::<f64>().expect("a number"));
    let figures =
        format!("{} % of the packets, for {:.1} % more", lines[0][7], 100.0 * (with / always - 1.0));
    assert!(README.contains(&figures), "{figures}");
}
