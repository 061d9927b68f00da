//! The filter refuses what it cannot use, and survives what would break its numbers.

use nalgebra::{SMatrix, SVector};
use slqg::estimator::{Kalman, Model, RejectedMeasurement};
use slqg::{Tick, nalgebra};

type Filter = Kalman<f32, 2, 1, 1, 6>;

/// Position and speed, position measured; `growth` is the factor of the unstable one of the two per cycle.
fn model(growth: f32, process_noise: f32, measurement_noise: f32) -> Model<f32, 2, 1, 1> {
    Model {
        a: SMatrix::from([[growth, 0.0], [0.1, 1.0]]),
        b: SMatrix::from([[0.005, 0.1]]),
        c: SMatrix::from([[1.0], [0.0]]),
        process_noise: SMatrix::from_diagonal_element(process_noise),
        measurement_noise: SMatrix::from([[measurement_noise]]),
        initial_mean: SVector::zeros(),
        initial_covariance: SMatrix::identity(),
    }
}

fn measured(position: f32) -> SVector<f32, 1> {
    SVector::from([position])
}

#[test]
fn measurements_of_no_use_are_rejected_by_name() {
    let model = model(1.0, 0.1, 0.1);
    let start = Tick(u32::MAX);
    let mut filter = Filter::new(&model, 3, start);
    let before = start - 1;
    assert_eq!(filter.measure(before, measured(1.0)), Err(RejectedMeasurement::TooOld), "before the first");
    for _ in 0..4 {
        filter.advance(&model, SVector::zeros());
    }
    let now = filter.tick();
    assert_eq!(now, start + 4);
    assert_eq!(filter.measure(now + 1, measured(1.0)), Err(RejectedMeasurement::Future));
    assert_eq!(filter.measure(now - 4, measured(1.0)), Err(RejectedMeasurement::TooOld));
    assert_eq!(filter.measure(now - i32::MAX as u32, measured(1.0)), Err(RejectedMeasurement::TooOld));
    assert_eq!(filter.measure(now - 3, measured(1.0)), Ok(()));
    assert_eq!(filter.measure(now - 3, measured(2.0)), Err(RejectedMeasurement::Duplicate));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(filter.measure(now, measured(bad)), Err(RejectedMeasurement::NotFinite));
    }
    assert_eq!(filter.measure(now, measured(1.0)), Ok(()), "a rejected one does not take its place");
}

#[test]
fn rejected_measurements_change_nothing() {
    let model = model(1.0, 0.1, 0.1);
    let mut filter = Filter::new(&model, 3, Tick(0));
    for at in 0..5 {
        filter.measure(Tick(at), measured(1.0)).expect("in time");
        filter.advance(&model, SVector::zeros());
    }
    filter.filter(&model);
    let before = format!("{filter:?}");
    for (tick, value) in [(4, 9.0), (0, 9.0), (6, 9.0), (5, f32::NAN)] {
        filter.measure(Tick(tick), measured(value)).expect_err("of no use");
    }
    assert_eq!(format!("{filter:?}"), before);
}

#[test]
fn inputs_of_forgotten_and_coming_cycles_are_refused() {
    let model = model(1.0, 0.1, 0.1);
    let mut filter = Filter::new(&model, 3, Tick(0));
    for _ in 0..5 {
        filter.advance(&model, SVector::from([0.5]));
    }
    let input = SVector::from([1.0]);
    assert!(!filter.set_input(Tick(1), input) && filter.input(Tick(1)).is_none(), "forgotten");
    assert!(!filter.set_input(Tick(6), input) && filter.input(Tick(6)).is_none(), "has not begun");
    assert!(filter.set_input(Tick(2), input));
    assert_eq!(filter.input(Tick(2)), Some(&input));
    assert_eq!(filter.input(Tick(3)), Some(&SVector::from([0.5])));
}

#[test]
fn a_measurement_buffer_beyond_the_memory_is_cut_to_it() {
    let model = model(1.0, 0.1, 0.1);
    let mut filter = Filter::new(&model, 100, Tick(0));
    for _ in 0..10 {
        filter.advance(&model, SVector::zeros());
    }
    assert_eq!(filter.measure(Tick(5), measured(1.0)), Ok(()));
    assert_eq!(filter.measure(Tick(4), measured(1.0)), Err(RejectedMeasurement::TooOld));
}

#[test]
fn the_covariance_stays_symmetric_and_positive_semidefinite_in_single_precision() {
    for (growth, process_noise, measurement_noise) in
        [(1.0, 1e-3, 1e-12), (1.2, 1e-6, 1e-12), (1.0, 1e4, 1e-12), (0.9, 0.0, 1e-12), (1.0, 0.0, 1e-9)]
    {
        let model = model(growth, process_noise, measurement_noise);
        let mut filter = Filter::new(&model, 3, Tick(0));
        for at in 0..100_000 {
            // Lost now and then, so that the covariance keeps moving.
            if at % 7 < 4 {
                filter.measure(Tick(at), measured(0.0)).expect("in time");
            }
            filter.filter(&model);
            let covariance = filter.posterior_covariance();
            assert_eq!(covariance[(0, 1)], covariance[(1, 0)]);
            let eigenvalues = covariance.map(f64::from).symmetric_eigenvalues();
            let slack = 4.0 * f64::from(f32::EPSILON) * eigenvalues.max();
            assert!(eigenvalues.min() >= -slack, "cycle {at} of {growth}: {covariance}");
            filter.advance(&model, SVector::zeros());
        }
    }
}

#[test]
fn a_million_cycles_without_measurement_leave_no_bad_number() {
    let model = model(1.1, 0.1, 0.1);
    let mut filter = Filter::new(&model, 3, Tick(0));
    for _ in 0..1_000_000 {
        filter.advance(&model, SVector::from([1.0]));
        let values = filter.posterior_mean().iter().chain(filter.posterior_covariance().iter());
        assert!(values.into_iter().all(|value| value.is_finite()));
    }
}

#[test]
fn the_filter_recovers_after_a_silence_of_any_length() {
    let model = model(1.1, 0.01, 0.01);
    let mut silent = Filter::new(&model, 3, Tick(0));
    for silence in 0..1500 {
        let mut filter = silent.clone();
        let mut state = SVector::from([3.0, -2.0]);
        for _ in 0..60 {
            filter.measure(filter.tick(), measured(state[0])).expect("in time");
            filter.filter(&model);
            filter.advance(&model, SVector::from([-state[0]]));
            state = model.a * state - model.b * state[0];
        }
        filter.measure(filter.tick(), measured(state[0])).expect("in time");
        filter.filter(&model);
        let error = (filter.posterior_mean() - state).norm();
        assert!(error < 0.02 * (1.0 + state.norm()), "{error} after {silence} cycles of silence");
        silent.advance(&model, SVector::from([1.0]));
    }
}

#[test]
fn an_absurd_but_finite_measurement_does_not_break_the_filter() {
    let model = model(1.0, 0.1, 0.1);
    let mut filter = Filter::new(&model, 3, Tick(0));
    for (at, value) in [f32::MAX, -f32::MAX, f32::MAX, 0.0].into_iter().enumerate() {
        filter.measure(Tick(at as u32), measured(value)).expect("finite");
        filter.filter(&model);
        let values = filter.posterior_mean().iter().chain(filter.posterior_covariance().iter());
        assert!(values.into_iter().all(|value| value.is_finite()), "after measurement {at}");
        filter.advance(&model, SVector::zeros());
    }
}
