//! The estimator's figures against closed forms, exact enumeration and the equations they solve.

use gain_gen::design::{DelayDistribution, Design, Plant};
use gain_gen::estimation::{
    CovarianceBounds, Estimation, EstimationVerdict, covariance_bounds, critical_probability,
    kalman_covariance, modified_riccati,
};
use gain_gen::solve::{LoopProblem, Method, solve};
use nalgebra::{DMatrix, DVector};

const CRITICAL: &str = include_str!("../../designs/critical.toml");

fn matrix<const R: usize, const C: usize>(rows: [[f64; C]; R]) -> DMatrix<f64> {
    DMatrix::from_fn(R, C, |i, j| rows[i][j])
}

fn link(probabilities: &[f64]) -> DelayDistribution {
    DelayDistribution::new(probabilities.to_vec()).expect("a distribution")
}

/// A plant of which only what the estimator knows matters.
fn plant(a: DMatrix<f64>, c: DMatrix<f64>, w: DMatrix<f64>, v: DMatrix<f64>) -> Plant {
    let states = a.nrows();
    Plant {
        sample_time: 1.0,
        b: DMatrix::identity(states, states),
        initial_mean: DVector::zeros(states),
        initial_covariance: DMatrix::zeros(states, states),
        continuous: None,
        a,
        c,
        process_noise: w,
        measurement_noise: v,
    }
}

/// A plant of which only how its modes show in measurements matters.
fn seen(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Plant {
    let unit = |size| DMatrix::identity(size, size);
    plant(a.clone(), c.clone(), unit(a.nrows()), unit(c.nrows()))
}

fn scalar_plant(a: f64) -> Plant {
    plant(matrix([[a]]), matrix([[1.0]]), matrix([[0.5]]), matrix([[2.0]]))
}

fn oscillator() -> Plant {
    plant(
        matrix([[1.05, 0.4], [-0.3, 0.98]]),
        matrix([[1.0, 0.2]]),
        matrix([[0.3, 0.1], [0.1, 0.2]]),
        matrix([[0.7]]),
    )
}

fn estimation(text: &str) -> Estimation {
    let design = Design::parse(text, "design.toml").expect("a design");
    Estimation::of(&design, &solve(&LoopProblem::of(&design), Method::InFlight))
}

fn agree(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance
}

fn predicted(plant: &Plant, covariance: &DMatrix<f64>) -> DMatrix<f64> {
    &plant.a * covariance * plant.a.transpose() + &plant.process_noise
}

fn corrected(plant: &Plant, prior: &DMatrix<f64>, q: f64) -> DMatrix<f64> {
    let seen = &plant.c * prior;
    let innovation = &seen * plant.c.transpose() + &plant.measurement_noise;
    prior - seen.transpose() * innovation.try_inverse().expect("positive definite") * &seen * q
}

#[test]
fn with_as_many_outputs_as_states_the_fastest_mode_alone_decides() {
    let turn = matrix([[0.9, -0.8], [0.8, 0.9]]);
    let skew = matrix([[1.0, 0.7], [0.0, 1.3]]);
    let turning = &skew * turn * skew.clone().try_inverse().unwrap();
    let units = DMatrix::from_diagonal(&DVector::from_vec(vec![1e-4, 1.0, 1e3]));
    let mixed = matrix([[1.5, 0.4, 0.0], [0.0, 1.2, 1.0], [0.0, 0.0, 0.6]]);
    let scaled = &units * mixed.clone() * units.clone().try_inverse().unwrap();
    for (a, largest) in
        [(matrix([[1.5, 0.0], [0.0, 1.2]]), 1.5_f64), (turning, 1.45_f64.sqrt()), (mixed, 1.5), (scaled, 1.5)]
    {
        let c = DMatrix::identity(a.nrows(), a.nrows());
        let expected = 1.0 - largest.powi(-2);
        let found = critical_probability(&seen(&a, &c));
        assert!(agree(found, expected, 1e-12), "{found} instead of {expected} for {a}");
    }
}

#[test]
fn coinciding_modes_that_outputs_see_apart_are_judged_by_their_modulus() {
    let (a, c) = (matrix([[1.1, 1.0], [0.0, 1.1]]), DMatrix::identity(2, 2));
    assert!(agree(critical_probability(&seen(&a, &c)), 1.0 - 1.1_f64.powi(-2), 1e-12));
}

#[test]
fn with_one_unstable_mode_that_mode_decides_whatever_is_measured() {
    for (a, c) in [
        (matrix([[1.5]]), matrix([[0.1]])),
        (matrix([[1.3, 0.5], [0.2, 0.4]]), matrix([[1.0, 0.0]])),
        (matrix([[1.3, 0.5], [0.2, 0.4]]), matrix([[0.0, 2.0], [1.0, 1.0]])),
    ] {
        let largest = a.clone().complex_eigenvalues().iter().map(|lambda| lambda.norm()).fold(0.0, f64::max);
        let expected = 1.0 - largest.powi(-2);
        assert!(agree(critical_probability(&seen(&a, &c)), expected, 1e-12));
    }
}

#[test]
fn with_a_single_output_the_product_of_the_unstable_modes_decides() {
    for (a, c, product) in [
        (matrix([[1.5, 0.0], [0.0, 1.2]]), matrix([[1.0, 1.0]]), 1.8_f64),
        (matrix([[0.9, -0.8], [0.8, 0.9]]), matrix([[1.0, 0.0]]), 1.45),
        (matrix([[1.2, 1.0, 0.0], [0.0, 1.1, 1.0], [0.0, 0.0, 0.5]]), matrix([[1.0, 0.0, 0.0]]), 1.32),
    ] {
        let expected = 1.0 - product.powi(-2);
        assert!(agree(critical_probability(&seen(&a, &c)), expected, 1e-12));
    }
}

/// `q` at which the modified Riccati iteration without noise, but for too little to matter, neither grows nor shrinks, by
/// bisection on its growth after many steps.
fn bisected(a: &DMatrix<f64>, c: &DMatrix<f64>) -> f64 {
    const NOISE: f64 = 1e-11;
    let (states, outputs) = (a.nrows(), c.nrows());
    let grows = |q: f64| {
        let mut x = DMatrix::identity(states, states);
        let mut growth = 0.0;
        for _ in 0..2000 {
            let noise = NOISE * x.trace();
            let seen = c * &x * a.transpose();
            let innovation = c * &x * c.transpose() + DMatrix::identity(outputs, outputs) * noise;
            let gain = innovation.try_inverse().expect("positive definite") * &seen;
            let next = a * &x * a.transpose() - seen.transpose() * gain * q
                + DMatrix::identity(states, states) * noise;
            growth = next.trace() / x.trace();
            // The mean of both ends of a step: where modes rotate, the iteration alone goes round for ever.
            x = &next / next.trace() + &x / x.trace();
            x = (&x + x.transpose()) * 0.25;
        }
        growth > 1.0
    };
    let (mut lower, mut upper) = (0.0, 1.0);
    while upper - lower > 1e-6 {
        let middle = 0.5 * (lower + upper);
        if grows(middle) { lower = middle } else { upper = middle }
    }
    upper
}

#[test]
fn between_the_formulas_the_iterations_growth_is_1_at_the_critical_probability() {
    let stable = matrix([
        [1.4, 0.3, 0.0, 0.7, 0.1],
        [0.0, 1.3, 0.2, 0.0, 0.2],
        [0.0, -0.4, 1.2, 0.0, 0.3],
        [0.0, 0.0, 0.0, 0.9, 0.5],
        [0.0, 0.0, 0.0, -0.5, 0.6],
    ]);
    let sight = matrix([[1.0, 0.0, 0.5, 0.0, 1.0], [0.0, 0.3, 1.0, 2.0, 0.0]]);
    // The fastest mode alone decides, though not all modes are seen apart.
    let one_fast = DMatrix::from_diagonal(&DVector::from_vec(vec![1.5, 1.1, -1.05, 1.02]));
    let mixed = matrix([[1.0, 0.2, 0.3, 0.7], [0.4, 1.0, -0.6, 0.5], [0.1, -0.3, 1.0, 0.2]]);
    assert!(agree(critical_probability(&seen(&one_fast, &mixed)), 1.0 - 1.5_f64.powi(-2), 1e-6));
    let turns = matrix([[0.0, 1.2, 0.1], [-1.2, 0.0, 0.0], [0.0, 0.0, 1.3]]);
    for (a, c) in [
        (
            matrix([[1.4, 0.3, 0.0], [0.0, 1.3, 0.2], [0.0, 0.0, 1.2]]),
            matrix([[1.0, 0.0, 0.5], [0.0, 0.3, 1.0]]),
        ),
        (stable, sight),
        (turns, matrix([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])),
        (
            DMatrix::from_diagonal(&DVector::from_vec(vec![1.3, -1.3, 1.1])),
            matrix([[1.0, 1.0, 1.0], [0.0, 0.0, 1.0]]),
        ),
    ] {
        let (found, expected) = (critical_probability(&seen(&a, &c)), bisected(&a, &c));
        assert!(agree(found, expected, 3e-6), "{found} instead of {expected} for {a}");
    }
}

#[test]
fn between_the_formulas_the_equation_is_solvable_just_above_the_critical_probability_only() {
    let a = matrix([[1.4, 0.3, 0.0], [0.0, 1.3, 0.2], [0.0, 0.0, 1.2]]);
    let c = matrix([[1.0, 0.0, 0.5], [0.0, 0.3, 1.0]]);
    let critical = critical_probability(&seen(&a, &c));
    assert!(
        1.0 - 1.4_f64.powi(-2) < critical && critical < 1.0 - (1.4_f64 * 1.3 * 1.2).powi(-2),
        "{critical}"
    );
    let plant = plant(a, c, DMatrix::identity(3, 3), DMatrix::identity(2, 2));
    assert!(modified_riccati(&plant, critical + 1e-4).is_some());
    assert!(modified_riccati(&plant, critical - 1e-4).is_none());
}

#[test]
fn a_plant_without_growing_modes_needs_no_more_than_some_measurements() {
    for a in [matrix([[0.5, 3.0], [0.0, 0.9]]), matrix([[1.0, 1.0], [0.0, 1.0]])] {
        assert_eq!(critical_probability(&seen(&a, &DMatrix::identity(2, 2))), 0.0);
        assert_eq!(critical_probability(&seen(&a, &matrix([[1.0, 0.0]]))), 0.0);
    }
}

#[test]
fn solutions_solve_their_riccati_equation() {
    let plant = oscillator();
    for q in [1.0, 0.9, 0.5] {
        let found = modified_riccati(&plant, q).expect("above the critical probability");
        let residual = predicted(&plant, &corrected(&plant, &found, q)) - &found;
        assert!(residual.amax() < 1e-11 * found.amax(), "{q}: {residual}");
    }
    let posterior = kalman_covariance(&plant);
    let again = corrected(&plant, &predicted(&plant, &posterior), 1.0);
    assert!((again - &posterior).amax() < 1e-12);
}

#[test]
fn measurements_that_come_for_sure_at_a_fixed_delay_leave_nothing_open() {
    let plant = oscillator();
    let mut expected = kalman_covariance(&plant);
    for delay in 0..4 {
        let mut delays = vec![0.0; delay + 1];
        delays[delay] = 1.0;
        let CovarianceBounds { lower, upper } = covariance_bounds(&plant, &link(&delays), 7);
        for bound in [lower.expect("bounded"), upper.expect("bounded")] {
            assert!((bound - &expected).amax() < 1e-11 * expected.amax(), "delay {delay}");
        }
        expected = predicted(&plant, &expected);
    }
}

/// `E[e e']` by going through all patterns of which of the last `depth` measurements have come, each pattern started
/// from `start` before.
fn enumerated(plant: &Plant, arrival: &[f64], start: &DMatrix<f64>) -> DMatrix<f64> {
    let Some((oldest, newer)) = arrival.split_first() else { return start.clone() };
    let prior = predicted(plant, start);
    let mut expected = DMatrix::zeros(start.nrows(), start.nrows());
    for (share, covariance) in [(*oldest, corrected(plant, &prior, 1.0)), (1.0 - oldest, prior.clone())] {
        if share > 0.0 {
            expected += enumerated(plant, newer, &covariance) * share;
        }
    }
    expected
}

#[test]
fn bounds_enclose_what_enumeration_of_all_arrivals_gives() {
    for (plant, delays, buffer) in [
        (scalar_plant(1.1), &[0.5, 0.2, 0.1][..], 2),
        (scalar_plant(0.8), &[0.0, 0.3, 0.0, 0.4], 2),
        (oscillator(), &[0.6, 0.2, 0.15], 4),
    ] {
        let link = link(delays);
        let CovarianceBounds { lower, upper } = covariance_bounds(&plant, &link, buffer);
        let (lower, upper) = (lower.expect("bounded").trace(), upper.expect("bounded").trace());
        // Oldest first; what came before the last fourteen measurements hardly matters, and is bounded too.
        let arrival: Vec<f64> = (0..14).rev().map(|age: usize| link.arrival(age.min(buffer))).collect();
        let best = enumerated(&plant, &arrival, &kalman_covariance(&plant)).trace();
        let start = modified_riccati(&plant, link.arrival(buffer)).expect("above the critical probability");
        let worst = enumerated(&plant, &arrival, &start).trace();
        assert!(lower <= worst && best <= upper, "{lower} to {upper} against {best} to {worst}");
        assert!(worst - best < 0.05 * best, "{best} to {worst}: enumerate more");
        assert!(upper - lower < 0.35 * lower, "{lower} to {upper}: too wide to be of use");
    }
}

/// Covariance `x`, with its states in other units, relative to the standard deviations of `plain`.
fn off(x: &DMatrix<f64>, plain: &DMatrix<f64>, units: &[f64]) -> f64 {
    let size = |i: usize| plain[(i, i)].sqrt() * units[i];
    let difference = |i: usize, j: usize| x[(i, j)] - plain[(i, j)] * units[i] * units[j];
    let places = (0..x.nrows()).flat_map(|i| (0..x.nrows()).map(move |j| (i, j)));
    places.map(|(i, j)| difference(i, j).abs() / (size(i) * size(j))).fold(0.0, f64::max)
}

#[test]
fn units_change_covariances_by_their_factors_and_nothing_else() {
    let third = plant(
        matrix([[1.3, 0.3, 0.0], [0.0, 1.1, 0.2], [0.1, -0.4, 0.8]]),
        matrix([[1.0, 0.0, 0.5], [0.0, 0.3, 1.0]]),
        matrix([[0.3, 0.1, 0.0], [0.1, 0.2, 0.0], [0.0, 0.0, 0.4]]),
        matrix([[0.7, 0.2], [0.2, 0.4]]),
    );
    let delays = link(&[0.6, 0.2, 0.1]);
    for (plain, powers) in [(oscillator(), [9, -9, 0]), (third.clone(), [-9, 3, 9]), (third, [6, 9, -8])] {
        let unit = |power: i32| 10.0_f64.powi(power);
        let states: Vec<f64> = powers[..plain.a.nrows()].iter().map(|&power| unit(power)).collect();
        let outputs: Vec<f64> = powers[..plain.c.nrows()].iter().map(|&power| unit(-power)).collect();
        let scaled = plant(
            plain.a.map_with_location(|i, j, entry| entry * states[i] / states[j]),
            plain.c.map_with_location(|i, j, entry| entry * outputs[i] / states[j]),
            plain.process_noise.map_with_location(|i, j, entry| entry * states[i] * states[j]),
            plain.measurement_noise.map_with_location(|i, j, entry| entry * outputs[i] * outputs[j]),
        );
        let (expected, found) =
            (covariance_bounds(&plain, &delays, 3), covariance_bounds(&scaled, &delays, 3));
        for (found, expected) in [(found.lower, expected.lower), (found.upper, expected.upper)] {
            let off = off(&found.expect("bounded"), &expected.expect("bounded"), &states);
            assert!(off < 1e-9, "{powers:?}: {off}");
        }
        assert!(agree(critical_probability(&plain), critical_probability(&scaled), 1e-9), "{powers:?}");
    }
}

#[test]
fn no_measurements_leave_the_open_loops_covariance() {
    let stable = scalar_plant(0.5);
    let found = covariance_bounds(&stable, &link(&[0.0, 1.0]), 0);
    let expected = 0.5 / (1.0 - 0.25);
    for bound in [found.lower, found.upper] {
        assert!(agree(bound.expect("bounded")[0], expected, 1e-14));
    }
    for a in [1.0, 1.2] {
        let found = covariance_bounds(&scalar_plant(a), &link(&[0.0, 1.0]), 0);
        assert_eq!((found.lower, found.upper), (None, None));
    }
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
