//! Nodes in simulated time: what becomes of the loop when they are late, killed and started again.

mod desk;

use desk::{Desk, Loop, count, design};
use host_sim::node::{clock::WallTime, event_loop::Node};
use std::time::Duration;

/// The pendulum's size class.
type Pendulum = Loop<f32, 4, 1, 2>;

fn cycles(count: u32) -> Duration {
    // 20 ms each.
    Duration::from_millis(20) * count
}

/// Generous: the pendulum's state is of size 0.3 then, and one that falls passes this within a second.
fn stands(desk: &Desk<'_, f32, 4, 1, 2>) -> bool {
    desk.plant.state().norm() < 5.0
}

#[test]
fn without_faults_every_frame_of_every_cycle_is_of_use() {
    let pendulum = Pendulum::new(design("pendulum.toml"));
    let mut desk = Desk::new(&pendulum, 1, false);
    desk.run(cycles(500));
    let (controller, actuator) = (desk.controller.as_ref().unwrap(), desk.actuator.as_ref().unwrap());
    assert!(desk.plant.cycles() >= 498 && stands(&desk), "{}", desk.plant.progress());
    assert_eq!(count(&desk.plant, "applied_inputs", "late_inputs"), 0);
    // The actuator began a cycle earlier, and told of it.
    assert_eq!(count(controller, "controller", "rejected"), 1);
    assert_eq!(count(actuator, "actuator", "rejected"), 0);
    assert_eq!(count(controller, "controller", "starts"), 1);
    // The first acknowledged cycle is the one the controller began in.
    assert!(count(actuator, "actuator", "default_inputs") <= 1);
}

#[test]
fn the_loop_costs_what_the_simulation_without_a_clock_says() {
    let design = design("pendulum.toml");
    let pendulum = Pendulum::new(design);
    let runs = 20;
    let cost = |seed| {
        let mut desk = Desk::new(&pendulum, seed, true);
        desk.run(cycles(1000));
        desk.plant.cost_per_cycle().expect("it was let go")
    };
    let mean = (0..runs).map(cost).sum::<f64>() / f64::from(runs as u32);
    // `host-sim run designs/pendulum.toml --steps 1000` has 0.0214 per cycle.
    assert!((0.015..0.03).contains(&mean), "{mean}");
}

#[test]
fn the_plant_is_held_until_it_is_controlled() {
    let pendulum = Pendulum::new(design("pendulum.toml"));
    let mut desk = Desk::new(&pendulum, 1, false);
    desk.controller = None;
    let state = *desk.plant.state();
    desk.run(cycles(100));
    assert_eq!((*desk.plant.state(), desk.plant.cycles()), (state, 0));
    desk.controller = Some(pendulum.controller(false, desk.now));
    desk.run(cycles(100));
    assert!(desk.plant.cycles() >= 98 && stands(&desk), "{}", desk.plant.progress());
}

#[test]
fn a_controller_and_an_actuator_that_are_started_again_join_the_loop() {
    let pendulum = Pendulum::new(design("pendulum.toml"));
    for seed in 0..10 {
        let mut desk = Desk::new(&pendulum, seed, true);
        desk.run(cycles(200));
        desk.controller = None;
        desk.run(cycles(5));
        desk.controller = Some(pendulum.controller(true, desk.now));
        desk.run(cycles(200));
        desk.actuator = None;
        desk.run(cycles(5));
        desk.actuator = Some(pendulum.actuator(desk.now));
        desk.run(cycles(200));
        assert!(stands(&desk), "seed {seed}: {}", desk.plant.progress());
        let controller = desk.controller.as_ref().unwrap();
        // Acknowledgements of what its predecessor sent are rejected, and are soon over; late measurements are, too.
        assert!(count(controller, "controller", "rejected") < 40, "seed {seed}");
        assert_eq!(count(controller, "controller", "lost_estimates"), 0, "seed {seed}");
    }
}

#[test]
fn a_controller_that_slept_catches_up_and_sends_the_newest_sequence_only() {
    let pendulum = Pendulum::new(design("pendulum.toml"));
    let mut desk = Desk::new(&pendulum, 1, false);
    desk.run(cycles(100));
    let sent = |desk: &Desk<'_, f32, 4, 1, 2>| count(desk.controller.as_ref().unwrap(), "controller", "sent");
    let before = sent(&desk);
    desk.controller_sleeps = desk.now.after(cycles(7));
    desk.run(cycles(10));
    let controller = desk.controller.as_ref().unwrap();
    let skipped = count(controller, "timing", "skipped");
    assert!((6..=7).contains(&skipped), "{skipped}");
    assert_eq!(sent(&desk) - before, 10 - skipped);
    let tick = controller.core().expect("it goes on").tick();
    assert_eq!(tick.0, (desk.now.0 / 20_000_000) as u32, "one cycle for each tick");
    assert_eq!(count(controller, "controller", "starts"), 1);
    desk.run(cycles(200));
    assert!(stands(&desk), "{}", desk.plant.progress());
}

#[test]
fn a_controller_that_slept_for_too_long_begins_anew() {
    let integrator = Loop::<f32, 2, 1, 2>::new(design("double_integrator.toml"));
    let mut desk = Desk::new(&integrator, 1, false);
    desk.run(Duration::from_secs(100));
    desk.controller_sleeps = desk.now.after(Duration::from_secs(80));
    desk.run(Duration::from_secs(300));
    let controller = desk.controller.as_ref().unwrap();
    assert_eq!(count(controller, "timing", "begun_anew"), 1);
    assert_eq!(count(controller, "controller", "starts"), 2);
    assert!(desk.plant.state().norm() < 100.0, "{}", desk.plant.progress());
}

#[test]
fn a_controller_that_hears_no_sensor_begins_anew_when_its_estimate_is_lost() {
    let pendulum = Pendulum::new(design("pendulum.toml"));
    let mut controller = pendulum.controller(false, WallTime(0));
    let mut plant = pendulum.plant(1, WallTime(0));
    let mut outbox = Vec::new();
    plant.act(plant.next().unwrap(), &mut outbox);
    let (_, measurement) = outbox.pop().expect("a held plant is measured");
    controller.receive(&measurement, WallTime(20_000_000));
    let mut sent = 0;
    while count(&controller, "controller", "lost_estimates") == 0 {
        controller.act(controller.next().unwrap(), &mut outbox);
        sent += outbox.drain(..).count();
        assert!(sent < 1000, "an unstable plant is lost within seconds");
    }
    assert!(sent > 20, "{sent}");
    assert_eq!(count(&controller, "controller", "starts"), 1, "the core goes on");
    controller.act(controller.next().unwrap(), &mut outbox);
    let (_, control) = outbox.pop().expect("it goes on sending");
    let mut room = [slqg::nalgebra::SVector::<f32, 1>::zeros(); 4];
    let sent = slqg::wire::decode_control(&control, &mut room).expect("a control frame");
    assert!(sent.inputs.iter().all(|input| input[0].abs() < 1e3), "{:?}", sent.inputs);
}

#[test]
fn an_actuator_clock_that_is_off_is_named_with_by_how_many_cycles() {
    let pendulum = Pendulum::new(design("pendulum.toml"));
    for (cycles_ahead, has_relays) in [(5, false), (-5, false), (5, true), (-5, true), (0, true), (0, false)]
    {
        let mut desk = Desk::new(&pendulum, 1, has_relays);
        desk.actuator_ahead = cycles_ahead * 20_000_000;
        let offset = Duration::from_nanos(desk.actuator_ahead.unsigned_abs());
        let begin = if cycles_ahead < 0 {
            WallTime(desk.now.0 - offset.as_nanos() as u64)
        } else {
            desk.now.after(offset)
        };
        desk.actuator = Some(pendulum.actuator(begin));
        desk.run(cycles(40));
        let named =
            |findings: Vec<String>, what: &str| findings.iter().any(|finding| finding.starts_with(what));
        let plant = desk.plant.findings();
        let (controller, actuator) =
            (desk.controller.as_ref().unwrap().findings(), desk.actuator.as_ref().unwrap().findings());
        match cycles_ahead {
            5 => {
                assert!(named(plant, "the actuator's clock is 5 cycles ahead of this node's"));
                assert!(named(controller, "the actuator's clock is 5 cycles ahead of this node's"));
            }
            -5 => {
                assert!(named(plant, "the actuator's clock is 5 cycles behind this node's"));
                assert!(named(actuator, "the controller's clock is 5 cycles ahead of this node's"));
            }
            _ => assert_eq!([plant, controller, actuator].concat(), [""; 0]),
        }
    }
}
