//! Every table of `docs/links.md` is what the tools find today; with `--nocapture` they are printed.

use gain_gen::{
    design::{Acknowledgement, Design, Link},
    solve::{Knowledge, LoopProblem, correlated},
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Outcome, Plan, Simulate},
    output::columns::figure,
    robustness::Robustness,
    sample::{mean, standard_error},
};

const PAGE: &str = include_str!("../../docs/links.md");

fn text(name: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name);
    std::fs::read_to_string(path.with_extension("toml")).expect("a design")
}

fn parsed(text: &str) -> Design {
    Design::parse(text, "design.toml").expect("a design")
}

/// Prints the line and looks for it; column widths do not count.
fn is_on_the_page(line: &str) {
    println!("    {line}");
    let is_shown = PAGE.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()));
    assert!(is_shown, "not in docs/links.md: {line}");
}

fn simulated(design: &Design, contender: &Contender, runs: usize, steps: usize) -> Outcome {
    let plan = Plan { runs, steps, seed: 1 };
    let simulate = Simulate { design, contender, plan, done: &|| () };
    simulate.outcome().expect("it can be simulated")
}

/// Mean, standard error, median, 95 % and runs that diverged.
fn spread(outcome: &Outcome) -> String {
    let found = &outcome.summary;
    let figures = [found.mean_cost, found.std_error, found.median_cost, found.p95_cost].map(figure);
    format!("{} {}", figures.join(" "), found.diverged)
}

#[test]
fn a_pendulum_over_a_loaded_bus() {
    let on_bus = text("pendulum_can");
    // The same frames and the same rounding, but gains for a link on which nothing is ever late.
    let mut ideal = parsed(&on_bus);
    ideal.network.sensor_to_controller = Link::perfect();
    ideal.network.controller_to_actuator = Link::perfect();
    ideal.network.acknowledgement = Acknowledgement::Instant;
    ideal.network.bus = None;
    for load in ["0", "0.4", "0.6", "0.8", "0.9"] {
        let design = parsed(&on_bus.replace("background_load = 0.8", &format!("background_load = {load}")));
        let network = &design.network;
        let Acknowledgement::Over(told) = &network.acknowledgement else {
            panic!("acknowledged over the bus")
        };
        let links = [&network.sensor_to_controller, &network.controller_to_actuator, told];
        let late = links.map(|link| format!("{:.2}", 100.0 * (1.0 - link.delays.probability(0))));
        is_on_the_page(&format!("{load} late {} %", late.join(" ")));
        let contender = |from: &Design| {
            let mut contender = Contender::new(Kind::Slqg, from, 500).expect("a stabilised loop");
            contender.put_on(&design.network);
            contender
        };
        let found = simulated(&design, &contender(&design), 200, 500);
        is_on_the_page(&format!("{load} identified {}", spread(&found)));
        is_on_the_page(&format!(
            "{load} perfect {}",
            spread(&simulated(&ideal, &contender(&ideal), 200, 500))
        ));
        if load == "0" {
            assert!(links.iter().all(|link| link.delays.probabilities() == [1.0]), "nothing can be late");
        }
    }
}

#[test]
fn gains_for_a_channel_that_comes_and_goes() {
    let mut design = parsed(&text("double_integrator_bursty"));
    for length in 1..=6 {
        design.set_sequence_length(length);
        let problem = LoopProblem::of(&design);
        let channel = design.network.controller_to_actuator.channel().expect("a channel");
        let designs = correlated(&problem, channel, &design.plant.process_noise).expect("few modes");
        let of = |knowledge| {
            let found = designs.with(knowledge).expect("gains");
            let cost =
                if found.control_cost.is_finite() { figure(Some(found.control_cost)) } else { "-".into() };
            format!("{:.4} {cost}", found.mean_square_rate)
        };
        is_on_the_page(&format!("{length} {}", Knowledge::ALL.map(of).join(" ")));
    }
    for length in [2, 4] {
        design.set_sequence_length(length);
        let costs = [Kind::Slqg, Kind::SlqgChannel].map(|kind| {
            let contender = Contender::new(kind, &design, 500).expect("a stabilised loop");
            let outcome = simulated(&design, &contender, 500, 500);
            is_on_the_page(&format!("{} {length} {}", kind.name(), spread(&outcome)));
            outcome.costs
        });
        let saved: Vec<f64> =
            costs[0].iter().zip(&costs[1]).map(|(average, known)| average - known).collect();
        is_on_the_page(&format!(
            "saved {length} {} {}",
            figure(Some(mean(&saved))),
            figure(Some(standard_error(&saved)))
        ));
    }
}

#[test]
fn designed_for_one_network_and_run_on_another() {
    for names in [
        &["double_integrator", "double_integrator_bad", "double_integrator_bursty"][..],
        &["pendulum", "pendulum_bad"],
    ] {
        let designs: Vec<Design> = names.iter().map(|name| parsed(&text(name))).collect();
        let contender = |design| Contender::new(Kind::Slqg, design, 200).expect("a stabilised loop");
        let contenders: Vec<Contender> = designs.iter().map(contender).collect();
        let plan = Plan { runs: 200, steps: 200, seed: 1 };
        let table = Robustness::new(&designs, &contenders, plan, || ()).expect("designs that fit").table();
        for line in table.lines().skip(2) {
            is_on_the_page(line);
        }
    }
}

#[test]
fn inputs_of_sixteen_bits() {
    let limits = [
        ("double_integrator", "[[-50, 50]]", "[200]"),
        ("pendulum", "[[-20, 20]]", "[2, 1]"),
        ("critical", "[[-5000, 5000]]", "[5000, 5000]"),
    ];
    for (name, inputs, outputs) in limits {
        let limited = text(name) + &format!("\ninput_limits = {inputs}\n");
        let mut full = parsed(&limited);
        let wire = format!("\n[wire]\nformat = \"can-classic\"\noutput_limits = {outputs}\n");
        // A classic frame has room for three inputs.
        let limited = limited.replace("sequence_length = 4", "sequence_length = 3");
        let compact = parsed(&(limited + &wire));
        full.set_sequence_length(3);
        let [full, compact] = [&full, &compact].map(|design| {
            let contender = Contender::new(Kind::Slqg, design, 200).expect("a stabilised loop");
            simulated(design, &contender, 200, 200)
        });
        let more: Vec<f64> = compact.costs.iter().zip(&full.costs).map(|(c, f)| c - f).collect();
        let (more, error) = (mean(&more), standard_error(&more));
        let whole = full.summary.mean_cost;
        is_on_the_page(&format!("{name} {} {more:.2e} {error:.2e}", figure(whole)));
        assert!(more <= 4.0 * error + 1e-3 * whole.expect("finite"), "{name}: {more} +- {error}");
    }
}
