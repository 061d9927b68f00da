//! The filter refuses what it cannot use, and survives what would break its numbers.

mod driven;
mod lent;

use driven::{Driven, Link, settings};
use nalgebra::{SMatrix, SVector};
use slqg::estimator::{Merging, Model, RejectedMeasurement};
use slqg::{Age, DefaultInput, Tick, nalgebra};

/// Sequences of one input.
type Filter = Driven<f32, 2, 1, 1, 1, 6>;

fn filter(model: &Model<f32, 2, 1, 1>, late: usize, start: Tick) -> Filter {
    let link = Link::new(model.clone(), &[0.7], settings(DefaultInput::Zero, None));
    link.driven(Merging::Single, late, start)
}

/// Ends a cycle in which `input` was sent, and acknowledges that it was applied.
fn apply(driven: &mut Filter, input: f32) {
    driven.advance(Some([SVector::from([input])]));
    assert!(driven.filter.acknowledge(driven.filter.tick() - 1, Age::Steps(0)));
}

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
    let mut driven = filter(&model, 3, start);
    let before = start - 1;
    assert_eq!(
        driven.filter.measure(before, measured(1.0)),
        Err(RejectedMeasurement::TooOld),
        "before the first"
    );
    for _ in 0..4 {
        driven.advance(None);
    }
    let now = driven.filter.tick();
    assert_eq!(now, start + 4);
    assert_eq!(driven.filter.measure(now + 1, measured(1.0)), Err(RejectedMeasurement::Future));
    assert_eq!(driven.filter.measure(now - 4, measured(1.0)), Err(RejectedMeasurement::TooOld));
    assert_eq!(driven.filter.measure(now - i32::MAX as u32, measured(1.0)), Err(RejectedMeasurement::TooOld));
    assert_eq!(driven.filter.measure(now - 3, measured(1.0)), Ok(()));
    assert_eq!(driven.filter.measure(now - 3, measured(2.0)), Err(RejectedMeasurement::Duplicate));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(driven.filter.measure(now, measured(bad)), Err(RejectedMeasurement::NotFinite));
    }
    assert_eq!(driven.filter.measure(now, measured(1.0)), Ok(()), "a rejected one does not take its place");
}

#[test]
fn rejected_measurements_change_nothing() {
    let model = model(1.0, 0.1, 0.1);
    let mut driven = filter(&model, 3, Tick(0));
    for at in 0..5 {
        driven.filter.measure(Tick(at), measured(1.0)).expect("in time");
        driven.advance(None);
    }
    driven.filter();
    let before = format!("{driven:?}");
    for (tick, value) in [(4, 9.0), (0, 9.0), (6, 9.0), (5, f32::NAN)] {
        driven.filter.measure(Tick(tick), measured(value)).expect_err("of no use");
    }
    assert_eq!(format!("{driven:?}"), before);
}

#[test]
fn acknowledgements_of_forgotten_and_coming_cycles_are_refused() {
    let link = Link::new(model(1.0, 0.1, 0.1), &[0.7], settings(DefaultInput::Zero, None));
    let mut driven: Driven<f32, 2, 1, 1, 1, 4> = link.driven(Merging::Single, 3, Tick(0));
    for _ in 0..5 {
        driven.advance(Some([SVector::from([0.5])]));
    }
    for (tick, what) in [(1, "forgotten"), (5, "not over"), (6, "has not begun"), (u32::MAX, "never was")] {
        assert!(!driven.filter.acknowledge(Tick(tick), Age::Empty), "{what}");
        assert_eq!(driven.filter.is_acknowledged(Tick(tick)), None, "{what}");
    }
    assert_eq!(driven.filter.is_acknowledged(Tick(2)), Some(false));
    assert!(driven.filter.acknowledge(Tick(2), Age::Steps(0)));
    assert_eq!(driven.filter.is_acknowledged(Tick(2)), Some(true));
    driven.filter();
    assert_eq!(driven.expected_input(Tick(2)), Some(SVector::from([0.5])));
    assert_eq!(driven.expected_input(Tick(3)), Some(SVector::from([0.7 * 0.5])));
}

#[test]
fn a_measurement_buffer_beyond_the_memory_is_cut_to_it() {
    let model = model(1.0, 0.1, 0.1);
    let mut driven = filter(&model, 100, Tick(0));
    for _ in 0..10 {
        driven.advance(None);
    }
    assert_eq!(driven.filter.measure(Tick(5), measured(1.0)), Ok(()));
    assert_eq!(driven.filter.measure(Tick(4), measured(1.0)), Err(RejectedMeasurement::TooOld));
}

#[test]
fn the_covariance_stays_symmetric_and_positive_semidefinite_in_single_precision() {
    for (growth, process_noise, measurement_noise) in
        [(1.0, 1e-3, 1e-12), (1.2, 1e-6, 1e-12), (1.0, 1e4, 1e-12), (0.9, 0.0, 1e-12), (1.0, 0.0, 1e-9)]
    {
        let model = model(growth, process_noise, measurement_noise);
        let mut driven = filter(&model, 3, Tick(0));
        for at in 0..100_000 {
            // Lost now and then, so that the covariance keeps moving.
            if at % 7 < 4 {
                driven.filter.measure(Tick(at), measured(0.0)).expect("in time");
            }
            driven.filter();
            let covariance = driven.filter.posterior_covariance();
            assert_eq!(covariance[(0, 1)], covariance[(1, 0)]);
            let eigenvalues = covariance.map(f64::from).symmetric_eigenvalues();
            let slack = 4.0 * f64::from(f32::EPSILON) * eigenvalues.max();
            assert!(eigenvalues.min() >= -slack, "cycle {at} of {growth}: {covariance}");
            driven.advance(None);
        }
    }
}

#[test]
fn a_million_cycles_without_measurement_leave_no_bad_number() {
    let model = model(1.1, 0.1, 0.1);
    let mut driven = filter(&model, 3, Tick(0));
    for _ in 0..1_000_000 {
        apply(&mut driven, 1.0);
        assert!(driven.numbers().iter().all(|value| value.is_finite()));
    }
}

#[test]
fn the_filter_recovers_after_a_silence_of_any_length() {
    let model = model(1.1, 0.01, 0.01);
    for silence in 0..1500 {
        let mut driven = filter(&model, 3, Tick(0));
        (0..silence).for_each(|_| apply(&mut driven, 1.0));
        let mut state = SVector::from([3.0, -2.0]);
        for _ in 0..60 {
            driven.filter.measure(driven.filter.tick(), measured(state[0])).expect("in time");
            driven.filter();
            apply(&mut driven, -state[0]);
            state = model.a * state - model.b * state[0];
        }
        driven.filter.measure(driven.filter.tick(), measured(state[0])).expect("in time");
        driven.filter();
        let error = (driven.filter.posterior_mean() - state).norm();
        assert!(error < 0.02 * (1.0 + state.norm()), "{error} after {silence} cycles of silence");
    }
}

#[test]
fn an_absurd_but_finite_measurement_does_not_break_the_filter() {
    let model = model(1.0, 0.1, 0.1);
    let mut driven = filter(&model, 3, Tick(0));
    for (at, value) in [f32::MAX, -f32::MAX, f32::MAX, 0.0].into_iter().enumerate() {
        driven.filter.measure(Tick(at as u32), measured(value)).expect("finite");
        driven.filter();
        assert!(driven.numbers().iter().all(|value| value.is_finite()), "after measurement {at}");
        driven.advance(None);
    }
}
