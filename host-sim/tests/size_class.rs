//! Padding changes nothing: the same design in a larger size class gives the same run, to the bit. The largest class runs, and
//! what no class holds is refused.

use gain_gen::{design::Design, report::Report, solve::Method};
use host_sim::{
    closed_loop::{RunPlan, run},
    contender::{Contender, Kind},
    fitted::Fitted,
    monte_carlo::{Plan, Simulate},
    sample::{mean, standard_error},
    size_class::{self},
};
use nalgebra::DMatrix;
use slqg::Scalar;

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const PENDULUM_EVENT: &str = include_str!("../../designs/pendulum_event.toml");
const DRIVE: &str = include_str!("../../designs/drive_tracking.toml");
const STEPS: usize = 100;
const DOUBLE_INTEGRATOR: &str = include_str!("../../designs/double_integrator_bad.toml");

fn costs<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(text: &str) -> Vec<u64> {
    let design = Design::parse(text, "design.toml").expect("a design");
    let contender = Contender::new(Kind::Slqg, &design, STEPS).expect("a stabilised loop");
    let fitted = Fitted::<T, NX, NU, NY>::new(&design, &contender);
    let mut states = Vec::new();
    for number in 0..3 {
        let plan = RunPlan { steps: STEPS, seed: 9, run: number };
        let result = run(&fitted, &contender, plan, |snapshot| {
            let cycle = snapshot.to_record();
            assert!(
                cycle.state[design.plant.states()..].iter().all(|&value| value == 0.0),
                "padded states stay zero"
            );
            assert!(
                cycle.input[design.plant.inputs()..].iter().all(|&value| value == 0.0),
                "padded inputs stay zero"
            );
            states.extend(cycle.state[..design.plant.states()].iter().map(|value| value.to_bits()));
        });
        states.push(result.cost.to_bits());
    }
    states
}

#[test]
fn the_pendulum_runs_the_same_in_every_class_that_holds_it() {
    let smallest = costs::<f32, 4, 1, 2>(PENDULUM);
    assert_eq!(smallest, costs::<f32, 4, 2, 4>(PENDULUM));
    assert_eq!(smallest, costs::<f32, 8, 4, 8>(PENDULUM));
}

#[test]
fn the_event_triggered_pendulum_runs_the_same_in_every_class_that_holds_it() {
    // Cheap packets, so that some of them are sent.
    let text = PENDULUM_EVENT.replace("send_cost = 1000", "send_cost = 0.1");
    assert_ne!(text, PENDULUM_EVENT);
    let smallest = costs::<f32, 4, 1, 2>(&text);
    assert_eq!(smallest, costs::<f32, 4, 2, 4>(&text));
    assert_eq!(smallest, costs::<f32, 8, 4, 8>(&text));
}

#[test]
fn the_drive_with_a_reference_and_an_event_trigger_runs_the_same_in_every_class_that_holds_it() {
    let text = format!("{DRIVE}\n[event]\nsend_cost = 0.5\n");
    let smallest = costs::<f32, 4, 1, 2>(&text);
    assert_eq!(smallest, costs::<f32, 4, 2, 4>(&text));
    assert_eq!(smallest, costs::<f32, 8, 4, 8>(&text));
}

#[test]
fn the_double_integrator_runs_the_same_in_every_class_that_holds_it() {
    let smallest = costs::<f64, 2, 1, 2>(DOUBLE_INTEGRATOR);
    assert_eq!(smallest, costs::<f64, 4, 1, 2>(DOUBLE_INTEGRATOR));
    assert_eq!(smallest, costs::<f64, 4, 2, 4>(DOUBLE_INTEGRATOR));
}

/// 32 states.
const ROPE: &str = include_str!("../../gain-gen/tests/data/rope.toml");

#[test]
fn a_plant_of_32_states_costs_what_its_report_expects() {
    let design = Design::parse(ROPE, "rope.toml").expect("a design");
    let costs = |steps| {
        let contender = Contender::new(Kind::Slqg, &design, steps).expect("a stabilised loop");
        let plan = Plan { runs: 8, steps, seed: 1 };
        let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
        simulate.outcome().expect("a size class").costs
    };
    // The same seed gives a long run the short one's beginning: the difference is the cost of the steps between.
    let (start_up, counted) = (200, 400);
    let (early, late) = (costs(start_up), costs(start_up + counted));
    let per_step: Vec<f64> =
        early.iter().zip(&late).map(|(early, late)| (late - early) / counted as f64).collect();
    let (mean, error) = (mean(&per_step), standard_error(&per_step));
    let expected = Report::new(&design, Method::InFlight).estimation;
    assert!(mean > expected.cost_lower - 4.0 * error, "{mean} +- {error}, {}", expected.cost_lower);
    assert!(mean < expected.cost_upper + 4.0 * error, "{mean} +- {error}, {}", expected.cost_upper);
    assert!(error < 0.1 * mean, "{mean} +- {error}");
}

#[test]
fn a_plant_of_33_states_is_refused_with_the_reason() {
    let mut design = Design::parse(ROPE, "rope.toml").expect("a design");
    assert!(size_class::check(&design).is_ok());
    design.plant.a = DMatrix::identity(33, 33);
    assert_eq!(
        size_class::check(&design).expect_err("no class").to_string(),
        "plant: found 33 states, 1 inputs and 2 outputs; the simulator runs what a device runs, which takes up to 32, 8 and \
         32; reduce the model, or let gain-gen alone have it"
    );
}
