//! Each end of the loop tells how it is, and does no harm where it is lost.

mod by_hand;
mod double_integrator;
mod lent;

use by_hand::workshop;
use double_integrator::Node;
use slqg::actuator::{Limits, Safe, Settings};
use slqg::controller::{Design, InvalidDesign, RejectedFrame};
use slqg::estimator::Plausibility;
use slqg::health::Cause;
use slqg::nalgebra::SVector;
use slqg::sequence::ControlSequence;
use slqg::wire::Measurement;
use slqg::{Age, DefaultInput, Health, Tick};

/// Of the double integrator's sensor.
static PLAUSIBILITY: Plausibility<f32, 1> = Plausibility {
    gate: Some(37.0),
    doubt_after: 3,
    range: Some([[-50.0, 50.0]]),
    stuck_after: [4],
    rejects_stuck: false,
    stale_after: 5,
    lost_after: 20,
};

/// Runs `body` with a controller that has measured zero, or nearly, for ten cycles.
fn after_ten_cycles(plausibility: &'static Plausibility<f32, 1>, body: impl FnOnce(&mut Node<'_, f32>)) {
    let workshop = workshop(DefaultInput::Zero);
    let design = Design { plausibility, ..workshop.design() };
    let mut controller = lent::controller(design, Tick(0)).expect("a fitting design");
    for cycle in 0..10 {
        reads(&mut controller, 0.001 * (cycle % 3) as f32).expect("of use");
        assert!(sends(&mut controller), "cycle {cycle}");
    }
    assert_eq!(controller.health(), Health::Nominal);
    body(&mut controller);
}

fn reads(controller: &mut Node<'_, f32>, reading: f32) -> Result<(), RejectedFrame> {
    controller.measured(&Measurement { tick: controller.tick(), output: SVector::from([reading]) })
}

fn sends(controller: &mut Node<'_, f32>) -> bool {
    let mut buffer = [0; 64];
    controller.cycle(&mut buffer).expect("there is room").is_some()
}

fn position(controller: &Node<'_, f32>) -> f32 {
    controller.estimator().posterior_mean()[0]
}

#[test]
fn a_controller_without_measurements_is_degraded_then_lost_and_silent_until_it_is_measured_again() {
    after_ten_cycles(&PLAUSIBILITY, |controller| {
        for silent in 1..=30 {
            let sent = sends(controller);
            let expected = match silent {
                ..5 => Health::Nominal,
                5..20 => Health::Degraded(Cause::NotMeasured),
                _ => Health::Lost(Cause::NotMeasured),
            };
            assert_eq!(controller.health(), expected, "after {silent}");
            assert_eq!(sent, !expected.is_lost(), "after {silent}");
        }
        assert_eq!(controller.counts().withheld, 11);
        reads(controller, 0.0).expect("of use");
        assert!(sends(controller));
        assert!(!controller.health().is_lost());
    });
}

#[test]
fn a_reading_that_does_not_fit_is_told_and_costs_no_more_than_one_that_is_missing() {
    after_ten_cycles(&PLAUSIBILITY, |controller| {
        let before = position(controller);
        reads(controller, 40.0).expect("within the sensor's range");
        sends(controller);
        assert_eq!(controller.health(), Health::Degraded(Cause::Implausible(0)));
        assert!((position(controller) - before).abs() < 0.1, "{}", position(controller));
        reads(controller, 0.0).expect("of use");
        sends(controller);
        assert_eq!(controller.health(), Health::Nominal);
    });
}

#[test]
fn where_nothing_fits_any_more_the_estimate_begins_anew_with_what_is_measured() {
    after_ten_cycles(&PLAUSIBILITY, |controller| {
        for cycle in 0..2 {
            reads(controller, 40.0 + 0.001 * cycle as f32).expect("of use");
            sends(controller);
            assert!((position(controller) - 40.0).abs() > 10.0, "cycle {cycle}");
        }
        reads(controller, 40.0).expect("of use");
        sends(controller);
        assert_eq!(controller.health(), Health::Degraded(Cause::BegunAnew));
        assert!((position(controller) - 40.0).abs() < 0.5, "{}", position(controller));
        assert_eq!(controller.counts().begun_anew, 1);
    });
}

#[test]
fn a_number_that_no_sensor_tells_is_never_believed() {
    static NO_RANGE: Plausibility<f32, 1> = Plausibility { range: None, ..PLAUSIBILITY };
    after_ten_cycles(&NO_RANGE, |controller| {
        for cycle in 0..100 {
            reads(controller, 1e37 * (1.0 + 0.01 * cycle as f32)).expect("a number");
            sends(controller);
            assert!(position(controller).abs() < 1e3, "cycle {cycle}: {}", position(controller));
        }
    });
}

#[test]
fn a_reading_out_of_range_is_not_measured() {
    after_ten_cycles(&PLAUSIBILITY, |controller| {
        assert_eq!(reads(controller, 51.0), Err(RejectedFrame::Implausible));
        sends(controller);
        assert_eq!(controller.health(), Health::Degraded(Cause::Implausible(0)));
        assert_eq!(controller.estimator().standing().silent(), 1);
    });
}

#[test]
fn a_reading_that_stays_the_same_to_the_bit_is_told_and_left_out_only_if_the_design_says_so() {
    static REJECTING: Plausibility<f32, 1> = Plausibility { rejects_stuck: true, ..PLAUSIBILITY };
    for plausibility in [&PLAUSIBILITY, &REJECTING] {
        after_ten_cycles(plausibility, |controller| {
            for same in 0..8 {
                let taken = reads(controller, 0.01);
                let is_stuck = same >= 4;
                let refused = is_stuck && plausibility.rejects_stuck;
                assert_eq!(taken.is_err(), refused, "{same} times the same");
                sends(controller);
                if same < 8 {
                    assert_eq!(controller.health().cause() == Some(Cause::Stuck(0)), is_stuck, "{same}");
                }
            }
            reads(controller, 0.011).expect("it moves");
            sends(controller);
            assert_eq!(controller.health(), Health::Nominal);
        });
    }
}

#[test]
fn a_measurement_of_a_cycle_to_come_does_not_keep_a_sensor_stuck() {
    static REJECTING: Plausibility<f32, 1> = Plausibility { rejects_stuck: true, ..PLAUSIBILITY };
    after_ten_cycles(&REJECTING, |controller| {
        for _ in 0..6 {
            let _ = reads(controller, 0.01);
            sends(controller);
        }
        assert_eq!(controller.health().cause(), Some(Cause::Stuck(0)));
        let early = Measurement { tick: controller.tick() + 1000, output: SVector::from([0.01]) };
        assert!(controller.measured(&early).is_err());
        reads(controller, 0.011).expect("it moves again");
        sends(controller);
        assert_eq!(controller.health(), Health::Nominal);
    });
}

#[test]
fn a_design_with_a_gate_or_a_range_that_nothing_passes_is_refused() {
    static NO_GATE: Plausibility<f32, 1> = Plausibility { gate: Some(f32::NAN), ..PLAUSIBILITY };
    static EMPTY: Plausibility<f32, 1> = Plausibility { range: Some([[1.0, 1.0]]), ..PLAUSIBILITY };
    let workshop = workshop(DefaultInput::Zero);
    for plausibility in [&NO_GATE, &EMPTY] {
        let design = Design { plausibility, ..workshop.design() };
        let refused = lent::controller(design, Tick(0)).map(|_| ());
        assert_eq!(refused, Err(InvalidDesign::Plausibility));
    }
}

/// A loop that loses a packet in three and is acknowledged at once; what the controller holds to have been applied in each cycle,
/// and what was.
fn believed_and_applied(default_input: DefaultInput, rate: f32) -> Vec<(f32, f32)> {
    let bound = |value: f32| SVector::from([value]);
    let limits = Limits { min: bound(-3.0), max: bound(3.0), rate: Some(bound(rate)) };
    let settings = Settings { default_input, limits: Some(limits), safe: None };
    let workshop = double_integrator::Workshop::<f32>::double_integrator(settings);
    let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
    let mut actuator = lent::actuator(settings, Tick(0), double_integrator::LENGTH);
    let (mut buffer, mut state, mut coin) = ([0; 64], SVector::from([10.0, 0.0]), 1_u32);
    let mut last = None;
    let mut all = Vec::new();
    for _ in 0..300 {
        let measurement = Measurement { tick: controller.tick(), output: workshop.model.c * state };
        controller.measured(&measurement).expect("of use");
        let frame = controller.cycle(&mut buffer).expect("there is room").expect("finite");
        if let Some((tick, input)) = last {
            all.push((controller.expected_input(tick).expect("remembered")[0], input));
        }
        coin = coin.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // Now and then all are lost, until the buffer has run out.
        if (coin >> 16) % 3 > 0 && controller.tick().0 % 40 > 8 {
            actuator.receive(frame).expect("newer than the one before");
        }
        let applied = actuator.step();
        last = Some((applied.tick, applied.input[0]));
        controller.acknowledged(&actuator.acknowledgement(1).expect("it has played")).expect("it was sent");
        state = workshop.model.a * state + workshop.model.b * applied.input;
    }
    all
}

#[test]
fn an_input_changes_no_more_in_a_cycle_than_it_may_and_the_controller_knows_what_was_applied() {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        let all = believed_and_applied(default_input, 0.7);
        let mut before = 0.0;
        let mut at_the_rate = 0;
        for (cycle, (believed, applied)) in all.iter().enumerate() {
            assert_eq!(believed, applied, "{default_input:?}, cycle {cycle}");
            assert!((applied - before).abs() <= 0.7 + 1e-6, "{default_input:?}, cycle {cycle}");
            at_the_rate += usize::from((applied - before).abs() > 0.699);
            before = *applied;
        }
        assert!(at_the_rate > 10, "{default_input:?}: the rate counts in {at_the_rate} cycles");
    }
}

#[test]
fn an_actuator_whose_packets_fail_to_come_holds_and_then_applies_the_safe_input_within_its_limits() {
    let bound = |value: f32| SVector::from([value]);
    let safe = Safe { after: 5, input: bound(-3.0) };
    let settings = Settings {
        default_input: DefaultInput::Hold,
        limits: Some(Limits { min: bound(-2.0), max: bound(2.0), rate: None }),
        safe: Some(safe),
    };
    let mut actuator = lent::actuator(settings, Tick(0), 2);
    let inputs = [bound(1.0), bound(0.5)];
    actuator.offer(&ControlSequence { tick: Tick(0), inputs: &inputs }).expect("of use");
    let mut played = Vec::new();
    for _ in 0..9 {
        let applied = actuator.step();
        played.push((applied.input[0], actuator.health()));
    }
    let degraded = (0.5, Health::Degraded(Cause::RunOut));
    let lost = (-2.0, Health::Lost(Cause::RunOut));
    let expected = [(1.0, Health::Nominal), (0.5, Health::Nominal)];
    assert_eq!(played[..2], expected);
    assert_eq!(played[2..7], [degraded; 5]);
    assert_eq!(played[7..], [lost; 2]);

    actuator.offer(&ControlSequence { tick: Tick(9), inputs: &inputs }).expect("of use");
    let applied = actuator.step();
    assert_eq!((applied.input[0], applied.age, actuator.health()), (1.0, Age::Steps(0), Health::Nominal));
}
