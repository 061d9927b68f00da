//! Padding changes nothing: the same design in a larger size class gives the same run, to the bit.

use gain_gen::design::Design;
use host_sim::{
    closed_loop::{RunPlan, run},
    contender::{Contender, Kind},
    fitted::Fitted,
    size_class::SimScalar,
};

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const PENDULUM_EVENT: &str = include_str!("../../designs/pendulum_event.toml");
const DRIVE: &str = include_str!("../../designs/drive_tracking.toml");
const STEPS: usize = 100;
const DOUBLE_INTEGRATOR: &str = include_str!("../../designs/double_integrator_bad.toml");

fn costs<T: SimScalar, const NX: usize, const NU: usize, const NY: usize>(text: &str) -> Vec<u64> {
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
