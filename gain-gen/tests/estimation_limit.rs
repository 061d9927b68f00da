//! The least arrival probability for a bounded estimation error: against closed forms, and against the filter's own covariance
//! over random arrivals.

use gain_gen::design::Plant;
use gain_gen::estimation::{ArrivalLimit, arrival_limit, critical_probability};
use nalgebra::{Complex, DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

fn matrix<const R: usize, const C: usize>(rows: [[f64; C]; R]) -> DMatrix<f64> {
    DMatrix::from_fn(R, C, |i, j| rows[i][j])
}

/// A plant with noise of unit variances, of which only what the estimator knows matters.
fn plant(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Plant {
    let (states, outputs) = (a.nrows(), c.nrows());
    Plant {
        sample_time: 1.0,
        a: a.clone(),
        b: DMatrix::identity(states, states),
        c: c.clone(),
        process_noise: DMatrix::identity(states, states),
        measurement_noise: DMatrix::identity(outputs, outputs),
        initial_mean: DVector::zeros(states),
        initial_covariance: DMatrix::zeros(states, states),
        continuous: None,
    }
}

fn limit(a: &DMatrix<f64>, c: &DMatrix<f64>) -> ArrivalLimit {
    arrival_limit(&plant(a, c)).expect("a mode that lasts")
}

/// Rotation by `angle` in each step, growing by `modulus`.
fn turning(modulus: f64, angle: f64) -> DMatrix<f64> {
    matrix([[angle.cos(), angle.sin()], [-angle.sin(), angle.cos()]]) * modulus
}

fn blocks(parts: &[DMatrix<f64>]) -> DMatrix<f64> {
    let size = parts.iter().map(DMatrix::nrows).sum();
    let mut whole = DMatrix::zeros(size, size);
    let mut at = 0;
    for part in parts {
        whole.view_mut((at, at), part.shape()).copy_from(part);
        at += part.nrows();
    }
    whole
}

/// Deterministic coordinates that mix all states.
fn mixing(size: usize) -> DMatrix<f64> {
    DMatrix::from_fn(size, size, |i, j| ((5 * i + 11 * j) as f64).cos() + if i == j { 3.0 } else { 0.0 })
}

fn is_exactly(found: &ArrivalLimit, expected: f64) -> bool {
    found.lower <= expected && expected <= found.upper && found.upper - found.lower < 1e-7
}

/// What is to be right about a plant.
struct Case {
    name: &'static str,
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    /// Modulus, period and losses of the cycle that decides.
    modulus: f64,
    period: usize,
    losses: usize,
    /// Powers of `ln M` in the tail `P(tr S > M) = (ln M)^powers M^-alpha`: arrivals among the losses that do not help, since a
    /// single look at two directions tells of one only.
    powers: f64,
}

fn cases() -> Vec<Case> {
    use std::f64::consts::PI;
    let defective_turn =
        matrix([[0.0, 1.2, 1.0, 0.0], [-1.2, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.2], [0.0, 0.0, -1.2, 0.0]]);
    let two = |angle| blocks(&[turning(1.2, angle), turning(1.2, angle)]);
    let cases = [
        ("one mode", matrix([[1.5]]), matrix([[1.0]]), 1.5, 1, 1, 0.0),
        ("two moduli", matrix([[1.3, 0.0], [0.0, 1.2]]), matrix([[1.0, 1.0]]), 1.3, 1, 1, 0.0),
        ("opposite signs", matrix([[1.3, 0.0], [0.0, -1.3]]), matrix([[1.0, 1.0]]), 1.3, 2, 1, 0.0),
        (
            "opposite signs, all seen",
            matrix([[1.3, 0.0], [0.0, -1.3]]),
            DMatrix::identity(2, 2),
            1.3,
            2,
            2,
            0.0,
        ),
        ("quarter turn", matrix([[0.0, 1.2], [-1.2, 0.0]]), matrix([[1.0, 0.0]]), 1.2, 2, 1, 0.0),
        ("quarter turn, computed", turning(1.2, PI / 2.0), matrix([[0.3, -2.0]]), 1.2, 2, 1, 0.0),
        ("third of a turn", turning(1.2, 2.0 * PI / 3.0), matrix([[1.0, 0.0]]), 1.2, 3, 2, 0.0),
        ("five degrees", turning(1.2, PI / 36.0), matrix([[1.0, 0.0]]), 1.2, 36, 35, 0.0),
        ("one radian", turning(1.2, 1.0), matrix([[1.0, 0.0]]), 1.2, 1, 1, 1.0),
        ("quarter turn, defective", defective_turn, matrix([[1.0, 0.0, 0.0, 0.0]]), 1.2, 2, 1, 1.4),
        (
            "two quarter turns",
            two(PI / 2.0),
            matrix([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
            1.2,
            2,
            1,
            0.0,
        ),
        ("two radians", two(1.0), matrix([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]), 1.2, 1, 1, 1.0),
        (
            "cube roots",
            matrix([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]) * 1.1,
            matrix([[1.0, 0.0, 0.0]]),
            1.1,
            3,
            1,
            0.0,
        ),
        (
            "cube roots, two of them seen",
            matrix([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]) * 1.1,
            matrix([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
            1.1,
            3,
            2,
            0.0,
        ),
        (
            "fourth roots, seen in turn and twice",
            blocks(&[turning(1.2, PI / 2.0), matrix([[1.2, 0.0], [0.0, -1.2]])]),
            matrix([[1.0, 0.0, 1.0, 1.0]]),
            1.2,
            4,
            1,
            0.0,
        ),
        (
            "a faster mode on its own",
            blocks(&[turning(1.2, PI / 2.0), matrix([[1.5]])]),
            matrix([[1.0, 0.0, 1.0]]),
            1.5,
            1,
            1,
            0.0,
        ),
        (
            "a faster mode that losses hide less",
            blocks(&[turning(1.3, PI / 2.0), matrix([[1.5]])]),
            matrix([[1.0, 0.0, 1.0]]),
            1.3,
            2,
            1,
            0.0,
        ),
    ];
    let case =
        |(name, a, c, modulus, period, losses, powers)| Case { name, a, c, modulus, period, losses, powers };
    cases.into_iter().map(case).collect()
}

#[test]
fn limit_is_that_of_the_cycle_that_fewest_losses_hide() {
    for Case { name, a, c, modulus, period, losses, .. } in cases() {
        let units = mixing(a.nrows());
        let inverse = units.clone().try_inverse().expect("regular");
        for (a, c) in [(a.clone(), c.clone()), (&units * a * &inverse, c * &inverse)] {
            let found = limit(&a, &c);
            let expected = 1.0 - f64::powf(modulus, -2.0 * period as f64 / losses as f64);
            assert!(is_exactly(&found, expected), "{name}: {found:?} instead of {expected}");
            let cycle = found.cycle.as_ref().expect("a growing mode");
            // Where all losses are needed, what comes round is not told from what does not.
            assert_eq!(cycle.period * losses, period * cycle.losses, "{name}: {cycle:?}");
            assert!(critical_probability(&plant(&a, &c)) > found.lower - 1e-9, "{name}");
        }
    }
}

#[test]
fn the_quarter_turn_is_lost_where_every_other_measurement_may_be() {
    let found = limit(&turning(1.2, std::f64::consts::FRAC_PI_2), &matrix([[1.0, 0.0]]));
    let cycle = found.cycle.expect("a growing mode");
    assert_eq!((cycle.period, cycle.losses, cycle.eigenvalues.len()), (2, 1, 2));
    assert!(
        (cycle.eigenvalues[0] - Complex::new(0.0, 1.2))
            .norm()
            .min((cycle.eigenvalues[0] - Complex::new(0.0, -1.2)).norm())
            < 1e-12
    );
}

#[test]
fn modes_that_decay_or_stay_need_no_share_of_the_measurements() {
    assert_eq!(arrival_limit(&plant(&matrix([[0.5, 3.0], [0.0, 0.9]]), &matrix([[1.0, 0.0]]))), None);
    for a in [matrix([[1.0, 1.0], [0.0, 1.0]]), turning(1.0, std::f64::consts::FRAC_PI_2)] {
        let found = limit(&a, &matrix([[1.0, 0.0]]));
        assert!(found.lower == 0.0 && found.upper < 1e-9 && found.cycle.is_none(), "{found:?}");
    }
}

#[test]
fn a_coincidence_in_doubt_leaves_an_interval_between_both_answers() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let (alone, together) = (1.0 - 1.2_f64.powi(-2), 1.0 - 1.2_f64.powi(-4));
    for (off, expected) in [(0.0, (together, together)), (1e-13, (alone, together)), (1e-9, (alone, alone))] {
        let found = limit(&turning(1.2, quarter + off), &matrix([[1.0, 0.0]]));
        assert!((found.lower - expected.0).abs() < 1e-9, "{off}: {found:?}");
        assert!((found.upper - expected.1).abs() < 1e-9, "{off}: {found:?}");
    }
    for (off, expected) in [(0.0, (together, together)), (1e-13, (alone, together)), (1e-9, (alone, alone))] {
        let found = limit(&matrix([[1.2, 0.0], [0.0, -1.2 - off]]), &matrix([[1.0, 1.0]]));
        assert!((found.lower - expected.0).abs() < 1e-8, "{off}: {found:?}");
        assert!((found.upper - expected.1).abs() < 1e-8, "{off}: {found:?}");
    }
}

#[test]
fn limit_does_not_depend_on_units() {
    for Case { name, a, c, .. } in cases() {
        let (plain, size) = (limit(&a, &c), a.nrows());
        for seed in 0..8 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut unit = || f64::powi(10.0, (random.next_u32() % 19) as i32 - 9);
            let states: Vec<f64> = (0..size).map(|_| unit()).collect();
            let outputs: Vec<f64> = (0..c.nrows()).map(|_| unit()).collect();
            let scaled_a = DMatrix::from_fn(size, size, |i, j| a[(i, j)] * states[i] / states[j]);
            let scaled_c = DMatrix::from_fn(c.nrows(), size, |i, j| c[(i, j)] * outputs[i] / states[j]);
            let mut scaled = plant(&scaled_a, &scaled_c);
            scaled.process_noise =
                DMatrix::from_fn(size, size, |i, j| if i == j { states[i].powi(2) } else { 0.0 });
            for (output, unit) in outputs.iter().enumerate() {
                scaled.measurement_noise[(output, output)] = unit.powi(2);
            }
            let scaled = arrival_limit(&scaled).expect("a mode that lasts");
            assert!((scaled.lower - plain.lower).abs() < 1e-9, "{name}, {seed}: {scaled:?}, {plain:?}");
            assert!((scaled.upper - plain.upper).abs() < 1e-9, "{name}, {seed}: {scaled:?}, {plain:?}");
            let losses =
                |limit: &ArrivalLimit| limit.cycle.as_ref().map(|cycle| (cycle.period, cycle.losses));
            assert_eq!(losses(&scaled), losses(&plain), "{name}, {seed}");
        }
    }
}

/// The covariance of the Kalman filter as `F F'`, which keeps its digits where it grows large in one direction only.
struct Covariance<'p> {
    root: DMatrix<f64>,
    a: &'p DMatrix<f64>,
    c: &'p DMatrix<f64>,
}

impl Covariance<'_> {
    /// A step with process noise of unit covariance.
    fn predict(&mut self) {
        let size = self.root.nrows();
        let mut wide = DMatrix::zeros(size, 2 * size);
        wide.columns_mut(0, size).copy_from(&(self.a * &self.root));
        wide.columns_mut(size, size).fill_with_identity();
        // Rows made orthogonal one after the other: wide = L (orthonormal rows).
        for row in 0..size {
            let length = wide.row(row).norm();
            let unit = wide.row(row) / length;
            wide.row_mut(row).copy_from(&unit);
            self.root.row_mut(row).columns_mut(row + 1, size - row - 1).fill(0.0);
            self.root[(row, row)] = length;
            for later in row + 1..size {
                let part = wide.row(later).dot(&unit);
                self.root[(later, row)] = part;
                let left = wide.row(later) - &unit * part;
                wide.row_mut(later).copy_from(&left);
            }
        }
    }

    /// All outputs, each with noise of variance 1 (Potter's form).
    fn correct(&mut self) {
        for output in self.c.row_iter() {
            let seen = self.root.tr_mul(&output.transpose());
            let weight = 1.0 / (seen.norm_squared() + 1.0);
            let gain = &self.root * &seen * (weight / (1.0 + weight.sqrt()));
            self.root -= gain * seen.transpose();
        }
    }
}

/// Shares of the steps in which the trace is above `low` and above `high`, over random arrivals: the negative slope between
/// both on logarithmic scales, and its standard error.
fn tail_slope(a: &DMatrix<f64>, c: &DMatrix<f64>, arrival: f64, low: f64, high: f64) -> (f64, f64) {
    const BATCHES: usize = 40;
    const STEPS: usize = 10_000;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let size = a.nrows();
    let mut covariance = Covariance { root: DMatrix::identity(size, size), a, c };
    let mut count = || {
        let (mut above_low, mut above_high) = (0.0, 0.0);
        for _ in 0..STEPS {
            covariance.predict();
            if f64::from(random.next_u32()) < arrival * f64::from(u32::MAX) {
                covariance.correct();
            }
            let trace = covariance.root.norm_squared();
            above_low += if trace > low { 1.0 } else { 0.0 };
            above_high += if trace > high { 1.0 } else { 0.0 };
        }
        (above_low, above_high)
    };
    let counts: Vec<(f64, f64)> = (0..BATCHES).map(|_| count()).collect();
    let all_low: f64 = counts.iter().map(|count| count.0).sum();
    let ratio = counts.iter().map(|count| count.1).sum::<f64>() / all_low;
    let spread: f64 = counts.iter().map(|(low, high)| (high - ratio * low).powi(2)).sum();
    let decades = (high / low).ln();
    (-ratio.ln() / decades, spread.sqrt() / all_low / ratio / decades)
}

#[test]
fn filters_covariance_over_random_arrivals_has_the_tail_that_the_limit_says() {
    // `P(tr S > M) ~ M^-alpha` with alpha = ln(1 - q) / ln(1 - limit): the mean is finite above the limit only.
    let alpha = 0.2;
    // Two looks in a row at what turns by little tell little: the tail shows its exponent only far beyond what can be counted.
    for Case { name, a, c, modulus, period, powers, .. } in
        cases().into_iter().filter(|case| case.period <= 4)
    {
        let arrival = 1.0 - (1.0 - limit(&a, &c).upper).powf(alpha);
        // From 1e8 by a whole number of periods, in which the tail comes down in steps.
        let step = modulus.powi(2 * period as i32);
        let (low, high) = (1e8, 1e8 * step.powf((1e8_f64.ln() / step.ln()).round()));
        let (measured, error) = tail_slope(&a, &c, arrival, low, high);
        let expected = alpha - powers * (high.ln() / low.ln()).ln() / (high / low).ln();
        assert!(error < 0.015, "{name}: {error}");
        let found = format!("{measured} +- {error} instead of {expected}");
        assert!((measured - expected).abs() < 4.0 * error, "{name}: {found}");
    }
}

#[test]
fn on_both_sides_of_its_limit_the_mean_covariance_of_a_quarter_turn_is_infinite_and_finite() {
    let (a, c) = (turning(1.2, std::f64::consts::FRAC_PI_2), matrix([[1.0, 0.0]]));
    let step = 1.2_f64.powi(4);
    for (arrival, is_finite) in [(0.4, false), (0.65, true)] {
        let (slope, error) = tail_slope(&a, &c, arrival, 20.0, 20.0 * step.powi(4));
        assert_eq!(slope - 4.0 * error > 1.0, is_finite, "{arrival}: {slope} +- {error}");
        assert_eq!(slope + 4.0 * error > 1.0, is_finite, "{arrival}: {slope} +- {error}");
    }
}
