//! Controllers that are compared meet the same noise and the same fates of packets in the run of the same number.

use gain_gen::design::Design;
use host_sim::{
    closed_loop::CycleRecord,
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
};
use slqg_links::path::Fate;

const BAD: &str = include_str!("../../designs/double_integrator_bad.toml");
const EVENT: &str = include_str!("../../designs/pendulum_event.toml");
const PLAN: Plan = Plan { runs: 1, steps: 200, seed: 3 };

/// The first run.
fn cycles(text: &str, kind: Kind, length: usize) -> Vec<CycleRecord> {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    let contender = Contender::new(kind, &design, PLAN.steps).expect("a stabilised loop");
    let simulate = Simulate { design: &design, contender: &contender, plan: PLAN, done: &|| () };
    simulate.outcome().expect("it can be simulated").first_run
}

/// `w_k = x_{k+1} - A x_k - B u_k` of the double integrator's first component, as far as it is seen in `f64`.
fn disturbances(text: &str, cycles: &[CycleRecord]) -> Vec<f64> {
    let plant = Design::parse(text, "design.toml").expect("a design").plant;
    cycles
        .windows(2)
        .map(|pair| {
            let [now, next] = [&pair[0], &pair[1]];
            let moved: f64 = (0..plant.states()).map(|column| plant.a[(0, column)] * now.state[column]).sum();
            let pushed: f64 =
                (0..plant.inputs()).map(|column| plant.b[(0, column)] * now.input[column]).sum();
            next.state[0] - moved - pushed
        })
        .collect()
}

#[test]
fn controllers_and_lengths_meet_the_same_noise_and_fates() {
    let base = cycles(BAD, Kind::Slqg, 4);
    let noise = disturbances(BAD, &base);
    assert!(noise.iter().any(|w| w.abs() > 1e-3), "there is noise");
    for (kind, length) in [(Kind::Slqg, 6), (Kind::SlqgUdp, 4), (Kind::Lqg, 1)] {
        let other = cycles(BAD, kind, length);
        for (own, others) in noise.iter().zip(disturbances(BAD, &other)) {
            assert!((own - others).abs() < 1e-6 * (1.0 + own.abs()), "{kind:?}: {own} {others}");
        }
        if kind == Kind::Lqg {
            continue;
        }
        let fates = |cycles: &[CycleRecord]| -> Vec<[Option<Fate>; 2]> {
            cycles.iter().map(|cycle| [cycle.control_frame, cycle.measurement_frame]).collect()
        };
        assert_eq!(fates(&base), fates(&other), "{kind:?}, N = {length}");
    }
}

#[test]
fn a_packet_meets_its_fate_whether_or_not_others_were_sent() {
    let [sparing, always] = [Kind::Slqg, Kind::SlqgAlways].map(|kind| cycles(EVENT, kind, 4));
    let mut sent = 0;
    for (sparing, always) in sparing.iter().zip(&always) {
        if let Some(fate) = sparing.control_frame {
            assert_eq!(Some(fate), always.control_frame);
            sent += 1;
        }
    }
    assert!((1..PLAN.steps).contains(&sent), "{sent} sent");
}
