//! Loops without acknowledgements: the law against reference answers, its exact cost and rate against the loop packet by packet,
//! and properties that must hold.

use gain_gen::design::{Design, Link};
use gain_gen::emit::{Format, Output, emit};
use gain_gen::report::{Report, Verdict};
use gain_gen::solve::{LoopProblem, Method, Unacknowledged, solve, unacknowledged};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use slqg::DefaultInput;
use std::path::Path;

/// The most that a cost may be above the reference: that has a filter of its own, this one that of the device.
const ABOVE: f64 = 2e-5;

fn found(design: &Design) -> Option<Unacknowledged> {
    let problem = LoopProblem::of(design);
    unacknowledged(design, &problem, &solve(&problem, Method::InFlight))
}

fn parsed(text: &str) -> Design {
    Design::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn reference() -> Vec<serde_json::Value> {
    let text = include_str!("../../tests/data/unacknowledged.json");
    serde_json::from_str(text).expect("a list of cases")
}

fn of_reference(case: &serde_json::Value) -> Design {
    parsed(&format!(
        "name = 'case'
[plant]
sample_time = 1
discrete = {{ a = [[1, 1], [0, 1]], b = [[0], [1]] }}
c = {}
process_noise = {}
measurement_noise = {}
initial_mean = [0, 0]
initial_covariance = [[1, 0], [0, 1]]
[cost]
q = {}
r = {}
[network]
controller_to_actuator.delays = {}
sensor_to_controller.delays = [1]
acknowledgement = 'none'
[controller]
sequence_length = {}
",
        case["c"],
        case["process_noise"],
        case["measurement_noise"],
        case["q"],
        case["r"],
        case["delay_pmf"],
        case["sequence_length"],
    ))
}

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn costs_are_those_of_the_reference() {
    for case in reference() {
        let found = found(&of_reference(&case)).expect("a law");
        let excess = found.cost / number(&case["cost"]) - 1.0;
        println!("{}: cost {:.9}, reference {}, excess {excess:.1e}", case["name"], found.cost, case["cost"]);
        assert!(excess < ABOVE && excess > -1e-7, "{excess}");
        assert!(found.is_exact && found.is_least && found.rate < 1.0);
        let acknowledged = number(&case["cost_of_acknowledged_law_with_constant_filter"]);
        assert!(found.cost < 0.95 * acknowledged, "it is better than the law for known ages");
    }
}

/// Within 0 and 1.
fn unit(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A plant, weights, noise and a link, drawn; about every second plant grows.
fn drawn(seed: u64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut within = |least: f64, most: f64| least + (most - least) * unit(&mut random);
    let states = 1 + (seed % 3) as usize;
    let inputs = 1 + (seed % 2) as usize;
    let rows = |count: usize, columns: usize, entry: &mut dyn FnMut(usize, usize) -> f64| {
        let row = |i: usize, entry: &mut dyn FnMut(usize, usize) -> f64| {
            (0..columns).map(|j| entry(i, j).to_string()).collect::<Vec<_>>().join(", ")
        };
        let rows: Vec<_> = (0..count).map(|i| format!("[{}]", row(i, entry))).collect();
        format!("[{}]", rows.join(", "))
    };
    let growth = within(0.7, 1.15);
    let a = rows(states, states, &mut |i, j| if i == j { growth } else { within(-0.3, 0.3) });
    let b = rows(states, inputs, &mut |_, _| within(0.3, 1.5));
    let w = rows(states, states, &mut |i, j| if i == j { 0.2 } else { 0.0 });
    let q = rows(states, states, &mut |i, j| if i == j { 1.0 } else { 0.0 });
    let r = rows(inputs, inputs, &mut |i, j| if i == j { 0.5 } else { 0.0 });
    let c = rows(1, states, &mut |_, _| within(0.5, 1.0));
    let zeros = vec!["0"; states].join(", ");
    let hold = if seed.is_multiple_of(2) { "zero" } else { "hold" };
    let (first, second) = (within(0.45, 0.7), within(0.1, 0.2));
    format!(
        "name = 'drawn'
[plant]
sample_time = 1
discrete = {{ a = {a}, b = {b} }}
c = {c}
process_noise = {w}
measurement_noise = [[0.1]]
initial_mean = [{zeros}]
initial_covariance = {w}
[cost]
q = {q}
r = {r}
[network]
controller_to_actuator.delays = [{first}, {second}, 0.1]
sensor_to_controller.delays = [1]
acknowledgement = 'none'
[controller]
sequence_length = {}
default_input = '{hold}'
",
        1 + seed % 4
    )
}

/// The loop packet by packet: the average cost of `cycles` cycles.
fn simulated(design: &Design, found: &Unacknowledged, cycles: usize, seed: u64) -> f64 {
    let problem = LoopProblem::of(design);
    let (a, b, c) = (&problem.a, &problem.b, &design.plant.c);
    let (states, inputs) = b.shape();
    let length = problem.length;
    let survival = problem.survival();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = |covariance: &DMatrix<f64>| {
        let factor = covariance.clone().cholesky().expect("positive definite").l();
        let unit = DVector::from_fn(covariance.nrows(), |_, _| {
            let (u, v) = (unit(&mut random), unit(&mut random));
            (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        });
        factor * unit
    };
    let mut delays = ChaCha8Rng::seed_from_u64(!seed);
    let flight = problem.default_input.in_flight(length);
    let arrived = |m: usize| 1.0 - survival[m.min(length - 1)];
    let (mut state, mut prior) = (DVector::zeros(states), DVector::zeros(states));
    let mut expected = DMatrix::<f64>::zeros(inputs, flight);
    let mut sent: Vec<(usize, usize, DVector<f64>)> = vec![];
    let mut buffer: Option<(usize, DVector<f64>)> = None;
    let mut last = DVector::zeros(inputs);
    let mut cost = 0.0;
    for cycle in 0..cycles {
        let output = c * &state + normal(&design.plant.measurement_noise);
        let posterior = &prior + &found.filter_gain * (output - c * &prior);
        let sequence =
            &found.law.lx * &posterior + &found.law.m * DVector::from_column_slice(expected.as_slice());
        let draw = unit(&mut delays);
        if let Some(delay) = (0..length).find(|&delay| draw < arrived(delay)) {
            sent.push((cycle, cycle + delay, sequence.clone()));
        }
        for (made, _, inputs) in sent.iter().filter(|(_, at, _)| *at == cycle) {
            if buffer.as_ref().is_none_or(|(newest, _)| newest < made) {
                buffer = Some((*made, inputs.clone()));
            }
        }
        sent.retain(|(_, at, _)| *at > cycle);
        let input = match &buffer {
            Some((made, sequence)) if cycle - made < length => {
                sequence.rows((cycle - made) * inputs, inputs).into_owned()
            }
            _ if problem.default_input == DefaultInput::Hold => last.clone(),
            _ => DVector::zeros(inputs),
        };
        cost += state.dot(&(&problem.q * &state)) + input.dot(&(&problem.r * &input));
        let first = sequence.rows(0, inputs);
        let before = if flight > 0 { expected.column(0).into_owned() } else { DVector::zeros(inputs) };
        let mean = first * arrived(0) + before * (1.0 - arrived(0));
        let shifted = DMatrix::from_fn(inputs, flight, |input, m| {
            let holds = problem.default_input == DefaultInput::Hold;
            let older = if m + 1 < flight {
                expected[(input, m + 1)]
            } else if holds {
                expected[(input, m)]
            } else {
                0.0
            };
            let left = sequence[(m + 1).min(length - 1) * inputs + input];
            arrived(m + 1) * left + (1.0 - arrived(m + 1)) * older
        });
        expected = shifted;
        prior = a * posterior + b * mean;
        state = a * &state + b * &input + normal(&design.plant.process_noise);
        last = input;
    }
    cost / cycles as f64
}

#[test]
fn costs_are_those_of_the_loop_packet_by_packet() {
    let mut seen = 0;
    for seed in 0..14 {
        let design = parsed(&drawn(seed));
        let Some(found) = found(&design) else { continue };
        if found.rate > 0.95 {
            continue;
        }
        let blocks: Vec<_> =
            (0..16).map(|block| simulated(&design, &found, 4000, 100 * seed + block)).collect();
        let mean = blocks.iter().sum::<f64>() / 16.0;
        let variance = blocks.iter().map(|block| (block - mean).powi(2)).sum::<f64>() / 15.0;
        let error = (variance / 16.0).sqrt();
        println!("seed {seed}: cost {}, simulated {mean} +- {error}, rate {}", found.cost, found.rate);
        assert!((mean - found.cost).abs() < 4.0 * error, "seed {seed}: {} {mean} +- {error}", found.cost);
        seen += 1;
    }
    assert!(seen >= 10, "{seen}");
}

#[test]
fn units_change_neither_cost_nor_rate() {
    for seed in [3, 4, 8] {
        let design = parsed(&drawn(seed));
        let mut scaled = design.clone();
        let states = design.plant.a.nrows();
        let unit = DMatrix::from_diagonal(&DVector::from_fn(states, |i, _| [1e-6, 1e5, 1e3][i % 3]));
        let inverse = unit.map(|entry| if entry == 0.0 { 0.0 } else { 1.0 / entry });
        scaled.plant.a = &unit * &design.plant.a * &inverse;
        scaled.plant.b = &unit * &design.plant.b * 1e4;
        scaled.plant.c = &design.plant.c * &inverse * 1e-3;
        scaled.plant.process_noise = &unit * &design.plant.process_noise * &unit;
        scaled.plant.measurement_noise = &design.plant.measurement_noise * 1e-6;
        scaled.cost.q = &inverse * &design.cost.q * &inverse;
        scaled.cost.r = &design.cost.r * 1e8;
        let (found, scaled) = (found(&design).expect("a law"), found(&scaled).expect("a law"));
        assert!((found.cost / scaled.cost - 1.0).abs() < 1e-8, "{} {}", found.cost, scaled.cost);
        assert!((found.rate - scaled.rate).abs() < 1e-6, "{} {}", found.rate, scaled.rate);
    }
}

#[test]
fn a_wired_sensor_makes_the_verdict_stable_and_a_lossy_one_leaves_it_open() {
    let design = of_reference(&reference()[1]);
    let report = Report::new(&design, Method::InFlight);
    assert_eq!(report.verdict(), Verdict::Stable, "{:?}", report.failed_conditions);
    let json = report.to_json();
    assert!(json.contains("\"estimator\": \"linear\"") && json.contains("\"unacknowledged\": {"), "{json}");

    let lossy =
        parsed(&drawn(3).replace("sensor_to_controller.delays = [1]", "sensor_to_controller.delays = [0.8]"));
    let report = Report::new(&lossy, Method::InFlight);
    assert_eq!(report.verdict(), Verdict::Undecided);
    let sentence = report.failed_conditions[0].to_string();
    assert!(sentence.contains("in each cycle hears of all of them with probability 0.8"), "{sentence}");
}

#[test]
fn where_no_law_is_found_the_shortest_length_with_one_is_named() {
    // With every age known, three inputs are just enough.
    let mut design = parsed(
        "name = 'scalar'
[plant]
sample_time = 1
discrete = { a = [[1.35]], b = [[1]] }
c = [[1]]
process_noise = [[1]]
measurement_noise = [[1]]
initial_mean = [0]
initial_covariance = [[1]]
[cost]
q = [[1]]
r = [[0.1]]
[network]
controller_to_actuator.delays = [0.1, 0.2, 0.3, 0.2, 0.1]
sensor_to_controller.delays = [1]
acknowledgement = 'none'
[controller]
sequence_length = 3
",
    );
    let report = Report::new(&design, Method::InFlight);
    assert_eq!(report.verdict(), Verdict::Undecided);
    let told = report.failed_conditions[0].to_string();
    let sentence = "no law was found that keeps second moments bounded; the shortest length for which one was found is N = ";
    let (_, length) = told.split_once(sentence).unwrap_or_else(|| panic!("{told}"));
    design.controller.sequence_length = length.split('.').next().unwrap().parse().expect("a length");
    assert!(found(&design).is_some_and(|found| found.rate < 1.0), "{told}");
    design.controller.sequence_length -= 1;
    assert!(found(&design).is_none());
}

#[test]
fn a_law_for_measurements_at_once_is_told_of_with_its_rate_where_they_are_late() {
    let text = include_str!("../../designs/critical_bad.toml").replace("\"instant\"", "\"none\"");
    let mut design = parsed(&text);
    design.set_sequence_length(8);
    let report = Report::new(&design, Method::InFlight);
    let found = report.unacknowledged.as_ref().expect("a law");
    assert_eq!(found.hears, 1.0);
    assert!(found.rate < 1.0 && found.late_rate.is_some_and(|rate| rate > 1.0), "{:?}", found.late_rate);
    let told = report.failed_conditions.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(told.contains("for such no law was found") && told.contains("by the factor 1."), "{told}");
}

/// In the steady state what is expected is a plan that is kept. A law may do anything with what the plan does not hold, and costs
/// no more; rounding would find out.
#[test]
fn where_the_riccati_equation_has_no_stable_law_discounted_loops_lead_to_one() {
    // The pendulum, one input in each packet: only laws that spare the filter keep second moments bounded.
    let mut design = parsed(include_str!("../../designs/pendulum.toml"));
    design.network.acknowledgement = gain_gen::design::Acknowledgement::None;
    design.set_sequence_length(1);
    let found = found(&design).expect("a law");
    assert!(found.hears < 1.0, "measurements are as late as they are: {}", found.hears);
    assert!(found.rate < 1.0 && found.emitted_rate < 1.0, "{} {}", found.rate, found.emitted_rate);
    // What it led to is where the cost is least.
    assert!(found.is_least);
}

#[test]
fn what_no_noise_reaches_decays_too() {
    let text = include_str!("../../designs/pendulum_bad.toml").replace("\"instant\"", "\"none\"");
    let mut design = Design::parse(&text, "pendulum_bad.toml").expect("a design");
    design.network.sensor_to_controller = Link::perfect();
    for length in 6..=8 {
        design.controller.sequence_length = length;
        let report = Report::new(&design, Method::InFlight);
        let found = report.unacknowledged.as_ref().expect("a law");
        assert!(found.rate < 0.999 && found.emitted_rate < 0.999, "{} {}", found.rate, found.emitted_rate);
        assert_eq!(report.verdict(), Verdict::Stable, "{:?}", report.failed_conditions);
    }
}

#[test]
fn the_first_derivative_of_the_cost_vanishes() {
    let design = of_reference(&reference()[2]);
    let best = found(&design).expect("a law");
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for _ in 0..4 {
        let direction = best.law.lx.map(|_| 2.0 * unit(&mut random) - 1.0);
        let cost = |step: f64| {
            let mut law = best.law.clone();
            law.lx += &direction * step;
            best.cost_with(&design, &law).expect("a stable loop")
        };
        let (h, level) = (1e-4, best.cost);
        let slope = (cost(h) - cost(-h)) / (2.0 * h);
        assert!(slope.abs() < 1e-6 * level.max(1.0) * 10.0, "{slope}");
        assert!(cost(0.02) > level && cost(-0.02) > level);
    }
}

#[test]
fn what_is_not_known_of_the_law_is_refused_or_told_with_a_reason() {
    let design = of_reference(&reference()[1]);
    let mut report = Report::new(&design, Method::InFlight);
    report.find_margins();
    assert_eq!(report.margins, None);
    let text = report.to_string();
    assert!(text.contains("not given           they are not known of a law"), "{text}");
    assert!(report.to_json().contains("\"margins_not_given\": \"they are not known"), "{}", report.to_json());
    let refused = report.certify().expect_err("none is known").to_string();
    assert!(refused.contains("controller.estimator = \"single\""), "{refused}");

    let header = Output::c(Path::new("law.h")).expect("a name");
    let refused =
        header.files(&report.emission().expect("stable"), "case.toml").expect_err("no ages").to_string();
    assert!(refused.contains("the mean of the inputs in place of ages would be missing"), "{refused}");
}

#[test]
fn packets_that_depend_on_each_other_leave_it_open() {
    let bursts = "{ gilbert_elliott = { to_bad = 0.1, to_good = 0.5, good = [0.9], bad = [0.2] } }";
    let text = drawn(3);
    let link = text.lines().find(|line| line.starts_with("controller_to_actuator")).expect("a link");
    let design = parsed(&text.replace(link, &format!("controller_to_actuator = {bursts}")));
    let report = Report::new(&design, Method::InFlight);
    assert_eq!((report.verdict(), report.on_channel), (Verdict::Undecided, None));
    let sentence = report.failed_conditions[0].to_string();
    assert!(sentence.contains("the law without acknowledgements takes them as if they were"), "{sentence}");
}

#[test]
fn a_task_has_gains_for_known_ages_and_the_filter_that_goes_with_them() {
    let design = of_reference(&reference()[1]);
    let mut report = Report::new(&design, Method::InFlight);
    let linear = emit(&report.emission().expect("stable"), "case.toml", Format::Rust).expect("source");
    report.find_task(5).expect("a task");
    let task = emit(&report.emission().expect("a task"), "case.toml", Format::Rust).expect("source");
    for (source, merging, sizes) in [(&linear, "Linear", "linear"), (&task, "Single", "of")] {
        assert!(source.contains(&format!("merging: slqg::estimator::Merging::{merging}")), "{source}");
        assert!(source.contains(&format!("slqg::controller::Sizes::{sizes}(")), "{source}");
    }
    let noise = |source: &str| {
        let (_, rest) = source.split_once("process_noise: ").expect("a model");
        rest.split_once("measurement_noise").expect("more of it").0.to_owned()
    };
    assert_ne!(noise(&linear), noise(&task), "the spread of the input is in one of them");
}
