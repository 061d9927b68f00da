//! Padding changes nothing: the same design in a larger size class gives the same run, to the bit.

use gain_gen::design::Design;
use host_sim::{
    closed_loop::{RunPlan, run},
    contender::{Contender, Kind},
    size_class::{Fitted, SimScalar},
};

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const DOUBLE_INTEGRATOR: &str = include_str!("../../designs/double_integrator_bad.toml");

fn costs<T: SimScalar, const NX: usize, const NU: usize, const NY: usize>(text: &str) -> Vec<u64> {
    let design = Design::parse(text, "design.toml").expect("a design");
    let contender = Contender::new(Kind::Slqg, &design).expect("a stabilised loop");
    let fitted = Fitted::<T, NX, NU, NY>::new(&design, &contender);
    let mut states = Vec::new();
    for number in 0..3 {
        let plan = RunPlan { steps: 100, seed: 9, run: number };
        let result = run(&fitted, &contender, plan, |cycle| {
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
fn the_double_integrator_runs_the_same_in_every_class_that_holds_it() {
    let smallest = costs::<f64, 2, 1, 2>(DOUBLE_INTEGRATOR);
    assert_eq!(smallest, costs::<f64, 4, 1, 2>(DOUBLE_INTEGRATOR));
    assert_eq!(smallest, costs::<f64, 4, 2, 4>(DOUBLE_INTEGRATOR));
}
