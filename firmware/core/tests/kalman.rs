//! The filter's estimate depends on what has arrived, never on when or in which order it did; and where all that was
//! applied is acknowledged, it is the best there is.

mod driven;
mod lent;

use driven::{Driven, Link, MERGINGS, settings};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;
use slqg::estimator::{Merging, Model};
use slqg::{Age, DefaultInput, Scalar, Tick, nalgebra};

const NX: usize = 3;
const NU: usize = 1;
const NY: usize = 2;
/// Cycles of a random history.
const CYCLES: usize = 12;
const START: Tick = Tick(u32::MAX - 4);

type Plant<T> = Model<T, NX, NU, NY>;
/// Sequences of one input, which arrive in the cycle they are sent in or never.
type Filter<T, const H: usize> = Driven<T, NX, NU, NY, 1, H>;

/// A plant from numbers in -1..1; its covariances are positive definite.
fn plant<T: Scalar>(numbers: &[f64]) -> Plant<T> {
    let mut rest = numbers.iter();
    let mut next = || *rest.next().expect("enough numbers");
    let mut matrix = || SMatrix::<f64, NX, NX>::from_fn(|_, _| next());
    let (a, process, initial, outputs) = (matrix(), matrix(), matrix(), matrix());
    let covariance = |root: SMatrix<f64, NX, NX>| root * root.transpose() + SMatrix::identity() * 0.1;
    Model {
        a: a.map(T::nearest),
        b: SMatrix::from_fn(|row, _| T::nearest(numbers[row])),
        c: outputs.fixed_rows::<NY>(0).map(T::nearest),
        process_noise: covariance(process).map(T::nearest),
        measurement_noise: covariance(outputs).fixed_view::<NY, NY>(0, 0).map(T::nearest),
        initial_mean: SVector::from_fn(|row, _| T::nearest(numbers[row + NX])),
        initial_covariance: covariance(initial).map(T::nearest),
    }
}

/// What happens to one cycle's data on its way to the filter.
#[derive(Debug, Clone)]
struct Cycle {
    output: [f64; NY],
    /// Cycles that the measurement is late; `None` if it is lost.
    output_late: Option<usize>,
    input: f64,
    /// Cycles that the acknowledgement is late, beyond the one after; `None` if it is lost.
    acknowledged_late: Option<usize>,
    /// Place among what arrives in the same cycle.
    place: u32,
}

impl Cycle {
    fn output<T: Scalar>(&self) -> SVector<T, NY> {
        SVector::from(self.output.map(T::nearest))
    }

    fn input<T: Scalar>(&self) -> SVector<T, NU> {
        SVector::from([T::nearest(self.input)])
    }
}

fn histories(most_late: usize) -> impl Strategy<Value = (Vec<f64>, Vec<Cycle>)> {
    let late = move |most: usize| prop_oneof![1 => Just(None), 4 => (0..=most).prop_map(Some)];
    let number = || -1.0..1.0;
    let cycle = ([number(), number()], late(most_late), number(), late(most_late.max(1) - 1), any::<u32>());
    let cycle = cycle.prop_map(|(output, output_late, input, acknowledged_late, place)| Cycle {
        output,
        output_late,
        input,
        acknowledged_late,
        place,
    });
    (proptest::collection::vec(number(), 4 * NX * NX), proptest::collection::vec(cycle, CYCLES))
}

fn filter<T: Scalar, const H: usize>(model: &Plant<T>, merging: Merging, late: usize) -> Filter<T, H> {
    let link = Link::new(model.clone(), &[0.6], settings(DefaultInput::Zero, None));
    link.driven(merging, late, START)
}

/// The filter that is given in time whatever has arrived by cycle `now`.
fn told_in_time<T: Scalar, const H: usize>(
    model: &Plant<T>,
    merging: Merging,
    cycles: &[Cycle],
    now: usize,
) -> Filter<T, H> {
    let mut driven = filter(model, merging, H - 1);
    for (at, cycle) in cycles.iter().enumerate().take(now + 1) {
        let tick = START + at as u32;
        if cycle.output_late.is_some_and(|late| at + late <= now) {
            driven.filter.measure(tick, cycle.output()).expect("in time");
        }
        if at > 0 && cycles[at - 1].acknowledged_late.is_some_and(|late| at + late <= now) {
            assert!(driven.filter.acknowledge(tick - 1, Age::Steps(0)));
        }
        driven.filter();
        if at < now {
            driven.advance(Some([cycle.input()]));
        }
    }
    driven
}

/// Delivers everything late and in the order of places, and compares in every cycle.
fn order_does_not_matter<T: Scalar, const H: usize>(numbers: &[f64], cycles: &[Cycle], most_late: usize) {
    let model = plant::<T>(numbers);
    for merging in MERGINGS {
        let mut driven: Filter<T, H> = filter(&model, merging, most_late);
        for now in 0..cycles.len() {
            let mut places: Vec<usize> = (0..=now).collect();
            places.sort_by_key(|&at| cycles[at].place);
            for at in places {
                let (cycle, tick) = (&cycles[at], START + at as u32);
                if cycle.output_late == Some(now - at) {
                    assert_eq!(driven.filter.measure(tick, cycle.output()), Ok(()));
                }
                if at < now && cycle.acknowledged_late == Some(now - at - 1) {
                    assert!(driven.filter.acknowledge(tick, Age::Steps(0)));
                }
                // Filtering early, with half of what arrives in this cycle, must not matter either.
                if cycle.place % 3 == 0 {
                    driven.filter();
                }
            }
            driven.filter();
            let in_time = told_in_time::<T, H>(&model, merging, cycles, now);
            assert_eq!(driven.bits(), in_time.bits(), "cycle {now} with {merging:?}");
            driven.advance(Some([cycles[now].input()]));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn late_and_shuffled_data_give_the_same_bits_as_data_in_time((numbers, cycles) in histories(5)) {
        order_does_not_matter::<f32, 6>(&numbers, &cycles, 5);
        order_does_not_matter::<f64, 6>(&numbers, &cycles, 5);
        order_does_not_matter::<f32, 9>(&numbers, &cycles, 5);
    }

    #[test]
    fn the_shortest_memory_takes_data_one_cycle_late((numbers, cycles) in histories(1)) {
        order_does_not_matter::<f32, 2>(&numbers, &cycles, 1);
    }

    #[test]
    fn a_memory_for_no_late_measurement_still_takes_the_last_acknowledgement((numbers, cycles) in histories(0)) {
        order_does_not_matter::<f32, 4>(&numbers, &cycles, 0);
    }

    #[test]
    fn without_measurements_the_estimate_is_the_open_loop_prediction((numbers, cycles) in histories(0)) {
        let model = plant::<f64>(&numbers);
        let mut driven: Filter<f64, 3> = filter(&model, Merging::Single, 2);
        let (mut mean, mut covariance) = (model.initial_mean, model.initial_covariance);
        for cycle in &cycles {
            driven.filter();
            let found = &driven.filter;
            prop_assert!((found.posterior_mean() - mean).norm() <= 1e-12 * (1.0 + mean.norm()));
            prop_assert!((found.posterior_covariance() - covariance).norm() <= 1e-12 * covariance.norm());
            driven.advance(Some([cycle.input()]));
            prop_assert!(driven.filter.acknowledge(driven.filter.tick() - 1, Age::Steps(0)));
            mean = model.a * mean + model.b * cycle.input;
            covariance = model.a * covariance * model.a.transpose() + model.process_noise;
        }
    }

    #[test]
    fn the_estimate_is_the_least_squares_fit_to_the_whole_history((numbers, cycles) in histories(5)) {
        let model = plant::<f64>(&numbers);
        let now = SPAN - 1;
        let acknowledged = |cycle: Cycle| Cycle { acknowledged_late: Some(0), ..cycle };
        let cycles: Vec<Cycle> = cycles.into_iter().map(acknowledged).collect();
        let (mean, covariance) = least_squares(&model, &cycles, now);
        for merging in MERGINGS {
            let found = told_in_time::<f64, 7>(&model, merging, &cycles, now).filter;
            prop_assert!((found.posterior_mean() - mean).norm() < 1e-9 * (1.0 + mean.norm()));
            prop_assert!((found.posterior_covariance() - covariance).norm() < 1e-9 * covariance.norm());
        }
    }

    #[test]
    fn the_steady_covariance_solves_the_riccati_equation((numbers, _) in histories(0)) {
        let model = plant::<f64>(&numbers);
        let mut driven: Filter<f64, 2> = filter(&model, Merging::Single, 0);
        for at in 0..3000 {
            driven.filter.measure(START + at, SVector::zeros()).expect("in time");
            driven.advance(None);
        }
        let found = driven.filter.posterior_covariance();
        let prior = model.a * found * model.a.transpose() + model.process_noise;
        let innovation = model.c * prior * model.c.transpose() + model.measurement_noise;
        let inverse = innovation.try_inverse().expect("positive definite");
        let posterior = prior - prior * model.c.transpose() * inverse * model.c * prior;
        let residual = model.a * posterior * model.a.transpose() + model.process_noise - prior;
        prop_assert!(residual.norm() < 1e-9 * prior.norm(), "{residual} of {prior}");
    }
}

/// Cycles of the least-squares fit.
const SPAN: usize = 6;
/// Its unknowns: the states of all cycles, stacked.
const UNKNOWNS: usize = SPAN * NX;

/// Mean and covariance of the last state, from the normal equations of the whole history.
fn least_squares(
    model: &Plant<f64>,
    cycles: &[Cycle],
    now: usize,
) -> (SVector<f64, NX>, SMatrix<f64, NX, NX>) {
    let mut information = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    let mut weighted = SVector::<f64, UNKNOWNS>::zeros();
    let invert = |noise: SMatrix<f64, NX, NX>| noise.try_inverse().expect("positive definite");
    let (from_initial, from_process) = (invert(model.initial_covariance), invert(model.process_noise));
    let from_output = model.measurement_noise.try_inverse().expect("positive definite");
    let mut first = information.fixed_view_mut::<NX, NX>(0, 0);
    first += from_initial;
    weighted.fixed_rows_mut::<NX>(0).copy_from(&(from_initial * model.initial_mean));
    for (at, cycle) in cycles.iter().enumerate().take(now + 1) {
        if cycle.output_late.is_some_and(|late| at + late <= now) {
            let mut block = information.fixed_view_mut::<NX, NX>(at * NX, at * NX);
            block += model.c.transpose() * from_output * model.c;
            let mut part = weighted.fixed_rows_mut::<NX>(at * NX);
            part += model.c.transpose() * from_output * cycle.output::<f64>();
        }
        if at < now {
            // The residual of the transition is `[-A I] [x; x+] - B u`.
            let mut transition = SMatrix::<f64, NX, { 2 * NX }>::identity();
            transition.fixed_view_mut::<NX, NX>(0, 0).copy_from(&-model.a);
            transition.fixed_view_mut::<NX, NX>(0, NX).fill_with_identity();
            let weight = transition.transpose() * from_process;
            let mut block = information.fixed_view_mut::<{ 2 * NX }, { 2 * NX }>(at * NX, at * NX);
            block += weight * transition;
            let mut part = weighted.fixed_rows_mut::<{ 2 * NX }>(at * NX);
            part += weight * model.b * cycle.input::<f64>();
        }
    }
    let covariance = information.try_inverse().expect("positive definite");
    let mean = covariance * weighted;
    (mean.fixed_rows::<NX>(now * NX).into(), covariance.fixed_view::<NX, NX>(now * NX, now * NX).into())
}
