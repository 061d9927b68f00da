//! The verdict where packets depend on each other: by the channel where that is known, undecided where it is not.

use gain_gen::design::Design;
use gain_gen::estimation::EstimationVerdict;
use gain_gen::report::{ControlOnChannel, FailedCondition, NotKnown, Report, Verdict};
use gain_gen::solve::{Knowledge, LoopProblem, Method, correlated};

const BURSTY: &str = include_str!("../../designs/double_integrator_bursty.toml");
const CRITICAL: &str = include_str!("../../designs/critical.toml");
const ACTUATOR: &str = "controller_to_actuator.delays = [0.25, 0.25, 0.25, 0.25]";
const SENSOR: &str = "sensor_to_controller.delays = [1.0]";

fn judged(text: &str) -> Report {
    Report::new(&Design::parse(text, "design.toml").expect("a design"), Method::InFlight)
}

fn changed(from: &str, to: &str) -> Report {
    let text = CRITICAL.replace(from, to);
    assert_ne!(text, CRITICAL);
    judged(&text)
}

#[test]
fn on_a_channel_the_rate_of_these_gains_decides() {
    for (length, expected) in [(1, Verdict::Stable), (3, Verdict::Stable), (4, Verdict::Unstable)] {
        let mut design = Design::parse(BURSTY, "bursty.toml").expect("a design");
        design.set_sequence_length(length);
        let report = Report::new(&design, Method::InFlight);
        assert_eq!(report.verdict(), expected, "N = {length}: {:?}", report.failed_conditions);
        let Some(ControlOnChannel::Rate { rate, .. }) = report.on_channel else { panic!("N = {length}") };
        let channel = design.network.controller_to_actuator.channel().expect("a channel");
        let noise = &design.plant.process_noise;
        let dense = correlated(&LoopProblem::of(&design), channel, noise).expect("few modes");
        // But for the rounding to f32.
        let dense = dense.with(Knowledge::Average).expect("gains").mean_square_rate;
        assert!((rate - dense).abs() < 1e-6, "N = {length}: {rate} {dense}");
    }
}

#[test]
fn measurements_lost_in_a_row_decide_however_many_come_on_average() {
    let bursts = |to_bad: f64, to_good: f64| {
        let link = format!(
            "sensor_to_controller.gilbert_elliott = {{ to_bad = {to_bad}, to_good = {to_good}, good = [1], bad = [] }}"
        );
        changed(SENSOR, &link)
    };
    // |lambda| = 1.5: the squared error grows by 2.25 (1 - to_good) over losses.
    let rare_and_long = bursts(0.01, 0.5);
    assert_eq!(rare_and_long.verdict(), Verdict::Unstable);
    assert!(matches!(rare_and_long.failed_conditions[..], [FailedCondition::LostInARow { .. }]));
    // Half of them are lost, more than independent packets may be, but never two in a row.
    let in_turn = bursts(1.0, 1.0);
    assert_eq!(in_turn.verdict(), Verdict::Stable, "{:?}", in_turn.failed_conditions);
    assert_eq!(in_turn.estimation.verdict, EstimationVerdict::Stable);
    assert!(in_turn.estimation.cost_upper.is_infinite());
}

#[test]
fn an_error_that_is_neither_shown_to_stay_nor_to_grow_leaves_it_undecided() {
    // Two modes seen together: one measurement in a while is not enough for the filter that shows it.
    let text = CRITICAL
        .replace("a = [[0.5, 0], [1, 1.5]], b = [[1], [0]]", "a = [[1.4, 0], [0, -1.3]], b = [[1], [1]]")
        .replace("c = [[1, 0], [0, 1]]", "c = [[1, 1]]")
        .replace("measurement_noise = [[1e-6, 0], [0, 1e-6]]", "measurement_noise = [[1e-6]]")
        .replace(ACTUATOR, "controller_to_actuator.delays = [1]")
        .replace(
            SENSOR,
            "sensor_to_controller.gilbert_elliott = { to_bad = 0.45, to_good = 0.55, good = [1], bad = [] }",
        );
    let report = judged(&text);
    assert_eq!(report.verdict(), Verdict::Undecided);
    let [FailedCondition::Dependent { reason: NotKnown::Between { growth, rate: Some(rate) }, .. }] =
        report.failed_conditions[..]
    else {
        panic!("{:?}", report.failed_conditions)
    };
    assert!(growth < 1.0 && rate > 1.0, "{growth} {rate}");
}

#[test]
fn copies_count_for_the_rate() {
    let copied =
        changed(ACTUATOR, "controller_to_actuator = { delays = [0.25, 0.25, 0.25, 0.25], duplicates = 0.5 }");
    assert_eq!(copied.verdict(), Verdict::Stable, "{:?}", copied.failed_conditions);
    let Some(ControlOnChannel::Rate { rate, .. }) = copied.on_channel else {
        panic!("{:?}", copied.on_channel)
    };
    assert!(rate < 1.0 && (rate - copied.solution.mean_square_rate).abs() > 1e-3, "{rate}");
}

#[test]
fn what_fails_on_average_only_is_undecided_and_not_written() {
    // The buffer of independent packets would run dry too often; these come every other time.
    let link =
        "controller_to_actuator.gilbert_elliott = { to_bad = 1.0, to_good = 1.0, good = [1], bad = [] }";
    let text = CRITICAL.replace(ACTUATOR, link).replace("sequence_length = 4", "sequence_length = 1");
    let mut report = judged(&text);
    assert_eq!(report.verdict(), Verdict::Undecided, "{:?}", report.failed_conditions);
    report.accept_undecided_stability();
    let refused = report.emission().map(|_| ()).expect_err("there are no gains").to_string();
    assert!(!refused.contains("--accept-undecided-stability"), "{refused}");
    assert!(refused.contains("if they were, this would fail: Theorem 3.4 b)"), "{refused}");
}
