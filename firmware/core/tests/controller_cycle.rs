//! One controller, cycle by cycle: what it counts, corrects, refuses and never sends.

mod by_hand;
mod double_integrator;
mod lent;

use by_hand::{acknowledge, cycle, measure, workshop};
use double_integrator::LENGTH;
use slqg::actuator::{Applied, Settings};
use slqg::controller::{Counts, Design, InvalidDesign, RejectedFrame};
use slqg::gains::{Gains, Tables};
use slqg::nalgebra::SVector;
use slqg::played::Played;
use slqg::wire::{self, EncodeError};
use slqg::{Age, DefaultInput, Tick};

#[test]
fn what_is_sent_is_the_law_for_the_acknowledged_age() {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        let workshop = workshop(default_input);
        let gains = workshop.design().gains;
        let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
        measure(&mut controller, 0, 1.0);
        let mut in_flight = lent::in_flight(LENGTH, LENGTH, Tick(0));
        let mut played = Played::nothing();
        let ages = [Some(0), Some(1), Some(0), Some(1), Some(2), Some(3), None, None, Some(1)];
        let ages = ages.map(|steps| steps.map_or(Age::Empty, Age::Steps));
        let mut applied = SVector::zeros();
        for (tick, age) in (0..).zip(ages) {
            let inputs: Vec<f32> = cycle(&mut controller);
            let expected = lent::expected(&in_flight, &gains, &played);
            let law = lent::sequence(&gains, controller.estimator().posterior_mean(), &expected);
            assert_eq!(inputs, law.iter().map(|input| input[0]).collect::<Vec<_>>(), "cycle {tick}");
            lent::push(&mut in_flight, Some(&law));
            acknowledge(&mut controller, tick, age).expect("of use");
            let input = in_flight.applied_input(default_input, Tick(tick), age, &applied);
            applied = input.expect("it was sent");
            played = Played::Known(age, applied);
        }
    }
}

#[test]
fn no_sequence_that_is_not_finite_is_sent() {
    let mut workshop = workshop(DefaultInput::Zero);
    workshop.model.initial_mean = SVector::from([f32::MAX, f32::MAX]);
    let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
    let mut actuator = lent::actuator(workshop.settings, Tick(0), LENGTH);
    let mut buffer = [0; 64];
    let mut withheld = 0;
    let mut last: Option<Applied<f32, 1>> = None;
    for _ in 0..50 {
        match controller.cycle(&mut buffer).expect("there is room") {
            Some(frame) => actuator.receive(frame).expect("finite"),
            None => withheld += 1,
        }
        if let Some(last) = last {
            assert_eq!(controller.expected_input(last.tick), Some(last.input));
        }
        let applied = actuator.step();
        assert!(applied.input[0].is_finite());
        acknowledge(&mut controller, applied.tick.0, applied.age).expect("of use");
        last = Some(applied);
    }
    assert!(withheld > 0);
    // A state that overflows is nothing that the estimate could go on from.
    let begun_anew = controller.counts().begun_anew;
    assert!(begun_anew > 0);
    assert_eq!(controller.counts(), Counts { not_finite: withheld, begun_anew, ..Counts::default() });
}

#[test]
fn a_buffer_that_is_too_small_costs_the_packet_and_nothing_else() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
    let mut short = [0; wire::control_len(1, LENGTH, 4) - 1];
    assert_eq!(controller.cycle(&mut short), Err(EncodeError::BufferTooSmall));
    assert_eq!(controller.tick(), Tick(1), "the cycle is over");
    let never_sent = acknowledge(&mut controller, 0, Age::Steps(0));
    assert_eq!(never_sent, Err(RejectedFrame::Acknowledgement));
    assert_eq!(cycle(&mut controller).len(), LENGTH);
}

#[test]
fn a_design_that_does_not_fit_is_refused() {
    let workshop = workshop(DefaultInput::Zero);
    let design = workshop.design();
    for arrives_at_once in [-0.1, 1.1, f32::NAN] {
        let unlikely = lent::controller(Design { arrives_at_once, ..design }, Tick(0));
        assert_eq!(unlikely.err(), Some(InvalidDesign::NotAProbability));
    }
    let hold = Settings { default_input: DefaultInput::Hold, ..design.actuator };
    let mixed = lent::controller(Design { actuator: hold, ..design }, Tick(0));
    assert_eq!(mixed.err(), Some(InvalidDesign::DefaultInput));
}

#[test]
fn gains_replaced_in_the_middle_decide_the_next_sequence() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a design that fits");
    cycle(&mut controller);
    let still = vec![0.0; LENGTH * 2];
    let (m, arrival) = (vec![0.0; LENGTH * (LENGTH - 1)], vec![0.0; LENGTH * (LENGTH - 1) / 2]);
    let tables = Tables::check(&still, &m, &arrival).expect("gains");
    let nothing =
        Gains::<f32, 2, 1>::check(LENGTH, DefaultInput::Zero, tables).expect("tables of the right shape");
    assert_eq!(controller.set_gains(nothing), Ok(()));
    assert!(cycle(&mut controller).iter().all(|input| *input == 0.0));
}

#[test]
fn gains_of_another_length_or_default_input_do_not_replace() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a design that fits");
    let tables = Tables::check(&[0.0; 4], &[0.0; 2], &[0.0; 1]).expect("gains");
    let shorter =
        Gains::<f32, 2, 1>::check(2, DefaultInput::Zero, tables).expect("tables of the right shape");
    assert_eq!(controller.set_gains(shorter), Err(InvalidDesign::Length));
    let holding = self::workshop(DefaultInput::Hold);
    assert_eq!(controller.set_gains(holding.design().gains), Err(InvalidDesign::DefaultInput));
}

#[test]
fn a_law_longer_than_a_frame_can_count_is_refused() {
    const LONG: usize = 256;
    let workshop = workshop(DefaultInput::Zero);
    let (lx, m) = (vec![0.0; LONG * 2], vec![0.0; LONG * (LONG - 1)]);
    let arrival = vec![0.0; LONG * (LONG - 1) / 2];
    let tables = Tables::check(&lx, &m, &arrival).expect("gains");
    let gains =
        Gains::<f32, 2, 1>::check(LONG, DefaultInput::Zero, tables).expect("tables of the right shape");
    let long = lent::controller(Design { gains, ..workshop.design() }, Tick(0));
    assert_eq!(long.err(), Some(InvalidDesign::Capacity));
}
