//! What the estimator's figures come to in a design: the verdict and the cost.

use gain_gen::design::Design;
use gain_gen::estimation::{Estimation, EstimationVerdict, kalman_covariance};
use gain_gen::solve::{LoopProblem, Method, solve};
use plants::{agree, predicted};

mod plants;

const CRITICAL: &str = include_str!("../../designs/critical.toml");

fn estimation(text: &str) -> Estimation {
    let design = Design::parse(text, "design.toml").expect("a design");
    Estimation::of(&design, &solve(&LoopProblem::of(&design), Method::InFlight))
}

#[test]
fn lrac_verdicts_follow_theorems_3_3_and_3_4() {
    let sensor = |delays: &str| CRITICAL.replace("sensor_to_controller.delays = [1.0]", delays);
    // |lambda| = 1.5: the limit of both theorems is 5/9.
    let found = estimation(&sensor("sensor_to_controller.delays = [0.56]"));
    assert_eq!(found.verdict, EstimationVerdict::Stable);
    assert!(agree(found.critical, 5.0 / 9.0, 1e-12) && agree(found.arrival, 0.56, 1e-15));
    assert!(
        found.cost_lower.is_finite() && found.cost_upper.is_finite() && found.cost_lower <= found.cost_upper
    );
    let found = estimation(&sensor("sensor_to_controller.delays = [0.55]"));
    assert_eq!(found.verdict, EstimationVerdict::Unstable);
    assert_eq!((found.cost_lower, found.cost_upper), (f64::INFINITY, f64::INFINITY));
    assert_eq!((found.covariance.lower, found.covariance.upper), (None, None));
}

/// Two states that turn by a quarter in each step and grow by 1.2; the first is measured.
fn quarter_turn(arrival: f64) -> Estimation {
    let text = include_str!("data/quarter_turn.toml").replace("[0.4]", &format!("[{arrival}]"));
    estimation(&text)
}

#[test]
fn a_quarter_turn_needs_more_measurements_than_theorem_3_4_asks_for() {
    // One state is measured in even, one in odd steps: each alone would grow by 1.2^4 from look to look.
    let limit = 1.0 - 1.2_f64.powi(-4);
    for arrival in [0.31, 0.4, limit - 1e-6] {
        let found = quarter_turn(arrival);
        assert_eq!(found.verdict, EstimationVerdict::Unstable, "{arrival}");
        assert_eq!((found.cost_lower, found.cost_upper), (f64::INFINITY, f64::INFINITY));
        assert_eq!((found.covariance.lower, found.covariance.upper), (None, None));
    }
    for arrival in [limit + 1e-6, 0.6] {
        let found = quarter_turn(arrival);
        assert_eq!(found.verdict, EstimationVerdict::Stable, "{arrival}");
        assert!(found.cost_lower.is_finite(), "{arrival}");
    }
    assert_eq!(quarter_turn(limit).verdict, EstimationVerdict::Open);
}

#[test]
fn between_the_theorems_the_exact_limit_decides_and_the_cost_has_a_lower_bound_only() {
    let two_modes = CRITICAL
        .replace("a = [[0.5, 0], [1, 1.5]], b = [[1], [0]]", "a = [[1.3, 0], [0, 1.2]], b = [[1], [1]]")
        .replace("c = [[1, 0], [0, 1]]", "c = [[1, 1]]")
        .replace("measurement_noise = [[1e-6, 0], [0, 1e-6]]", "measurement_noise = [[1e-6]]")
        .replace("sensor_to_controller.delays = [1.0]", "sensor_to_controller.delays = [0.5]")
        .replace(
            "controller_to_actuator.delays = [0.25, 0.25, 0.25, 0.25]",
            "controller_to_actuator.delays = [1]",
        );
    let found = estimation(&two_modes);
    assert!(agree(found.critical, 1.0 - 1.56_f64.powi(-2), 1e-12));
    assert_eq!(found.verdict, EstimationVerdict::Stable);
    assert!(found.covariance.lower.is_some() && found.covariance.upper.is_none());
    assert!(found.cost_lower.is_finite() && found.cost_upper == f64::INFINITY);
}

#[test]
fn without_instant_acknowledgement_nothing_is_claimed_from_above() {
    let text = CRITICAL.replace("acknowledgement = \"instant\"", "acknowledgement = \"none\"");
    assert_ne!(text, CRITICAL);
    let found = estimation(&text);
    assert!(found.covariance.upper.is_none() && found.cost_upper == f64::INFINITY);
    assert!(found.cost_lower.is_finite());
}

#[test]
fn without_network_the_cost_is_that_of_textbook_lqg() {
    let text = CRITICAL.replace("delays = [0.25, 0.25, 0.25, 0.25]", "delays = [1]");
    let design = Design::parse(&text, "design.toml").expect("a design");
    let found = estimation(&text);
    // tr(Q S) + tr(P (S- - S)) with the prior and posterior covariance: the other way to write the cost of LQG.
    let plant = &design.plant;
    let posterior = kalman_covariance(plant);
    let prior = predicted(plant, &posterior);
    let p = solve(&LoopProblem::of(&design), Method::InFlight).cost_to_go;
    let expected = (&design.cost.q * &posterior).trace() + (p * (prior - &posterior)).trace();
    assert!(agree(found.cost_lower / expected, 1.0, 1e-10), "{} {expected}", found.cost_lower);
    assert!(agree(found.cost_upper / expected, 1.0, 1e-10), "{} {expected}", found.cost_upper);
}
