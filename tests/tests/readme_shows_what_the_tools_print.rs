//! Every figure in the README that does not depend on the machine is what the tools print today.

use gain_gen::{
    design::Design,
    solve::{LoopProblem, Method, solve},
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    output::{Simulation, table},
    size_class::dispatch,
};

const README: &str = include_str!("../../README.md");
const DOUBLE_INTEGRATOR: &str = include_str!("../../designs/double_integrator.toml");
const DOUBLE_INTEGRATOR_BAD: &str = include_str!("../../designs/double_integrator_bad.toml");
const PENDULUM: &str = include_str!("../../designs/pendulum.toml");

/// The lines of `host-sim run` that hold results, header first.
fn results(design: &Design, plan: Plan, kinds: &[Kind]) -> Vec<String> {
    let outcomes = kinds.iter().map(|&kind| {
        let contender = Contender::new(kind, design).expect("a stabilised loop");
        let simulate = Simulate { design, contender: &contender, plan, done: || () };
        dispatch(design, simulate).expect("a size class").expect("gains")
    });
    let simulation = Simulation {
        name: &design.name,
        sample_time: design.plant.sample_time,
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
    for line in results(&design(PENDULUM), plan, &Kind::ALL) {
        assert!(README.contains(&line), "not in the README: {line}");
    }
}

#[test]
fn longer_sequences_on_the_bad_network_cost_what_the_readme_says() {
    let plan = Plan { runs: 200, steps: 200, seed: 1 };
    for length in [1, 2, 3, 4, 6] {
        let mut design = design(DOUBLE_INTEGRATOR_BAD);
        design.controller.sequence_length = length;
        for line in results(&design, plan, &Kind::ALL).iter().skip(1) {
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
