//! What a reference and an event trigger add to generated source is compiled and run: feedforward and worth of a packet are
//! those of the library with the same tables, to the bit, and the library's in `f64` but for rounding.

use gain_gen::design::Design;
use gain_gen::report::Report;
use gain_gen::solve::Method;
use slqg::checked::NonNegative;
use slqg::event::{self, Candidate, Trigger};
use slqg::nalgebra::{DMatrix, SVector};
use slqg::played::Played;
use slqg::tracking::Preview;
use slqg::{Age, DefaultInput, Scalar, Tick, gains, gains::Gains, wire};
use std::path::Path;

mod draws;
mod lent;

use draws::Draws;

/// Two inputs, two tracked outputs, hold, an event trigger, `f32`.
#[allow(dead_code, unreachable_pub)]
mod lift {
    include!("generated/lift.rs");
}

/// A set point, zero, no trigger, `f64`.
#[allow(dead_code, unreachable_pub)]
mod hoist {
    include!("generated/hoist.rs");
}

const DRAWS: usize = 500;
/// Cycles of the link before what is in flight is looked at.
const CYCLES: u32 = 6;

fn report(name: &str) -> Report {
    let design = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    Report::new(&Design::load(&design).unwrap(), Method::InFlight)
}

fn rounded<T: Scalar>(matrix: &DMatrix<f64>) -> Vec<T> {
    nearest(matrix.transpose().as_slice())
}

fn nearest<T: Scalar>(values: &[f64]) -> Vec<T> {
    values.iter().map(|&value| T::nearest(value)).collect()
}

/// Feedforward for a random reference of up to six samples, and what it would be worth to send then, for a random state and
/// random packets in flight, some of which were not sent.
fn drawn<T: Scalar>(
    seed: u64,
    gains: &Gains<'_, T, 2, 2>,
    preview: &Preview<'_, T, 2>,
    trigger: &Trigger<'_, T, 2, 2>,
) -> (Vec<SVector<T, 2>>, T) {
    let mut draws = Draws(seed);
    let reference: Vec<SVector<T, 2>> = (0..1 + draws.below(6)).map(|_| draws.vector()).collect();
    let (mut forward, mut displaced) = ([SVector::zeros(); 3], [SVector::zeros(); 3]);
    let feedforward =
        preview.fill_feedforward(&reference, &mut forward, &mut displaced).expect("a reference");
    let sequences = (0..CYCLES).map(|_| {
        let inputs: Vec<_> = (0..3).map(|_| draws.vector()).collect();
        (draws.below(3) > 0).then_some(inputs)
    });
    let in_flight = lent::sent(3, sequences.collect::<Vec<_>>());
    let age = if draws.below(4) == 0 { Age::Empty } else { Age::Steps(draws.below(3) as u8) };
    let played = Played::Known(age, draws.vector());
    let state: SVector<T, 2> = draws.vector();
    let (mut room, mut inputs) = ([SVector::zeros(); 3], [SVector::zeros(); 3]);
    let expected = in_flight.fill_expected(gains, &played, &mut room);
    gains.fill_sequence(&state, expected, &mut inputs);
    inputs.iter_mut().zip(feedforward.inputs).for_each(|(input, forward)| *input += forward);
    let candidate = Candidate {
        posterior_mean: &state,
        expected,
        inputs: &inputs,
        displaced: feedforward.displaced,
        played,
    };
    let benefit = trigger.benefit(gains, &in_flight, &candidate, &mut [SVector::zeros(); 3], &mut []);
    (feedforward.inputs.iter().chain(feedforward.displaced).copied().collect(), benefit)
}

#[test]
fn generated_feedforward_and_worth_are_the_librarys_to_the_bit() {
    let report = report("lift.toml");
    let (law, found) = (&report.solution.law, report.preview.as_ref().unwrap().as_ref().unwrap());
    let tables = report.trigger.as_ref().unwrap();
    let hold = DefaultInput::Hold;

    let (lx, m, arrival) = (rounded(&law.lx), rounded(&law.m), nearest(&law.arrival));
    let gains = Gains::<f32, 2, 2>::check(3, hold, gains::Tables::check(&lx, &m, &arrival).unwrap()).unwrap();
    let (sequence, displaced) = (rounded(&found.sequence), rounded(&found.displaced));
    let of_preview = slqg::tracking::Tables::check(&sequence, &displaced).unwrap();
    let preview = Preview::<f32, 2>::check(3, hold, 2, found.samples, of_preview).unwrap();
    let (state, in_flight, sequence) =
        (nearest(&tables.state), nearest(&tables.in_flight), nearest(&tables.sequence));
    let of_trigger = event::Tables::check(&state, &in_flight, &sequence).unwrap();
    let trigger = Trigger::<f32, 2, 2>::check(3, hold, NonNegative::<f32>::new(3.0), of_trigger).unwrap();
    assert_eq!((lift::PREVIEW, lift::TRIGGER), (preview, trigger));

    let (lx, m) = (rounded(&law.lx), rounded(&law.m));
    let exact_gains =
        Gains::<f64, 2, 2>::check(3, hold, gains::Tables::check(&lx, &m, &law.arrival).unwrap()).unwrap();
    let (sequence, displaced) = (rounded(&found.sequence), rounded(&found.displaced));
    let of_preview = slqg::tracking::Tables::check(&sequence, &displaced).unwrap();
    let exact_preview = Preview::<f64, 2>::check(3, hold, 2, found.samples, of_preview).unwrap();
    let exact_trigger =
        Trigger::<f64, 2, 2>::check(3, hold, NonNegative::<f64>::new(3.0), tables.as_tables().unwrap())
            .unwrap();

    let (mut sent, mut kept) = (0, 0);
    for seed in 0..DRAWS as u64 {
        let (feedforward, benefit) = drawn(seed, &lift::GAINS, &lift::PREVIEW, &lift::TRIGGER);
        let (again, worth) = drawn(seed, &gains, &preview, &trigger);
        assert_eq!((&feedforward, benefit.to_bits()), (&again, worth.to_bits()), "draw {seed}");
        let (exact, worth) = drawn(seed, &exact_gains, &exact_preview, &exact_trigger);
        for (found, exact) in feedforward.iter().zip(&exact) {
            assert!((found.cast::<f64>() - exact).amax() < 1e-6, "draw {seed}: {found} {exact}");
        }
        assert!(
            (f64::from(benefit) - worth).abs() < 1e-5 * worth.abs().max(1.0),
            "draw {seed}: {benefit} {worth}"
        );
        if lift::TRIGGER.is_worth_sending(benefit) { sent += 1 } else { kept += 1 }
    }
    assert!(sent > DRAWS / 10 && kept > DRAWS / 10, "{sent} sent, {kept} not: half a test");
}

#[test]
fn a_generated_controller_sends_once_the_reference_makes_it_worth_a_packet() {
    let mut memory = lift::Memory::new();
    let mut controller =
        lift::Controller::new(lift::DESIGN, Tick(0), memory.lend()).expect("a design that fits");
    let mut buffer = [0; 128];
    assert_eq!(controller.cycle(&mut buffer), Ok(None), "all is where it is to be");
    assert_eq!(controller.counts().not_worth_sending, 1);
    let reference = [SVector::from([3.0, 0.0]); lift::PREVIEW_SAMPLES];
    controller.follow(&reference).expect("two tracked outputs");
    assert!(controller.cycle(&mut buffer).expect("room").is_some());
    assert_eq!(controller.counts().not_worth_sending, 1);
}

#[test]
fn a_generated_controller_is_told_its_set_point_once() {
    let mut memory = hoist::Memory::new();
    let mut controller =
        hoist::Controller::new(hoist::DESIGN, Tick(0), memory.lend()).expect("a design that fits");
    controller.follow(&[hoist::SET_POINT]).expect("one tracked output");
    assert_eq!(hoist::SET_POINT.as_slice(), [1.5]);
    let mut room = [SVector::zeros(); 3];
    let feedforward = hoist::PREVIEW.fill_feedforward(&[hoist::SET_POINT], &mut room, &mut []).unwrap();
    assert!(feedforward.inputs[0][0] > 0.0);
    let mut buffer = [0; 64];
    let frame = controller.cycle(&mut buffer).expect("room").expect("a finite sequence");
    let mut decoded = [SVector::<f64, 1>::zeros(); 3];
    let sequence = wire::decode_control(frame, &mut decoded).expect("a control frame");
    // At the start the state is held to be zero, and nothing is in flight.
    assert_eq!(sequence.inputs, feedforward.inputs);
    assert!(feedforward.displaced.is_empty() && hoist::DESIGN.trigger.is_none());
}
