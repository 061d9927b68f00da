//! A double integrator, controlled over a link that loses half of the packets: `cargo run -p slqg --example hello_loop`.

use slqg::actuator::{Actuator, Settings, memory_len};
use slqg::checked::{Finite, Probabilities};
use slqg::controller::{Controller, Design, Sizes};
use slqg::estimator::{Merging, Model, Plausibility};
use slqg::gains::{Gains, Tables};
use slqg::nalgebra::{Matrix1, Matrix2, RowVector2, Vector2};
use slqg::{DefaultInput, Tick, wire::Measurement};

/// The law for sequences of three inputs, each of which arrives at once with a probability of one half, or never; for the cost
/// `x1^2 + u^2 / 10`. What is in flight makes no difference on such a link.
const LAW: Gains<'static, f32, 2, 1> = Gains::<f32, 2, 1>::new(
    3,
    DefaultInput::Zero,
    Tables {
        lx: Finite::<f32>::new(&[-2.825, -2.491, -2.148, -2.231, -1.628, -2.103]),
        m: Finite::<f32>::new(&[0.0; 6]),
        arrival: Probabilities::<f32>::new(&[0.0; 3]),
    },
);

slqg::controller_memory!(struct Memory: f32, 2, 1, 1; Sizes::of(3, 2, 1));

fn main() {
    let model = Model {
        a: Matrix2::new(1.0, 0.1, 0.0, 1.0),
        b: Vector2::new(0.005, 0.1),
        c: RowVector2::new(1.0, 0.0),
        process_noise: Matrix2::identity() * 1e-6,
        measurement_noise: Matrix1::new(1e-4),
        initial_mean: Vector2::zeros(),
        initial_covariance: Matrix2::identity(),
    };
    let actuator = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
    let design = Design {
        gains: LAW,
        model: &model,
        actuator,
        measurement_buffer: 0,
        acknowledgement_buffer: 1,
        preview: None,
        trigger: None,
        arrives_at_once: 0.5,
        merging: Merging::Single,
        plausibility: &Plausibility::NONE,
        grid: None,
    };
    let (mut memory, mut buffer) = (Memory::new(), [Default::default(); memory_len(3)]);
    let mut controller = Controller::new(design, Tick(0), memory.lend()).expect("a design that fits");
    let mut actuator = Actuator::new(actuator, Tick(0), &mut buffer);
    let (mut state, mut frame, mut coin) = (Vector2::new(1.0, 0.0), [0; 64], 1_u32);
    for cycle in 0..100 {
        let measurement = Measurement { tick: Tick(cycle), output: model.c * state };
        controller.measured(&measurement).expect("the first of this cycle");
        let sent = controller.cycle(&mut frame).expect("there is room");
        coin = coin.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let arrived = sent.filter(|_| coin >> 31 == 0);
        if let Some(frame) = arrived {
            actuator.receive(frame).expect("newer than the one before");
        }
        let applied = actuator.step();
        controller.acknowledged(&actuator.acknowledgement(1).expect("it has played")).expect("of use");
        if cycle % 5 == 0 {
            let fate = if arrived.is_some() { "arrives" } else { "is lost" };
            println!("cycle {cycle:2}: position {:7.4}, speed {:7.4}; the packet {fate}", state[0], state[1]);
        }
        state = model.a * state + model.b * applied.input;
    }
    assert!(state.norm() < 0.01, "the loop is stable: {state}");
}
