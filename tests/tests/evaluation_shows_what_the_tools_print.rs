//! Every table of `docs/evaluation.md` is what the tools print today.

use gain_gen::{design::Design, sweep::Sweep};
use host_sim::{
    contender::{Contender, ContenderError, Kind},
    monte_carlo::{Plan, Simulate},
    output::{Simulation, table},
};
use slqg::DefaultInput;
use std::ops::RangeInclusive;

const EVALUATION: &str = include_str!("../../docs/evaluation.md");

fn design(name: &str) -> Design {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name);
    Design::load(&path.with_extension("toml")).expect("a design")
}

/// Column widths depend on the other rows.
fn is_shown(line: &str) -> bool {
    EVALUATION.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()))
}

/// The rows of a simulation with every controller and length; lengths that cannot be stabilised have none.
fn shows(name: &str, lengths: RangeInclusive<usize>, plan: Plan, kinds: &[Kind]) {
    let mut design = design(name);
    let mut outcomes = Vec::new();
    for &kind in kinds {
        for length in if kind.ignores_length() { 1..=1 } else { lengths.clone() } {
            design.set_sequence_length(length);
            match Contender::new(kind, &design, plan.steps) {
                Ok(contender) => {
                    let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
                    outcomes.push(simulate.outcome().expect("it can be simulated"));
                }
                Err(ContenderError::Unstable { .. }) => {}
                Err(other) => panic!("{other}"),
            }
        }
    }
    let goal = design.tracking.as_ref().map(|tracking| &tracking.goal);
    let simulation =
        Simulation { name: &design.name, sample_time: design.plant.sample_time, goal, plan, outcomes };
    let table = table(&simulation);
    let lines = || table.lines().skip_while(|line| !line.starts_with("controller"));
    // All of it, for whoever brings the page up to date.
    lines().for_each(|line| eprintln!("{line}"));
    for line in lines() {
        assert!(is_shown(line), "not in docs/evaluation.md: {line}");
    }
}

#[test]
fn zero_against_hold() {
    for name in
        ["double_integrator", "double_integrator_bad", "critical", "critical_bad", "pendulum", "pendulum_bad"]
    {
        let sweep = Sweep::new(&design(name), &[1, 2, 3, 4, 6, 8], &[DefaultInput::Zero, DefaultInput::Hold]);
        for (default, spelled) in [(DefaultInput::Zero, "zero"), (DefaultInput::Hold, "hold")] {
            let results = sweep.results.iter().filter(|result| result.default_input == default);
            let mut line = format!("{name} {spelled}");
            for result in results {
                // As many digits as `gain-gen sweep` prints.
                let cost = result.control_cost;
                line += &if cost.is_finite() { format!(" {}", six_digits(cost)) } else { " -".into() };
            }
            assert!(is_shown(&line), "not in docs/evaluation.md: {line}");
        }
    }
}

/// Six significant digits without trailing zeros.
fn six_digits(value: f64) -> String {
    let decimals = (5 - value.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[test]
fn following_with_and_without_preview() {
    let plan = Plan { runs: 100, steps: 500, seed: 1 };
    for name in ["pendulum_tracking", "pendulum_tracking_bad"] {
        shows(name, 1..=6, plan, &[Kind::Slqg, Kind::SlqgNoPreview, Kind::Lqg]);
    }
}

#[test]
fn sending_what_is_worth_it_and_sending_always() {
    let plan = Plan { runs: 200, steps: 200, seed: 1 };
    for name in ["pendulum_event", "pendulum_event_bad"] {
        shows(name, 1..=10, plan, &[Kind::Slqg, Kind::SlqgAlways, Kind::Lqg]);
    }
}

#[test]
fn the_servo_axis_with_everything_at_once() {
    let plan = Plan { runs: 200, steps: 400, seed: 1 };
    shows("drive_event", 8..=8, plan, &[Kind::Slqg, Kind::SlqgAlways, Kind::SlqgNoPreview, Kind::Lqg]);
}
