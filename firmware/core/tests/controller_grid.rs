//! A whole loop on classic CAN: a controller that has the grid sends what one frame carries without loss, and knows what the
//! actuator applies; one that has none does not.

mod can_bus;
#[path = "random/dice.rs"]
mod dice;
mod lent;

use can_bus::{BusFrame, DESIGN, grid, identifiers};
use dice::Dice;
use slqg::actuator::{Applied, Settings};
use slqg::controller::{Design, InvalidDesign};
use slqg::estimator::{Merging, Model, Plausibility};
use slqg::gains::{Gains, Tables};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::wire::can::{Compact, Grid, LARGEST_OF_FULL_FRAME, MOST_CYCLES};
use slqg::wire::{self, Measurement};
use slqg::{DefaultInput, Scalar, Tick};

const LENGTH: usize = 3;
const CYCLES: u32 = 2000;
/// The low half of the tick wraps on the way, and the tick itself.
const START: Tick = Tick(u32::MAX - 1000);
/// Probability that a packet arrives in the cycle it was sent in, and in the next two.
const DELAYS: [f64; LENGTH] = [0.6, 0.2, 0.1];
const LX: [f64; 2 * LENGTH] = [-3.0, -3.0, -2.6, -2.7, -2.2, -2.4];
const M: [f64; LENGTH * (LENGTH - 1)] = [0.1, 0.02, 0.05, 0.01, 0.02, 0.0];
const ARRIVAL: [f64; 3] = [0.5, 0.25, 0.6];

/// The law, which the numbers of both scalars are.
fn gains<T: Scalar>(tables: &[Vec<T>; 3]) -> Gains<'_, T, 2, 1> {
    let [lx, m, arrival] = tables;
    let tables = Tables::check(lx, m, arrival).expect("gains");
    Gains::check(LENGTH, DefaultInput::Zero, tables).expect("tables that fit")
}

fn tables<T: Scalar>() -> [Vec<T>; 3] {
    [&LX[..], &M, &ARRIVAL].map(|values| values.iter().map(|&value| T::nearest(value)).collect())
}

/// Position and speed, position measured.
fn model<T: Scalar>() -> Model<T, 2, 1, 1> {
    Model {
        a: SMatrix::<f64, 2, 2>::from([[1.0, 0.0], [0.1, 1.0]]).map(T::nearest),
        b: SMatrix::<f64, 2, 1>::from([[0.005, 0.1]]).map(T::nearest),
        c: SMatrix::<f64, 1, 2>::from([[1.0], [0.0]]).map(T::nearest),
        process_noise: SMatrix::from_diagonal_element(T::nearest(1e-4)),
        measurement_noise: SMatrix::from_element(T::nearest(1e-4)),
        initial_mean: SVector::zeros(),
        initial_covariance: SMatrix::identity(),
    }
}

/// Steps of 10/4095: inputs up to 10.
fn inputs<T: Scalar>() -> Grid<T, 1> {
    let step = T::nearest(10.0) / T::nearest(f64::from(LARGEST_OF_FULL_FRAME));
    Grid { step: SVector::from([step]), largest_count: LARGEST_OF_FULL_FRAME }
}

/// Runs the loop over a bus that loses and delays frames. Returns in how many cycles a control frame came out of its CAN
/// frame as it went in, in how many the controller then knew the applied input to the bit, and the largest position.
fn on_the_bus<T: Scalar>(in_design: Option<Grid<T, 1>>) -> (u32, u32, f64) {
    let model = model::<T>();
    let settings = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
    let tables = tables::<T>();
    let design = Design {
        gains: gains(&tables),
        model: &model,
        actuator: settings,
        measurement_buffer: 4,
        acknowledgement_buffer: MOST_CYCLES,
        preview: None,
        trigger: None,
        arrives_at_once: T::nearest(DELAYS[0]),
        merging: Merging::Single,
        plausibility: &Plausibility::NONE,
        grid: in_design,
    };
    let compact =
        Compact::<T, 1, 1>::new(DESIGN, identifiers(), inputs(), grid([1.0 / 4096.0])).expect("a valid form");
    let mut controller = lent::controller(design, START).expect("a fitting design");
    let mut actuator = lent::actuator(settings, START, LENGTH);
    let mut state = SVector::<T, 2>::from([1.0, 0.5].map(T::nearest));
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    let mut last: Option<Applied<T, 1>> = None;
    let mut under_way: Vec<(u32, BusFrame)> = vec![];
    let (mut same, mut known, mut largest) = (0, 0, 0.0_f64);
    let (mut full, mut restored) = ([0; 64], [0; 64]);
    for cycle in 0..CYCLES {
        let tick = START + cycle;
        let measurement = Measurement { tick, output: model.c * state };
        let frame = wire::encode_measurement(&measurement, &mut full).expect("room");
        let sensed: BusFrame = compact.pack(frame).expect("one output");
        controller
            .receive(compact.unpack(&sensed, controller.tick(), &mut restored).expect("a measurement"))
            .expect("new");

        let frame = controller.cycle(&mut full).expect("room").expect("finite");
        let is_known =
            |applied: Applied<T, 1>| controller.expected_input(applied.tick) == Some(applied.input);
        known += u32::from(last.is_some_and(is_known));
        let sent: BusFrame = compact.pack(frame).expect("three inputs");
        same += u32::from(compact.unpack(&sent, actuator.tick(), &mut restored) == Ok(frame));
        if let Some(delay) = dice.delay(&DELAYS) {
            under_way.push((cycle + delay as u32, sent));
        }
        let (arrived, rest) = under_way.into_iter().partition::<Vec<_>, _>(|(arrival, _)| *arrival == cycle);
        under_way = rest;
        for (_, frame) in arrived {
            let frame = compact.unpack(&frame, actuator.tick(), &mut restored).expect("a control frame");
            // Past ones are refused.
            let _ = actuator.receive(frame);
        }
        let applied = actuator.step();
        let told = actuator.acknowledgement(MOST_CYCLES).expect("it has played");
        let frame = wire::encode_acknowledgement::<T>(&told, &mut full).expect("room");
        let told: BusFrame = compact.pack(frame).expect("five cycles at most");
        controller
            .receive(compact.unpack(&told, controller.tick(), &mut restored).expect("an acknowledgement"))
            .expect("of use");
        last = Some(applied);
        state = model.a * state + model.b * applied.input;
        largest = largest.max(state[0].widen().abs());
    }
    assert!(state.norm().widen() < 0.05, "{state}");
    (same, known, largest)
}

fn knows_what_is_applied<T: Scalar>() {
    let (same, known, largest) = on_the_bus::<T>(Some(inputs()));
    assert_eq!((same, known), (CYCLES, CYCLES - 1), "all but the last");
    assert!((1.0..1.5).contains(&largest), "{largest}");
    let (same, known, _) = on_the_bus::<T>(None);
    assert!(same < CYCLES / 10 && known < CYCLES / 2, "without a grid: {same}, {known}");
}

#[test]
fn a_loop_on_classic_can_loses_nothing_of_the_inputs() {
    knows_what_is_applied::<f32>();
    knows_what_is_applied::<f64>();
}

#[test]
fn a_grid_without_a_positive_step_is_refused() {
    let model = model::<f32>();
    let tables = tables::<f32>();
    let design = Design {
        gains: gains(&tables),
        model: &model,
        actuator: Settings { default_input: DefaultInput::Zero, limits: None, safe: None },
        measurement_buffer: 4,
        acknowledgement_buffer: 1,
        preview: None,
        trigger: None,
        arrives_at_once: 0.6,
        merging: Merging::Single,
        plausibility: &Plausibility::NONE,
        grid: Some(inputs()),
    };
    assert_eq!(lent::controller(design, START).err(), None);
    for grid in [grid([0.0]), grid([-1.0]), grid([f64::NAN]), Grid { largest_count: 0, ..inputs() }] {
        let refused = lent::controller(Design { grid: Some(grid), ..design }, START);
        assert_eq!(refused.err(), Some(InvalidDesign::Grid), "{grid:?}");
    }
}
