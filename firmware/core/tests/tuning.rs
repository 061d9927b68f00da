//! A device that solves its own gains: what it takes, what it refuses, and what it does not put in force.

mod double_integrator;
mod lent;

use double_integrator::{DELAYS, LENGTH, WEIGHT, Workshop};
use slqg::actuator::Settings;
use slqg::controller::Design;
use slqg::estimator::Model;
use slqg::nalgebra::{SMatrix, SVector};
use slqg::synthesis::InvalidProblem;
use slqg::tuning::{
    Basis, Event, InvalidTuner, Parameters, Progress, Solved, Solver, Tuner, Unsolved, tuner_len,
    workspace_len,
};
use slqg::wire::{Acknowledgement, encode_acknowledgement};
use slqg::{Age, DefaultInput, Scalar, Tick, arrival};

const SETTINGS: Settings<f32, 1> = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };

fn survival<T: Scalar>(delays: &[f64]) -> [T; LENGTH] {
    let mut left = [0.0; LENGTH];
    arrival::survival(delays, 1.0 - delays.iter().sum::<f64>(), &mut left);
    left.map(T::nearest)
}

fn basis<'b>(state_cost: &'b [f32], survival: &'b [f32]) -> Basis<'b, f32> {
    Basis { state_cost, input_cost: &[0.05], survival, default_input: DefaultInput::Zero }
}

/// What a solver is lent.
fn memory() -> Vec<f32> {
    vec![f32::NAN; workspace_len(&basis(&[0.0; 4], &[0.0; LENGTH]).dimensions(2, 1))]
}

/// What a tuner is lent.
fn tuner_memory() -> Vec<f32> {
    vec![f32::NAN; tuner_len(&basis(&[0.0; 4], &[0.0; LENGTH]), 2, 1)]
}

/// Solves to the end.
fn solved(solver: &mut Solver<'_, f32, 2, 1>, survival: &[f32]) -> Result<Solved<f32>, Unsolved> {
    solver.begin(survival);
    loop {
        match solver.slice() {
            Progress::Working => {}
            Progress::Solved(solved) => return Ok(solved),
            Progress::Unsolved(why) => return Err(why),
            Progress::Idle => unreachable!("it has begun"),
        }
    }
}

#[test]
fn a_link_that_cannot_carry_the_loop_is_told_and_the_next_one_is_solved_all_the_same() {
    let model = model([[1.2, 0.1], [0.0, 1.1]], [0.0, 1.0]);
    let (good, mut memory) = (survival(&DELAYS), memory());
    let cost = [1.0, 0.0, 0.0, 1.0];
    let mut solver = Solver::new(&model, basis(&cost, &good), 4000, &mut memory).expect("it fits");
    let first = solved(&mut solver, &good).expect("it can be stabilised");
    assert!(first.rate < 1.0 && first.residual < 1e-5, "{first:?}");
    assert_eq!(solved(&mut solver, &survival(&[0.05])), Err(Unsolved::Diverged));
    let again = solved(&mut solver, &good).expect("it still can");
    assert!(again.steps < first.steps, "from the cost-to-go it had: {again:?} after {first:?}");
}

#[test]
fn gains_that_do_not_see_an_unstable_mode_are_not_proved() {
    // The second state grows, costs nothing and cannot be controlled: the recursion converges, the loop does not.
    let model = model([[0.9, 0.0], [0.0, 1.1]], [1.0, 0.0]);
    let (link, mut memory) = (survival(&DELAYS), memory());
    let cost = [1.0, 0.0, 0.0, 0.0];
    let mut solver = Solver::new(&model, basis(&cost, &link), 4000, &mut memory).expect("it fits");
    assert_eq!(solved(&mut solver, &link), Err(Unsolved::NotProved));
}

#[test]
fn a_solution_that_takes_too_long_is_given_up() {
    let workshop = Workshop::<f32>::double_integrator(SETTINGS);
    let (link, weight, mut memory) = (survival(&DELAYS), WEIGHT.map(|weight| weight as f32), memory());
    let mut solver = Solver::new(&workshop.model, basis(&weight, &link), 10, &mut memory).expect("it fits");
    assert_eq!(solved(&mut solver, &link), Err(Unsolved::NotConverged));
}

#[test]
fn the_tuner_of_four_states_and_eight_inputs_a_sequence_takes_less_than_twelve_kibibytes() {
    let bytes = |length| {
        let survival = vec![0.0; length];
        let basis = Basis {
            state_cost: &[0.0; 16],
            input_cost: &[0.0],
            survival: &survival,
            default_input: DefaultInput::Zero,
        };
        size_of::<Tuner<'_, f32, 4, 1>>() + 4 * tuner_len(&basis, 4, 1)
    };
    let (four, eight) = (bytes(4), bytes(8));
    println!("{four} bytes for N = 4, {eight} for N = 8");
    assert!(four < 3 << 10 && eight < 12 << 10, "{four}, {eight}");
}

#[test]
fn a_tuner_switches_when_acknowledgements_say_that_the_link_is_another() {
    let workshop = Workshop::<f32>::double_integrator(SETTINGS);
    let design = workshop.design();
    let (link, weight, mut memory) = (survival(&DELAYS), WEIGHT.map(|weight| weight as f32), tuner_memory());
    let basis = basis(&weight, &link);
    let mut tuner =
        Tuner::<f32, 2, 1>::new(&design, basis, Parameters::DEFAULT, &mut memory).expect("it fits");
    let mut controller = lent::controller(design, Tick(0)).expect("it fits");
    let (mut frame, mut events) = ([0; 64], Vec::new());
    for cycle in 0..600_u32 {
        if let Some(last) = cycle.checked_sub(1) {
            // Every packet is one cycle late.
            let age = if last == 0 { Age::Empty } else { Age::Steps(1) };
            let told = Acknowledgement::of(Tick(last), age);
            let bytes = encode_acknowledgement::<f32>(&told, &mut frame).expect("there is room");
            controller.receive(bytes).expect("a good acknowledgement");
        }
        tuner.observe(&controller);
        let sent = match tuner.law() {
            Some(law) => controller.cycle_under(&law, &mut frame).expect("it fits"),
            None => controller.cycle(&mut frame).expect("there is room"),
        };
        assert!(sent.is_some());
        events.extend(tuner.slice());
    }
    assert!(matches!(events[..], [Event::Started { .. }, Event::Switched(_), ..]), "{events:?}");
    let law = tuner.law().expect("one is in force");
    assert!(law.arrives_at_once < 0.1 && law.gains.arrival(1, 0) > 0.5, "{law:?}");
    assert_eq!(tuner.counts().kept, 0);
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let workshop = Workshop::<f32>::double_integrator(SETTINGS);
    let design = workshop.design();
    let (link, weight) = (survival::<f32>(&DELAYS), WEIGHT.map(|weight| weight as f32));
    let new = |design: &Design<'_, f32, 2, 1, 1>, basis, parameters, memory: &mut [f32]| {
        Tuner::<f32, 2, 1>::new(design, basis, parameters, memory).map(drop)
    };
    let good = basis(&weight, &link);
    assert_eq!(new(&design, good, Parameters::DEFAULT, &mut tuner_memory()), Ok(()));
    assert_eq!(
        new(&design, basis(&weight, &link[1..]), Parameters::DEFAULT, &mut tuner_memory()),
        Err(InvalidTuner::Basis)
    );
    assert_eq!(
        new(&design, basis(&weight[1..], &link), Parameters::DEFAULT, &mut tuner_memory()),
        Err(InvalidTuner::Problem(InvalidProblem::Q))
    );
    let short = &mut tuner_memory()[1..];
    assert_eq!(
        new(&design, good, Parameters::DEFAULT, short),
        Err(InvalidTuner::Problem(InvalidProblem::Workspace))
    );
    let forgetful = Parameters { memory: 0, ..Parameters::DEFAULT };
    assert_eq!(new(&design, good, forgetful, &mut tuner_memory()), Err(InvalidTuner::Parameters));
}

fn model(a: [[f32; 2]; 2], b: [f32; 2]) -> Model<f32, 2, 1, 1> {
    Model {
        a: SMatrix::from_fn(|row, column| a[row][column]),
        b: SVector::from(b),
        c: SMatrix::zeros(),
        process_noise: SMatrix::zeros(),
        measurement_noise: SMatrix::zeros(),
        initial_mean: SVector::zeros(),
        initial_covariance: SMatrix::zeros(),
    }
}
