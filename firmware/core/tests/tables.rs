//! Tables of event triggers and previews: their size and order, and that nothing else is taken for them.

mod double_integrator;
mod lent;

use double_integrator::{LENGTH, Workshop};
use slqg::actuator::Settings;
use slqg::checked::{Finite, NonNegative};
use slqg::controller::{Design, InvalidDesign};
use slqg::event::{InvalidTrigger, TableLengths, Tables, Trigger, packed_index};
use slqg::tracking::{self, InvalidPreview, Preview};
use slqg::{DefaultInput, Tick};

#[test]
fn upper_triangles_are_dense_and_in_row_order() {
    for size in 0..7 {
        let mut next = 0;
        for row in 0..size {
            for column in row..size {
                assert_eq!(packed_index(size, row, column), next);
                next += 1;
            }
        }
        assert_eq!(next, TableLengths::packed(size));
    }
}

#[test]
fn a_trigger_takes_about_a_sixth_of_the_cube_of_the_length() {
    // Four states, one input, sequences of four: 32 numbers in all.
    let lengths = TableLengths::of(4, DefaultInput::Zero, 4, 1);
    assert_eq!(lengths, TableLengths { state: 12, in_flight: 6 + 3 + 1, sequence: 10 });
    let lengths = TableLengths::of(4, DefaultInput::Hold, 4, 1);
    assert_eq!(lengths, TableLengths { state: 16, in_flight: 10 + 6 + 3 + 1, sequence: 10 });
    for length in 1..20 {
        let lengths = TableLengths::of(length, DefaultInput::Zero, 4, 1);
        assert_eq!(lengths.in_flight, (length.pow(3) - length) / 6);
    }
    let two = TableLengths::of(3, DefaultInput::Zero, 2, 2);
    assert_eq!(two, TableLengths { state: 8, in_flight: 10 + 3, sequence: 21 });
}

#[test]
fn absurd_dimensions_have_a_size_too() {
    let most = TableLengths::of(usize::MAX, DefaultInput::Zero, usize::MAX, usize::MAX);
    assert!(most.state == usize::MAX && most.in_flight == usize::MAX && most.sequence > usize::MAX / 4);
    assert_eq!(TableLengths::of(usize::MAX, DefaultInput::Zero, 2, 0).in_flight, 0);
    assert_eq!(
        TableLengths::of(0, DefaultInput::Hold, 2, 1),
        TableLengths { state: 0, in_flight: 0, sequence: 0 }
    );
}

const ONE: NonNegative<f32> = NonNegative::<f32>::new(1.0);
const GOOD: Tables<'static, f32> = Tables {
    state: Finite::<f32>::new(&[0.0; 2]),
    in_flight: Finite::<f32>::new(&[0.0; 1]),
    sequence: Finite::<f32>::new(&[0.0; 3]),
};

fn check(tables: Tables<'_, f32>) -> Option<InvalidTrigger> {
    Trigger::<f32, 2, 1>::check(2, DefaultInput::Zero, ONE, tables).err()
}

#[test]
fn a_table_of_another_length_is_refused() {
    assert_eq!(check(GOOD), None);
    let wrong = Some(InvalidTrigger::TableLength);
    for values in [Finite::NONE, Finite::<f32>::new(&[0.0; 4])] {
        assert_eq!(check(Tables { state: values, ..GOOD }), wrong);
        assert_eq!(check(Tables { in_flight: values, ..GOOD }), wrong);
        assert_eq!(check(Tables { sequence: values, ..GOOD }), wrong);
    }
    assert_eq!(Trigger::<f32, 2, 1>::check(2, DefaultInput::Hold, ONE, GOOD).err(), wrong);
    assert_eq!(Trigger::<f32, 2, 1>::check(3, DefaultInput::Zero, ONE, GOOD).err(), wrong);
    assert_eq!(Trigger::<f32, 3, 1>::check(2, DefaultInput::Zero, ONE, GOOD).err(), wrong);
}

#[test]
fn numbers_that_are_not_finite_and_costs_below_zero_are_refused() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(Tables::check(&[0.0, value], &[0.0], &[0.0; 3]), Err(InvalidTrigger::NotFinite));
        assert_eq!(Tables::check(&[0.0; 2], &[value], &[0.0; 3]), Err(InvalidTrigger::NotFinite));
        assert_eq!(Tables::check(&[0.0; 2], &[0.0], &[0.0, value, 0.0]), Err(InvalidTrigger::NotFinite));
    }
    assert_eq!(Tables::check(&[0.0; 2], &[0.0], &[0.0; 3]), Ok(GOOD));
    assert_eq!(NonNegative::check(-1.0_f32), None);
    assert_eq!(NonNegative::check(f32::NAN), None);
    assert!(NonNegative::check(f32::INFINITY).is_some(), "never sending is a choice");
    assert_eq!(
        NonNegative::check(0.0_f32).map(|cost| cost.number()),
        Some(0.0),
        "nor is a free packet an error"
    );
}

/// A trigger that fits the double integrator, and numbers enough for it.
fn fitting(default_input: DefaultInput, numbers: &[f32]) -> Trigger<'_, f32, 2, 1> {
    let lengths = TableLengths::of(LENGTH, default_input, 2, 1);
    let tables =
        Tables::check(&numbers[..lengths.state], &numbers[..lengths.in_flight], &numbers[..lengths.sequence]);
    Trigger::<f32, 2, 1>::check(LENGTH, default_input, ONE, tables.expect("finite"))
        .expect("tables of the right shape")
}

#[test]
fn a_trigger_for_another_law_is_refused_at_the_start_and_later() {
    let numbers = [0.0; 100];
    let workshop = Workshop::<f32>::double_integrator(Settings {
        default_input: DefaultInput::Zero,
        limits: None,
        safe: None,
    });
    let trigger = fitting(DefaultInput::Zero, &numbers);
    let mut controller = lent::controller(Design { trigger: Some(trigger), ..workshop.design() }, Tick(0))
        .expect("a fitting design");
    let shorter =
        Trigger::<f32, 2, 1>::check(2, DefaultInput::Zero, ONE, GOOD).expect("tables of the right shape");
    let holding = fitting(DefaultInput::Hold, &numbers);
    for (trigger, why) in [(shorter, InvalidDesign::Length), (holding, InvalidDesign::DefaultInput)] {
        let design = Design { trigger: Some(trigger), ..workshop.design() };
        assert_eq!(lent::controller(design, Tick(0)).err(), Some(why));
        assert_eq!(controller.set_trigger(Some(trigger)), Err(why));
    }
}

#[test]
fn a_trigger_beside_a_preview_that_tells_nothing_of_what_is_in_flight_is_refused() {
    let numbers = [0.0; 100];
    let workshop = Workshop::<f32>::double_integrator(Settings {
        default_input: DefaultInput::Zero,
        limits: None,
        safe: None,
    });
    let trigger = Some(fitting(DefaultInput::Zero, &numbers));
    let preview = |displaced| {
        let tables = tracking::Tables::check(&numbers[..LENGTH], displaced).expect("finite");
        Some(
            Preview::<f32, 1>::check(LENGTH, DefaultInput::Zero, 1, 1, tables)
                .expect("tables of the right shape"),
        )
    };
    let silent = Design { preview: preview(&[]), ..workshop.design() };
    assert_eq!(lent::controller(Design { trigger, ..silent }, Tick(0)).err(), Some(InvalidDesign::Preview));
    let mut controller = lent::controller(silent, Tick(0)).expect("without a trigger it need not tell");
    assert_eq!(controller.set_trigger(trigger), Err(InvalidDesign::Preview));
    let telling = Design { preview: preview(&numbers[..LENGTH - 1]), ..workshop.design() };
    assert_eq!(lent::controller(Design { trigger, ..telling }, Tick(0)).err(), None);
}

#[test]
fn preview_tables_of_a_wrong_size_are_refused_by_name() {
    // Two inputs, sequences of three, two outputs, four samples: 6 x 8 and 4 x 8 entries.
    let values = [0.0_f32; 60];
    let check = |length, default_input, outputs, samples, sequence: usize, displaced: usize| {
        let tables = tracking::Tables::check(&values[..sequence], &values[..displaced]).expect("finite");
        Preview::<f32, 2>::check(length, default_input, outputs, samples, tables).err()
    };
    let (zero, hold) = (DefaultInput::Zero, DefaultInput::Hold);
    assert_eq!(check(3, zero, 2, 4, 48, 32), None);
    assert_eq!(check(3, zero, 2, 4, 48, 0), None, "only a trigger needs the other table");
    assert_eq!(check(3, hold, 2, 4, 48, 48), None);
    assert_eq!(check(3, zero, 0, 4, 48, 32), Some(InvalidPreview::Empty));
    assert_eq!(check(3, zero, 2, 0, 48, 32), Some(InvalidPreview::Empty));
    for (length, outputs, samples, sequence) in [(2, 2, 4, 48), (3, 1, 4, 48), (3, 2, 3, 48), (3, 2, 4, 47)] {
        assert_eq!(check(length, zero, outputs, samples, sequence, 32), Some(InvalidPreview::SequenceLength));
    }
    assert_eq!(check(3, zero, usize::MAX, usize::MAX, 48, 32), Some(InvalidPreview::SequenceLength));
    for displaced in [1, 31, 33, 48] {
        assert_eq!(check(3, zero, 2, 4, 48, displaced), Some(InvalidPreview::DisplacedLength));
    }
    assert_eq!(check(3, hold, 2, 4, 48, 32), Some(InvalidPreview::DisplacedLength));
}

#[test]
fn numbers_that_are_no_gains_are_refused() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (good, bad) = ([0.0; 2], [0.0, value]);
        assert!(tracking::Tables::check(&good, &good[..1]).is_ok());
        for (sequence, displaced) in [(&bad[..], &good[..1]), (&good, &bad[1..])] {
            assert_eq!(tracking::Tables::check(sequence, displaced), Err(InvalidPreview::NotFinite));
        }
    }
}
