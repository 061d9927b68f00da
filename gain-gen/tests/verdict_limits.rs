//! The verdict with input limits: what is shown of a plant on the limit of stability, and what is not.

use gain_gen::design::Design;
use gain_gen::report::{FailedCondition, LimitsShown, NotShown, Report, Verdict};
use gain_gen::solve::Method;

/// An integrator behind a lag.
const AXIS: &str = "name = \"axis\"
[plant]
sample_time = 0.1
discrete = { a = [[1, 0.1], [0, 0.8]], b = [[0], [1]] }
c = [[1, 0]]
process_noise = [[0.01, 0], [0, 0.01]]
measurement_noise = [[0.01]]
initial_mean = [0, 0]
initial_covariance = [[0, 0], [0, 0]]
[cost]
q = [[1, 0], [0, 1]]
r = [[1]]
[network]
controller_to_actuator.delays = [0.7, 0.2]
sensor_to_controller.delays = [0.8, 0.1]
[controller]
sequence_length = 3
scalar = \"f64\"
input_limits = [[-0.1, 0.2]]
";

fn judged(changes: &[(&str, &str)]) -> Report {
    let text = changes.iter().fold(AXIS.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    Report::new(&Design::parse(&text, "axis.toml").expect("a design"), Method::InFlight)
}

fn open(report: &Report) -> Option<NotShown> {
    match report.failed_conditions[..] {
        [FailedCondition::Limited { reason, .. }] => reason,
        _ => panic!("{:?}", report.failed_conditions),
    }
}

#[test]
fn one_integrator_within_limits_is_shown_to_stay_bounded() {
    for changes in [&[][..], &[("sequence_length = 3", "sequence_length = 3\ndefault_input = \"hold\"")]] {
        let report = judged(changes);
        assert_eq!(report.verdict(), Verdict::Stable, "{:?}", report.failed_conditions);
        assert_eq!(report.limits_shown_by(), Some(LimitsShown::Drift));
        assert!(report.to_string().contains("if noise is gaussian"), "{report}");
    }
    let continuous = (
        "discrete = { a = [[1, 0.1], [0, 0.8]], b = [[0], [1]] }",
        "continuous = { a = [[0, 1], [0, -2]], b = [[0], [10]] }",
    );
    assert_eq!(judged(&[continuous]).limits_shown_by(), Some(LimitsShown::Drift));
}

#[test]
fn a_plant_that_decays_needs_no_drift() {
    let report = judged(&[("[1, 0.1]", "[0.9, 0.1]")]);
    assert_eq!((report.verdict(), report.limits_shown_by()), (Verdict::Stable, Some(LimitsShown::Decay)));
}

#[test]
fn a_plant_that_grows_by_however_little_is_never_stable_within_limits() {
    for value in ["1.5", "1.001", "1.000000000001", "1.0000000000000002"] {
        let report = judged(&[("[1, 0.1]", &format!("[{value}, 0.1]"))]);
        assert_eq!(report.verdict(), Verdict::Undecided, "{value}");
        assert_eq!(report.limits_shown_by(), None, "{value}");
    }
    assert_eq!(open(&judged(&[("[1, 0.1]", "[1.0000000000000002, 0.1]")])), Some(NotShown::NotExact));
}

#[test]
fn chains_of_integrators_and_oscillations_without_damping_are_left_open() {
    let both = judged(&[("[0, 0.8]", "[0, 1]")]);
    assert_eq!((both.verdict(), open(&both)), (Verdict::Undecided, Some(NotShown::Modes)));
    let turns = judged(&[("[[1, 0.1], [0, 0.8]]", "[[0.6, -0.8], [0.8, 0.6]]")]);
    assert_eq!((turns.verdict(), open(&turns)), (Verdict::Undecided, Some(NotShown::Modes)));
    let alternates = judged(&[("[1, 0.1]", "[-1, 0.1]")]);
    assert_eq!((alternates.verdict(), open(&alternates)), (Verdict::Undecided, Some(NotShown::Modes)));
}

#[test]
fn what_the_drift_needs_is_asked_for() {
    for (from, to, reason) in [
        ("[-0.1, 0.2]", "[0, 0.2]", NotShown::PushesAway),
        ("[controller]", "[event]\nsend_cost = 0.1\n[controller]", NotShown::Network),
        // Cheap inputs over a link that is always late: sequences that pile up at the limit swing over.
        (
            "controller_to_actuator.delays = [0.7, 0.2]",
            "controller_to_actuator.delays = [0, 0, 0.9]",
            NotShown::Sequences,
        ),
    ] {
        let report = judged(&[(from, to), ("r = [[1]]", "r = [[1e-6]]")]);
        assert_eq!((report.verdict(), open(&report)), (Verdict::Undecided, Some(reason)), "{to}");
    }
}
