//! A bit that flips in a table is found within one round of the check, and no other cycle is disturbed by it.

use slqg::actuator::{Limits, Safe, Settings};
use slqg::blob::{DesignId, Shape, encode, encoded_len};
use slqg::checked::NonNegative;
use slqg::controller::Design;
use slqg::estimator::Plausibility;
use slqg::event::{self, TableLengths, Trigger};
use slqg::gains::{Gains, Tables};
use slqg::health::Cause;
use slqg::nalgebra::SVector;
use slqg::tracking::{self, Preview};
use slqg::wire::can::Grid;
use slqg::{DefaultInput, Health, Tick};

mod double_integrator;
mod lent;
use double_integrator::{LENGTH, Workshop};

const LOST: Health = Health::Lost(Cause::Memory);

/// Numbers of a design with everything that one can have, each to be changed by one bit.
struct Numbers {
    tables: [Vec<f64>; 8],
    workshop: Workshop<f64>,
    plausibility: Plausibility<f64, 1>,
    grid: Grid<f64, 1>,
}

fn numbers() -> Numbers {
    let one = SVector::from([1.0]);
    let settings = Settings {
        default_input: DefaultInput::Zero,
        limits: Some(Limits { min: -one, max: one, rate: Some(one * 0.5) }),
        safe: Some(Safe { after: 5, input: one * 0.25 }),
    };
    let lengths = TableLengths::of(LENGTH, DefaultInput::Zero, 2, 1);
    let table = |length: usize| (0..length).map(|place| 0.5 / (1 + place) as f64).collect::<Vec<_>>();
    Numbers {
        tables: [
            table(2 * LENGTH),
            table(LENGTH * (LENGTH - 1)),
            table(LENGTH * (LENGTH - 1) / 2),
            table(LENGTH * 3),
            table((LENGTH - 1) * 3),
            table(lengths.state),
            table(lengths.in_flight),
            table(lengths.sequence),
        ],
        workshop: Workshop::double_integrator(settings),
        plausibility: Plausibility {
            gate: Some(100.0),
            doubt_after: 4,
            range: Some([[-8.0, 8.0]]),
            stuck_after: [9],
            rejects_stuck: true,
            stale_after: 20,
            lost_after: 200,
        },
        grid: Grid { step: one / 4096.0, largest_count: 8192 },
    }
}

impl Numbers {
    fn design(&self) -> Design<'_, f64, 2, 1, 1> {
        let [lx, m, arrival, sequence, displaced, state, in_flight, of_sequence] = &self.tables;
        let gains = Tables::check(lx, m, arrival).expect("gains");
        let preview = tracking::Tables::check(sequence, displaced).expect("finite");
        let trigger = event::Tables::check(state, in_flight, of_sequence).expect("finite");
        let cost = NonNegative::<f64>::new(0.125);
        Design {
            gains: Gains::check(LENGTH, DefaultInput::Zero, gains).expect("they fit"),
            preview: Some(Preview::check(LENGTH, DefaultInput::Zero, 1, 3, preview).expect("they fit")),
            trigger: Some(Trigger::check(LENGTH, DefaultInput::Zero, cost, trigger).expect("they fit")),
            plausibility: &self.plausibility,
            grid: Some(self.grid),
            ..self.workshop.design()
        }
    }

    /// Every number that is not in a table of the law, of the preview or of the trigger.
    fn others(&mut self) -> Vec<&mut f64> {
        let Self { workshop: Workshop { model, settings, .. }, plausibility, grid, .. } = self;
        let limits = settings.limits.as_mut().expect("there are limits");
        let safe = settings.safe.as_mut().expect("there is a safe input");
        let matrices = [model.a.as_mut_slice(), model.b.as_mut_slice(), model.c.as_mut_slice()];
        let noises = [model.process_noise.as_mut_slice(), model.measurement_noise.as_mut_slice()];
        let start = [model.initial_mean.as_mut_slice(), model.initial_covariance.as_mut_slice()];
        let bounds = [&mut limits.min, &mut limits.max, limits.rate.as_mut().expect("there is a rate")];
        let range = plausibility.range.as_mut().expect("there is a range").as_flattened_mut();
        let all = matrices.into_iter().chain(noises).chain(start).chain([range]).flatten();
        let all = all.chain(bounds.into_iter().flatten()).chain(&mut safe.input).chain(&mut grid.step);
        all.chain(&mut plausibility.gate).collect()
    }
}

/// How a controller of this design is after one round, a few numbers a call, where `expected` is what it should be made of.
fn after_one_round(numbers: &Numbers, expected: &Numbers) -> Health {
    let expected = [expected.design().checksums()];
    let mut controller = lent::controller(numbers.design(), Tick(0)).expect("a fitting design");
    let mut calls = 0;
    while !controller.check_memory(&expected, 7) {
        calls += 1;
        assert!(calls < 100, "the round does not end");
    }
    let is_silent = controller.cycle(&mut [0; 128]).expect("there is room").is_none();
    assert_eq!(is_silent, controller.health().is_lost());
    controller.health()
}

#[test]
fn a_bit_in_any_number_of_the_design_is_found_within_one_round() {
    let right = numbers();
    // The trigger would withhold the sequence of a loop at rest.
    let mut right = Numbers { ..right };
    right.workshop.model.initial_mean.fill(4.0);
    assert!(!after_one_round(&right, &right).is_lost());
    // Of each: the sign, two bits of the exponent, and the last one.
    let changes = [0, 1, 40, 52]
        .map(|bit| move |number: &mut f64| *number = f64::from_bits(number.to_bits() ^ 1 << bit));
    let mut changed = 0;
    for change in changes {
        for table in 0..right.tables.len() {
            for place in 0..right.tables[table].len() {
                let mut wrong = numbers();
                wrong.workshop.model.initial_mean.fill(4.0);
                change(&mut wrong.tables[table][place]);
                if wrong.tables[2].iter().all(|probability| (0.0..=1.0).contains(probability)) {
                    assert_eq!(after_one_round(&wrong, &right), LOST, "table {table}, number {place}");
                    changed += 1;
                }
            }
        }
        let count = numbers().others().len();
        for place in 0..count {
            let mut wrong = numbers();
            wrong.workshop.model.initial_mean.fill(4.0);
            change(wrong.others()[place]);
            assert_eq!(after_one_round(&wrong, &right), LOST, "number {place} beside the tables");
            changed += 1;
        }
    }
    assert!(changed > 300, "{changed}");
}

#[test]
fn settings_that_are_no_numbers_are_found_as_well() {
    let right = numbers();
    let expected = [right.design().checksums()];
    let found = |design: Design<'_, f64, 2, 1, 1>| {
        let mut controller = lent::controller(design, Tick(0)).expect("a fitting design");
        while !controller.check_memory(&expected, usize::MAX) {}
        controller.health()
    };
    let design = right.design();
    assert!(!found(design).is_lost());
    assert_eq!(found(Design { measurement_buffer: design.measurement_buffer ^ 1, ..design }), LOST);
    assert_eq!(found(Design { acknowledgement_buffer: design.acknowledgement_buffer ^ 2, ..design }), LOST);
    assert_eq!(found(Design { arrives_at_once: design.arrives_at_once / 2.0, ..design }), LOST);
    assert_eq!(found(Design { trigger: None, ..design }), LOST);
    assert_eq!(found(Design { preview: None, trigger: None, ..design }), LOST);
    assert_eq!(found(Design { grid: None, ..design }), LOST);
    for change in [
        |plausibility: &mut Plausibility<f64, 1>| plausibility.doubt_after ^= 4,
        |plausibility: &mut Plausibility<f64, 1>| plausibility.stuck_after[0] ^= 16,
        |plausibility: &mut Plausibility<f64, 1>| plausibility.rejects_stuck = false,
        |plausibility: &mut Plausibility<f64, 1>| plausibility.stale_after ^= 1,
        |plausibility: &mut Plausibility<f64, 1>| plausibility.lost_after ^= 64,
        |plausibility: &mut Plausibility<f64, 1>| plausibility.gate = None,
        |plausibility: &mut Plausibility<f64, 1>| plausibility.range = None,
    ] {
        let mut plausibility = right.plausibility;
        change(&mut plausibility);
        assert_eq!(found(Design { plausibility: &plausibility, ..design }), LOST);
    }
}

#[test]
fn a_law_that_is_set_later_is_no_fault_and_the_rest_is_checked_on() {
    let right = numbers();
    let expected = [right.design().checksums()];
    let mut controller = lent::controller(right.design(), Tick(0)).expect("a fitting design");
    let mut other = numbers();
    other.tables[0][0] = 0.75;
    controller.set_gains(other.design().gains).expect("they fit");
    while !controller.check_memory(&expected, 5) {}
    assert!(!controller.health().is_lost());
    let mut wrong = numbers();
    wrong.workshop.model.a[0] = 2.0;
    let mut controller = lent::controller(wrong.design(), Tick(0)).expect("a fitting design");
    controller.set_gains(other.design().gains).expect("they fit");
    while !controller.check_memory(&expected, 5) {}
    assert_eq!(controller.health(), LOST);
}

#[test]
fn a_controller_that_was_lost_to_a_fault_stays_lost_when_it_is_restarted() {
    let right = numbers();
    let mut controller = lent::controller(right.design(), Tick(0)).expect("a fitting design");
    controller.report_memory_fault();
    controller.restart(right.design(), Tick(9)).expect("a fitting design");
    assert_eq!(controller.health(), LOST);
    assert!(controller.cycle(&mut [0; 128]).expect("there is room").is_none());
}

/// A law of this gain and its blob.
fn blob(gain: f32) -> Vec<u8> {
    let shape = Shape { length: LENGTH, states: 2, inputs: 1, default_input: DefaultInput::Zero };
    let (lx, m) = (vec![gain; 2 * LENGTH], vec![gain; LENGTH * (LENGTH - 1)]);
    let arrival = vec![0.5; LENGTH * (LENGTH - 1) / 2];
    let tables = Tables::check(&lx, &m, &arrival).expect("gains");
    let mut buffer = vec![0; encoded_len(&shape, 4)];
    encode::<f32>(DesignId(7), &shape, &tables, &mut buffer).expect("gains").to_vec()
}

#[test]
fn gains_that_are_replaced_while_they_are_checked_are_no_fault_in_a_hundred_thousand_cycles() {
    let settings = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
    let workshop = Workshop::<f32>::double_integrator(settings);
    let expected = [workshop.design().checksums()];
    let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
    let mut bank = lent::bank::<f32, 2, 1>(LENGTH, DefaultInput::Zero);
    let (mut rounds, mut replaced) = (0, 0);
    for cycle in 0..100_000_u32 {
        // Of all lengths up to some rounds, in parts that are written while the check is under way.
        match cycle % 41 {
            7 => bank.load(&blob(-0.001 * (cycle % 97) as f32), DesignId(7), 0.5).expect("gains"),
            19 => bank.spare()[..5].fill(0.125),
            20 => {
                bank.spare().fill(0.25);
                bank.switch(0.75).expect("gains");
                replaced += 1;
            }
            33 if cycle % 3 == 0 => bank.withdraw(),
            _ => (),
        }
        let mut buffer = [0; 64];
        match bank.law() {
            Some(law) => controller.cycle_under(&law, &mut buffer).map(drop).expect("it fits"),
            None => controller.cycle(&mut buffer).map(drop).expect("there is room"),
        }
        assert!(bank.check_memory(3), "cycle {cycle}");
        rounds += u32::from(controller.check_memory(&expected, 3));
        assert!(!controller.health().is_lost(), "cycle {cycle}");
    }
    assert!(rounds > 1000 && replaced > 1000, "{rounds} rounds, {replaced} laws");
}
