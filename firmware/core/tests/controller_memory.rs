//! The memory that a controller is lent: how much it takes, that what was in it before does not matter, and that it may be
//! used again.

#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod exercise;
mod lent;

use double_integrator::{LATE, LENGTH, Node, Workshop};
use exercise::Exercise;
use slqg::actuator::{Limits, Settings};
use slqg::controller::{Controller, Design, InvalidDesign, Memory, Sizes};
use slqg::estimator::Merging;
use slqg::nalgebra::SVector;
use slqg::{DefaultInput, Tick};
use std::sync::Mutex;

const MERGINGS: [Merging; 3] = [Merging::Single, Merging::Imm, Merging::Gpb2];
const CYCLES: usize = 60;
const START: Tick = Tick(u32::MAX - 20);

fn workshop(default_input: DefaultInput) -> Workshop<f32> {
    let limits = Some(Limits { min: SVector::from([-0.8]), max: SVector::from([0.8]), rate: None });
    Workshop::double_integrator(Settings { default_input, limits, safe: None })
}

/// Calls `check` with every design there is.
fn every_design(check: impl Fn(Design<'_, f32, 2, 1, 1>)) {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        for merging in MERGINGS {
            check(Design { merging, ..workshop(default_input).design() });
        }
    }
}

#[test]
fn a_design_that_needs_more_memory_than_is_lent_is_refused_and_says_how_much() {
    every_design(|design| {
        let needed = design.sizes();
        let refused = |sizes| Controller::new(design, START, lent::memory(sizes)).err();
        assert_eq!(refused(needed), None);
        for short in [
            Sizes { cycles: needed.cycles - 1, ..needed },
            Sizes { estimates: needed.estimates - 1, ..needed },
            Sizes { ages: needed.ages - 1, ..needed },
            Sizes { sent: needed.sent - 1, ..needed },
            Sizes { inputs: needed.inputs - 1, ..needed },
            Sizes { cycles: 0, estimates: 0, ages: 0, sent: 0, inputs: 0 },
        ] {
            assert_eq!(refused(short), Some(InvalidDesign::Memory(needed)), "{short:?}");
        }
    });
}

#[test]
fn a_design_that_remembers_longer_needs_more_memory_than_another() {
    let workshop = workshop(DefaultInput::Zero);
    let design = workshop.design();
    let small = design.sizes();
    for design in [
        Design { measurement_buffer: LATE + 1, ..design },
        Design { acknowledgement_buffer: LATE + 1, ..design },
        Design { merging: Merging::Imm, ..design },
    ] {
        let outcome = Controller::new(design, START, lent::memory(small)).err();
        assert_eq!(outcome, Some(InvalidDesign::Memory(design.sizes())));
    }
    for shorter in
        [Design { measurement_buffer: 0, ..design }, Design { measurement_buffer: LATE - 1, ..design }]
    {
        assert!(Controller::new(shorter, START, lent::memory(small)).is_ok());
    }
}

#[test]
fn more_memory_than_there_can_be_is_refused_and_nothing_overflows() {
    let workshop = workshop(DefaultInput::Zero);
    for (measurement_buffer, acknowledgement_buffer) in
        [(usize::MAX, 1), (1, usize::MAX), (usize::MAX / 2, 1)]
    {
        for merging in MERGINGS {
            let design = Design { measurement_buffer, acknowledgement_buffer, merging, ..workshop.design() };
            let outcome = Controller::new(design, START, lent::memory(workshop.design().sizes())).err();
            assert_eq!(outcome, Some(InvalidDesign::Memory(design.sizes())));
        }
    }
}

/// What a controller in this memory does.
fn run(
    design: Design<'_, f32, 2, 1, 1>,
    memory: Memory<'_, f32, 2, 1, 1>,
) -> Vec<(Option<Vec<u8>>, Vec<u64>)> {
    let mut controller = Controller::new(design, START, memory).expect("memory enough");
    Exercise::new(design, START, 1).run(&mut controller, CYCLES)
}

#[test]
fn what_the_memory_held_before_and_how_much_more_there_is_changes_no_bit() {
    slqg::controller_memory!(struct Clean: f32, 2, 1, 1; Sizes::of(LENGTH, LATE + 1, LENGTH + 1));
    // Made at compile time, as for a device.
    static CLEAN: Mutex<Clean> = Mutex::new(Clean::new());
    every_design(|design| {
        let mut clean = CLEAN.lock().expect("no other test has it");
        let expected = run(design, clean.lend());
        assert!(run(design, lent::memory(design.sizes())) == expected, "rubbish");
        assert!(run(design, clean.lend()) == expected, "used before");
        let mut other = Controller::new(Design { measurement_buffer: 2, ..design }, Tick(7), clean.lend());
        Exercise::new(design, Tick(7), 5).run(other.as_mut().expect("memory enough"), 13);
        assert!(run(design, clean.lend()) == expected, "used by another");
        let needed = design.sizes();
        let more = Sizes {
            cycles: needed.cycles + 5,
            estimates: needed.estimates + 7,
            ages: needed.ages + 11,
            sent: needed.sent + 3,
            inputs: needed.inputs + 13,
        };
        assert!(run(design, lent::memory(more)) == expected, "more than it takes");
    });
}

#[test]
fn a_controller_that_is_restarted_is_a_new_one_in_the_same_memory_to_the_bit() {
    every_design(|design| {
        let expected = run(design, lent::memory(design.sizes()));
        let mut controller = lent::controller(design, Tick(100)).expect("a fitting design");
        for cycles in [0, 1, 17, CYCLES] {
            controller.round_age(true);
            controller.receive(&[]).expect_err("no frame");
            Exercise::new(design, controller.tick(), 2).run(&mut controller, cycles);
            // In the middle of a cycle.
            controller.propose();
            controller.restart(design, START).expect("the same design");
            let found = Exercise::new(design, START, 1).run(&mut controller, CYCLES);
            assert!(found == expected, "after {cycles} cycles");
        }
    });
}

#[test]
fn a_controller_is_not_restarted_with_a_design_that_takes_other_memory_and_goes_on() {
    let workshop = workshop(DefaultInput::Hold);
    let design = workshop.design();
    let (mut controller, mut untouched) = (
        lent::controller(design, START).expect("it fits"),
        lent::controller(design, START).expect("it fits"),
    );
    let (mut first, mut second) = (Exercise::new(design, START, 3), Exercise::new(design, START, 3));
    let mut both = |controller: &mut Node<'_, f32>| {
        assert!(first.run(controller, 10) == second.run(&mut untouched, 10));
    };
    both(&mut controller);
    let longer = Design { measurement_buffer: LATE + 1, ..design };
    assert_eq!(controller.restart(longer, Tick(0)), Err(InvalidDesign::Memory(longer.sizes())));
    let unlikely = Design { arrives_at_once: 2.0, ..design };
    assert_eq!(controller.restart(unlikely, Tick(0)), Err(InvalidDesign::NotAProbability));
    both(&mut controller);
}
