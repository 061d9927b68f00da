//! The core's own controller and actuator without acknowledgements, against the cost that the report gives: exact where every
//! measurement comes at once, and that of a neighbour where some come late.

use gain_gen::design::{Acknowledgement, Design, Link};
use gain_gen::report::{Report, Verdict};
use gain_gen::solve::Method;
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    sample::{mean, standard_error},
};
use slqg::DefaultInput;

const THEORY: &str = include_str!("../../docs/theory.md");
const GOOD: &str = include_str!("../../designs/double_integrator.toml");
const BAD: &str = include_str!("../../designs/double_integrator_bad.toml");
const CRITICAL: &str = include_str!("../../designs/critical.toml");
const RUNS: usize = 400;
/// What is known at the begin is forgotten by then.
const SETTLED: usize = 300;
const CYCLES: usize = 900;

fn design(text: &str, length: usize, default_input: DefaultInput) -> Design {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    design.controller.default_input = default_input;
    design.network.acknowledgement = Acknowledgement::None;
    design.plant.initial_mean.fill(0.0);
    design
}

/// Cost per cycle of a loop that has run for a while, and its standard error.
fn simulated(design: &Design) -> (f64, f64) {
    let costs = |steps| {
        let contender = Contender::new(Kind::Slqg, design, steps).expect("a stabilised loop");
        let plan = Plan { runs: RUNS, steps, seed: 3 };
        Simulate { design, contender: &contender, plan, done: &|| () }.outcome().expect("a run").costs
    };
    // The same runs, longer.
    let cycles = (CYCLES - SETTLED) as f64;
    let rates: Vec<f64> =
        costs(CYCLES).iter().zip(costs(SETTLED)).map(|(whole, begin)| (whole - begin) / cycles).collect();
    (mean(&rates), standard_error(&rates))
}

fn told(design: &Design) -> (f64, Report) {
    let report = Report::new(design, Method::InFlight);
    (report.unacknowledged.as_ref().expect("a law").cost, report)
}

#[test]
fn exactly_where_every_measurement_comes_at_once() {
    for (text, length) in [(GOOD, 1), (GOOD, 4), (BAD, 4), (CRITICAL, 4)] {
        for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
            let mut design = design(text, length, default_input);
            design.network.sensor_to_controller = Link::perfect();
            let (cost, report) = told(&design);
            assert_eq!(report.verdict(), Verdict::Stable, "{:?}", report.failed_conditions);
            let (found, error) = simulated(&design);
            println!(
                "{} {length} {default_input:?}: {found:.4} +- {error:.4}, report {cost:.4}",
                design.name
            );
            assert!((found - cost).abs() < 4.0 * error, "{found} +- {error}, report {cost}");
        }
    }
}

#[test]
fn about_where_some_come_late_and_the_law_is_the_better_for_it() {
    let mut lines = Vec::new();
    for (name, text) in [("good", GOOD), ("bad", BAD)] {
        let late = design(text, 4, DefaultInput::Zero);
        let (cost, report) = told(&late);
        assert_eq!(report.verdict(), Verdict::Undecided);
        let (found, error) = simulated(&late);
        // The law that takes measurements to come at once, and the filter that goes with it, on the same links.
        let mut at_once = late.clone();
        at_once.network.sensor_to_controller = Link::perfect();
        let mut contender = Contender::new(Kind::Slqg, &at_once, CYCLES).expect("a stabilised loop");
        contender.put_on(&late.network);
        contender.measurement_buffer = late.controller.measurement_buffer;
        let plan = Plan { runs: RUNS, steps: CYCLES, seed: 3 };
        let costs = Simulate { design: &late, contender: &contender, plan, done: &|| () };
        let other = mean(&costs.outcome().expect("a run").costs) / CYCLES as f64;
        lines.push(format!("{name} {cost:.2} {found:.2} {error:.2} {other:.2}"));
        assert!((0.8..1.1).contains(&(found / cost)), "{found} {cost}");
        assert!(found < other, "{found} {other}");
    }
    lines.iter().for_each(|line| println!("{line}"));
    for line in &lines {
        let shown = THEORY.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()));
        assert!(shown, "not in docs/theory.md: {line}");
    }
}
