//! One controller, cycle by cycle: what it counts, corrects, refuses and never sends.

mod double_integrator;

use double_integrator::{LATE, LENGTH, Node, Workshop};
use slqg::actuator::{Actuator, Age, Settings};
use slqg::controller::{Controller, Counts, Design, InvalidDesign, RejectedFrame};
use slqg::gains::{Gains, Tables};
use slqg::in_flight::InFlight;
use slqg::nalgebra::SVector;
use slqg::wire::{self, Acknowledgement, EncodeError, Measurement};
use slqg::{DefaultInput, Tick, sequence::ControlSequence};

fn workshop(default_input: DefaultInput) -> Workshop<f32> {
    Workshop::double_integrator(Settings { default_input, limits: None })
}

fn acknowledge(controller: &mut Node<'_, f32>, tick: u32, age: Age) -> Result<(), RejectedFrame> {
    let mut buffer = [0; 32];
    let acknowledgement = Acknowledgement { tick: Tick(tick), age };
    let frame = wire::encode_acknowledgement::<f32>(&acknowledgement, &mut buffer).expect("there is room");
    controller.receive(frame)
}

fn measure(controller: &mut Node<'_, f32>, tick: u32, output: f32) {
    let mut buffer = [0; 32];
    let measurement = Measurement { tick: Tick(tick), output: SVector::from([output]) };
    let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
    controller.receive(frame).expect("of use");
}

/// Runs one cycle and returns the inputs sent.
fn cycle(controller: &mut Node<'_, f32>) -> Vec<f32> {
    let mut buffer = [0; 64];
    let frame = controller.cycle(&mut buffer).expect("there is room").expect("finite");
    let sequence = wire::decode_control::<f32, 1, 6>(frame).expect("a control frame");
    sequence.inputs.iter().map(|input| input[0]).collect()
}

/// A controller that has measured something and run cycles 0 to 4, with what it sent in each.
fn after_five_cycles(workshop: &Workshop<f32>) -> (Node<'_, f32>, Vec<Vec<f32>>) {
    let mut controller = Node::new(workshop.design(), Tick(0)).expect("a fitting design");
    measure(&mut controller, 0, 1.0);
    let sent = (0..5).map(|_| cycle(&mut controller)).collect();
    (controller, sent)
}

fn inputs_believed(controller: &Node<'_, f32>) -> Vec<f32> {
    (0..5).map(|tick| controller.estimator().input(Tick(tick)).expect("remembered")[0]).collect()
}

#[test]
fn a_missing_acknowledgement_is_counted_once_for_its_cycle() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = Node::new(workshop.design(), Tick(0)).expect("a fitting design");
    cycle(&mut controller);
    assert_eq!(
        controller.counts(),
        Counts::default(),
        "before the first cycle there is nothing to acknowledge"
    );
    acknowledge(&mut controller, 0, Age::Steps(0)).expect("of use");
    cycle(&mut controller);
    cycle(&mut controller);
    acknowledge(&mut controller, 1, Age::Steps(0)).expect("late, but of use");
    cycle(&mut controller);
    assert_eq!(controller.counts(), Counts { unacknowledged: 2, ..Counts::default() });
}

#[test]
fn without_acknowledgement_no_new_packet_is_held_to_have_arrived() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = Node::new(workshop.design(), Tick(0)).expect("a fitting design");
    measure(&mut controller, 0, 1.0);
    let sent = cycle(&mut controller);
    acknowledge(&mut controller, 0, Age::Steps(0)).expect("of use");
    (0..5).for_each(|_| drop(cycle(&mut controller)));
    assert_eq!(inputs_believed(&controller), [sent[0], sent[1], sent[2], sent[3], 0.0]);
}

#[test]
fn a_late_acknowledgement_corrects_its_cycle_and_those_that_played_on() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut controller, sent) = after_five_cycles(&workshop);
    assert_eq!(inputs_believed(&controller), [0.0; 5]);
    acknowledge(&mut controller, 3, Age::Steps(0)).expect("late, but of use");
    acknowledge(&mut controller, 1, Age::Steps(1)).expect("late, but of use");
    assert_eq!(inputs_believed(&controller), [0.0, sent[0][1], sent[0][2], sent[3][0], sent[3][1]]);
}

#[test]
fn a_late_acknowledgement_corrects_what_is_held_after_it() {
    let workshop = workshop(DefaultInput::Hold);
    let (mut controller, sent) = after_five_cycles(&workshop);
    acknowledge(&mut controller, 4, Age::Empty).expect("of use");
    acknowledge(&mut controller, 3, Age::Steps(3)).expect("late, but of use");
    assert_eq!(inputs_believed(&controller), [0.0, 0.0, 0.0, sent[0][3], sent[0][3]]);
}

#[test]
fn an_acknowledgement_is_of_use_as_long_as_the_estimator_remembers_its_cycle() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut controller, sent) = after_five_cycles(&workshop);
    cycle(&mut controller);
    for _ in 0..3 {
        cycle(&mut controller);
    }
    // Now is cycle 9: the oldest remembered is 3, in which the sequence of cycle 0 still had an input.
    acknowledge(&mut controller, 3, Age::Steps(3)).expect("late, but of use");
    assert_eq!(controller.estimator().input(Tick(3)).expect("remembered")[0], sent[0][3]);
    assert_eq!(acknowledge(&mut controller, 2, Age::Steps(1)), Err(RejectedFrame::Acknowledgement));
}

#[test]
fn what_is_sent_is_the_law_for_the_acknowledged_age() {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        let workshop = workshop(default_input);
        let gains = workshop.design().gains;
        let mut controller = Node::new(workshop.design(), Tick(0)).expect("a fitting design");
        measure(&mut controller, 0, 1.0);
        let mut in_flight = InFlight::<f32, 1, 6, 1>::default();
        let ages = [Some(0), Some(1), Some(0), Some(1), Some(2), Some(3), None, None, Some(1)];
        let ages = ages.map(|steps| steps.map_or(Age::Empty, Age::Steps));
        for (tick, age) in (0..).zip(ages) {
            let inputs: Vec<f32> = cycle(&mut controller);
            let law = gains
                .sequence::<6>(controller.estimator().posterior_mean(), &in_flight.expected_inputs(&gains));
            assert_eq!(inputs, law.iter().map(|input| input[0]).collect::<Vec<_>>(), "cycle {tick}");
            in_flight.push(Some(ControlSequence { tick: Tick(tick), inputs: law }));
            acknowledge(&mut controller, tick, age).expect("of use");
            in_flight.acknowledge(age, *controller.estimator().input(Tick(tick)).expect("remembered"));
        }
    }
}

#[test]
fn a_repeated_acknowledgement_changes_nothing() {
    let workshop = workshop(DefaultInput::Hold);
    let (mut controller, _) = after_five_cycles(&workshop);
    acknowledge(&mut controller, 3, Age::Steps(1)).expect("of use");
    let before = format!("{controller:?}");
    acknowledge(&mut controller, 3, Age::Steps(1)).expect("of use");
    assert_eq!(format!("{controller:?}"), before);
}

#[test]
fn an_acknowledgement_that_cannot_be_true_is_rejected() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut controller, _) = after_five_cycles(&workshop);
    let rejected = Err(RejectedFrame::Acknowledgement);
    assert_eq!(acknowledge(&mut controller, 5, Age::Empty), rejected, "not over");
    assert_eq!(acknowledge(&mut controller, 2, Age::Steps(3)), rejected, "before the first sequence");
    assert_eq!(acknowledge(&mut controller, 4, Age::Steps(LENGTH as u8)), rejected, "run out by then");
    assert_eq!(acknowledge(&mut controller, u32::MAX, Age::Empty), rejected, "before the first cycle");
    assert_eq!(controller.counts().rejected_frames, 4);
    assert_eq!(inputs_believed(&controller), [0.0; 5]);
}

#[test]
fn no_sequence_that_is_not_finite_is_sent() {
    let mut workshop = workshop(DefaultInput::Zero);
    workshop.model.initial_mean = SVector::from([f32::MAX, f32::MAX]);
    let mut controller = Node::new(workshop.design(), Tick(0)).expect("a fitting design");
    let mut actuator = Actuator::<f32, 1, 6>::new(workshop.settings, Tick(0));
    let mut buffer = [0; 64];
    let mut withheld = 0;
    for _ in 0..50 {
        match controller.cycle(&mut buffer).expect("there is room") {
            Some(frame) => actuator.receive(frame).expect("finite"),
            None => withheld += 1,
        }
        let applied = actuator.step();
        assert!(applied.input[0].is_finite());
        let _ = acknowledge(&mut controller, applied.tick.0, applied.age);
        assert_eq!(controller.estimator().input(applied.tick), Some(&applied.input));
    }
    assert!(withheld > 0);
    assert_eq!(controller.counts(), Counts { not_finite: withheld, ..Counts::default() });
}

#[test]
fn a_buffer_that_is_too_small_costs_the_packet_and_nothing_else() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = Node::new(workshop.design(), Tick(0)).expect("a fitting design");
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
    let short = Controller::<f32, 2, 1, 1, 3, 8>::new(design, Tick(0));
    assert_eq!(short.err(), Some(InvalidDesign::Capacity));
    let exact = Controller::<f32, 2, 1, 1, 4, 8>::new(design, Tick(0));
    assert_eq!(exact.err(), None);
    let forgetful = Controller::<f32, 2, 1, 1, 4, LATE>::new(design, Tick(0));
    assert_eq!(forgetful.err(), Some(InvalidDesign::MeasurementBuffer));
    let hold = Settings { default_input: DefaultInput::Hold, ..design.actuator };
    let mixed = Node::new(Design { actuator: hold, ..design }, Tick(0));
    assert_eq!(mixed.err(), Some(InvalidDesign::DefaultInput));
}

#[test]
fn gains_replaced_in_the_middle_decide_the_next_sequence() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = Node::new(workshop.design(), Tick(0)).expect("a design that fits");
    cycle(&mut controller);
    let still = vec![0.0; LENGTH * 2];
    let (m, arrival) = (vec![0.0; LENGTH * (LENGTH - 1)], vec![0.0; LENGTH * (LENGTH - 1) / 2]);
    let tables = Tables { lx: &still, m: &m, arrival: &arrival };
    let nothing =
        Gains::<f32, 2, 1>::check(LENGTH, DefaultInput::Zero, tables).expect("tables of the right shape");
    assert_eq!(controller.set_gains(nothing), Ok(()));
    assert!(cycle(&mut controller).iter().all(|input| *input == 0.0));
}

#[test]
fn gains_of_another_length_or_default_input_do_not_replace() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = Node::new(workshop.design(), Tick(0)).expect("a design that fits");
    let tables = Tables { lx: &[0.0; 4], m: &[0.0; 2], arrival: &[0.0; 1] };
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
    let tables = Tables { lx: &lx, m: &m, arrival: &arrival };
    let gains =
        Gains::<f32, 2, 1>::check(LONG, DefaultInput::Zero, tables).expect("tables of the right shape");
    let long = Controller::<f32, 2, 1, 1, LONG, 8>::new(Design { gains, ..workshop.design() }, Tick(0));
    assert_eq!(long.err(), Some(InvalidDesign::Capacity));
}
