//! A million cycles in which nothing comes back, or next to nothing; and then the link returns.

#[path = "random/dice.rs"]
mod dice;
mod lent;

use dice::Dice;
use slqg::actuator::{Actuator, Settings};
use slqg::checked::{Finite, Probabilities};
use slqg::controller::{Controller, Design};
use slqg::estimator::{Merging, Model, Plausibility};
use slqg::gains::{Gains, Tables};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::wire::{self, Measurement};
use slqg::{DefaultInput, Tick};

const SILENCE: u32 = 1_000_000;
const LENGTH: usize = 2;
/// Probability that a packet arrives in the cycle it was sent in, and in the next.
const DELAYS: [f64; LENGTH] = [0.8, 0.15];
/// Places the poles of the plant below well within the unit circle, and goes on as if no noise came.
const LAW: Tables<'static, f32> = Tables {
    lx: Finite::<f32>::new(&[-30.0, -8.0, -4.5, -3.4]),
    m: Finite::<f32>::new(&[0.0; LENGTH]),
    arrival: Probabilities::<f32>::new(&[0.75]),
};
const GAINS: Gains<'static, f32, 2, 1> = Gains::<f32, 2, 1>::new(LENGTH, DefaultInput::Zero, LAW);

type Node<'a> = Controller<'a, f32, 2, 1, 1>;

/// What comes back to the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Back {
    measurements: bool,
    acknowledgements: bool,
}

/// Position and speed of an unstable plant, position measured.
fn model() -> Model<f32, 2, 1, 1> {
    Model {
        a: SMatrix::from([[1.1, 0.0], [0.1, 1.0]]),
        b: SMatrix::from([[0.005, 0.1]]),
        c: SMatrix::from([[1.0], [0.0]]),
        process_noise: SMatrix::from_diagonal_element(1e-4),
        measurement_noise: SMatrix::from([[1e-4]]),
        initial_mean: SVector::from([0.1, 0.0]),
        initial_covariance: SMatrix::identity(),
    }
}

struct Loop<'a> {
    model: &'a Model<f32, 2, 1, 1>,
    controller: Node<'a>,
    actuator: Actuator<'static, f32, 1>,
    state: SVector<f32, 2>,
    dice: Dice,
    late: Option<Vec<u8>>,
}

impl Loop<'_> {
    fn controls(&mut self, back: Back) -> Option<Vec<u8>> {
        let mut buffer = [0; 64];
        if back.measurements {
            let measurement = Measurement { tick: self.controller.tick(), output: self.model.c * self.state };
            let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
            self.controller.receive(frame).expect("of use");
        }
        let frame = self.controller.cycle(&mut buffer).expect("there is room").map(<[u8]>::to_vec);
        let estimate = self.controller.estimator();
        let covariance = estimate.posterior_covariance();
        let numbers = estimate.posterior_mean().iter().chain(covariance.iter());
        assert!(numbers.into_iter().all(|number| number.is_finite()));
        let sum = estimate.modes().expect("filtered").iter().map(|(_, probability)| probability).sum::<f32>();
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        frame
    }

    /// The plant, with packets that are late by `delays`.
    fn moves(&mut self, frame: Option<Vec<u8>>, delays: &[f64], back: Back) {
        let late = self.late.take();
        match self.dice.delay(delays) {
            Some(0) => {
                frame.and_then(|frame| self.actuator.receive(&frame).ok());
            }
            Some(_) => self.late = frame,
            None => (),
        }
        // Past ones are refused.
        late.and_then(|frame| self.actuator.receive(&frame).ok());
        let applied = self.actuator.step();
        self.state = self.model.a * self.state + self.model.b * applied.input;
        if back.acknowledgements {
            let mut buffer = [0; 32];
            let acknowledgement = self.actuator.acknowledgement(1).expect("it has played");
            let frame = wire::encode_acknowledgement::<f32>(&acknowledgement, &mut buffer);
            self.controller.receive(frame.expect("there is room")).expect("of use");
        }
    }
}

fn the_loop_recovers_from(back: Back) {
    for merging in [Merging::Single, Merging::Imm, Merging::Gpb2] {
        let model = model();
        let actuator = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
        let design = Design {
            gains: GAINS,
            model: &model,
            actuator,
            measurement_buffer: 1,
            acknowledgement_buffer: 1,
            preview: None,
            trigger: None,
            arrives_at_once: DELAYS[0] as f32,
            merging,
            plausibility: &Plausibility::NONE,
            grid: None,
        };
        let mut run = Loop {
            model: &model,
            controller: lent::controller(design, Tick(0)).expect("a fitting design"),
            actuator: lent::actuator(actuator, Tick(0), LENGTH),
            state: SVector::zeros(),
            dice: Dice(0x9E37_79B9_7F4A_7C15),
            late: None,
        };
        for cycle in 0..SILENCE {
            let frame = run.controls(back);
            if back.measurements || back.acknowledgements {
                run.moves(frame, &DELAYS, back);
                if back.measurements {
                    assert!(run.state.norm() < 100.0, "cycle {cycle} with {merging:?}: {}", run.state);
                    // Something to do for the loop.
                    let push = SVector::from_fn(|_, _| (run.dice.roll() as f32 - 0.5) * 0.03);
                    run.state += push;
                } else {
                    // Nobody could keep the plant; what it does has no part in this.
                    run.state = SVector::zeros();
                }
            }
        }
        // The actuator is started again, without a word of it.
        run.actuator.restart(Tick(SILENCE));
        run.late = None;
        if !back.measurements {
            run.state = SVector::from([3.0, -2.0]);
        }
        let all = Back { measurements: true, acknowledgements: true };
        for _ in 0..LENGTH + 4 {
            let frame = run.controls(all);
            run.moves(frame, &[1.0], all);
        }
        let before = run.state;
        run.controls(all);
        let error = (run.controller.estimator().posterior_mean() - before).norm();
        assert!(error < 0.1 * (1.0 + before.norm()), "{error} with {merging:?}, {back:?}");
    }
}

#[test]
fn a_million_cycles_without_measurement_are_survived_and_the_loop_recovers() {
    the_loop_recovers_from(Back { measurements: false, acknowledgements: true });
}

#[test]
fn a_million_cycles_without_acknowledgement_are_controlled_and_the_loop_recovers() {
    the_loop_recovers_from(Back { measurements: true, acknowledgements: false });
}

#[test]
fn a_million_cycles_with_neither_are_survived_and_the_loop_recovers() {
    the_loop_recovers_from(Back { measurements: false, acknowledgements: false });
}
