//! Following a reference: what a reference does to a sequence, and where the plant goes.

mod double_integrator;
mod lent;

use double_integrator::{LENGTH, Node, WEIGHT, Workshop, at_fixed_point};
use slqg::actuator::Settings;
use slqg::controller::{Design, InvalidDesign};
use slqg::estimator::Merging;
use slqg::gains::{self, Gains};
use slqg::nalgebra::SVector;
use slqg::synthesis::{LinearCost, Stage};
use slqg::tracking::{Feedforward, Preview, RejectedReference, Tables};
use slqg::wire::{self, Acknowledgement, Measurement};
use slqg::{DefaultInput, Tick};

const BOTH: [DefaultInput; 2] = [DefaultInput::Zero, DefaultInput::Hold];
/// Samples of a preview that sees all that matters, and more samples than matter at all.
const SAMPLES: usize = 60;
const ALL: usize = 2000;

type Node64<'a> = Node<'a, f64>;
/// Position and velocity.
type Sample = SVector<f64, 2>;

/// The double integrator with preview gains over its whole state.
struct Bench {
    workshop: Workshop<f64>,
    default_input: DefaultInput,
    sequence: Vec<f64>,
    displaced: Vec<f64>,
}

impl Bench {
    fn new(default_input: DefaultInput) -> Self {
        let workshop = Workshop::double_integrator(Settings { default_input, limits: None, safe: None });
        let count = default_input.in_flight(LENGTH);
        let (mut sequence, mut displaced) = (vec![0.0; LENGTH * SAMPLES * 2], vec![0.0; count * SAMPLES * 2]);
        at_fixed_point(default_input, |synthesis, _| {
            for output in 0..2 {
                let mut workspace = vec![0.0; synthesis.dimensions().linear_workspace_len()];
                let mut linear = LinearCost::new(&synthesis.dimensions(), &mut workspace);
                linear.restart(&[WEIGHT[output], WEIGHT[2 + output]], 0.0);
                for ahead in 0..ALL {
                    linear.step_back(synthesis, Stage { state: &[0.0; 2], input: &[0.0], constant: 0.0 });
                    // The last sample takes the place of all that follow.
                    let column = ahead.min(SAMPLES - 1) * 2 + output;
                    for (table, gains) in
                        [(&mut sequence, linear.feedforward()), (&mut displaced, linear.displaced())]
                    {
                        for (row, gain) in gains.iter().enumerate() {
                            table[row * SAMPLES * 2 + column] += gain;
                        }
                    }
                }
            }
        });
        Self { workshop, default_input, sequence, displaced }
    }

    fn preview(&self) -> Preview<'_, f64, 1> {
        let tables = Tables::check(&self.sequence, &self.displaced).expect("finite");
        Preview::<f64, 1>::check(LENGTH, self.default_input, 2, SAMPLES, tables)
            .expect("tables of the right shape")
    }

    fn controller(&self) -> Node64<'_> {
        let design = Design { preview: Some(self.preview()), ..self.workshop.design() };
        lent::controller(design, Tick(0)).expect("a fitting design")
    }
}

/// Runs one cycle and returns the inputs sent.
fn cycle(controller: &mut Node64<'_>) -> Vec<f64> {
    let mut buffer = [0; 96];
    let frame = controller.cycle(&mut buffer).expect("there is room").expect("finite");
    let sequence = lent::decoded::<f64, 1>(frame, LENGTH).expect("a control frame");
    sequence.inputs.iter().map(|input| input[0]).collect()
}

fn measure(controller: &mut Node64<'_>, output: f64) {
    let mut buffer = [0; 32];
    let measurement = Measurement { tick: controller.tick(), output: SVector::from([output]) };
    let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
    controller.receive(frame).expect("of use");
}

/// Samples that go up and down.
fn wave(count: usize) -> Vec<Sample> {
    (0..count).map(|k| SVector::from([(k as f64 * 0.3).sin(), (k as f64 * 0.7).cos()])).collect()
}

#[test]
fn a_preview_for_another_law_is_refused() {
    let (bench, holding) = (Bench::new(DefaultInput::Zero), Bench::new(DefaultInput::Hold));
    let with = |preview| {
        lent::controller(Design { preview: Some(preview), ..bench.workshop.design() }, Tick(0)).err()
    };
    let tables = Tables::check(&[0.0; 3], &[]).expect("finite");
    let shorter =
        Preview::<f64, 1>::check(3, DefaultInput::Zero, 1, 1, tables).expect("tables of the right shape");
    assert_eq!(with(shorter), Some(InvalidDesign::Length));
    assert_eq!(with(holding.preview()), Some(InvalidDesign::DefaultInput));
    assert_eq!(with(bench.preview()), None);
}

#[test]
fn samples_beyond_the_preview_change_nothing() {
    let bench = Bench::new(DefaultInput::Hold);
    let mut other = wave(SAMPLES);
    let feedforward = |reference: &[Sample]| lent::feedforward(&bench.preview(), reference);
    let expected = feedforward(&other);
    other.extend(wave(10).iter().map(|sample| sample * 1e9));
    assert_eq!(feedforward(&other), expected);
    other[SAMPLES - 1] *= 2.0;
    assert_ne!(feedforward(&other), expected, "the last of the preview does");
}

#[test]
fn the_last_sample_stands_for_those_that_are_missing() {
    let bench = Bench::new(DefaultInput::Zero);
    let feedforward = |reference: &[Sample]| lent::feedforward(&bench.preview(), reference).expect("samples");
    let mut reference = wave(7);
    let expected = feedforward(&reference);
    reference.resize(SAMPLES, reference[6]);
    assert_eq!(feedforward(&reference), expected);
    let still = Sample::from([2.0, -1.0]);
    assert_eq!(feedforward(&[still]), feedforward(&[still; SAMPLES]));
}

#[test]
fn a_reference_that_is_refused_leaves_the_former_in_force() {
    let bench = Bench::new(DefaultInput::Zero);
    let (mut controller, mut other) = (bench.controller(), bench.controller());
    controller.follow(&wave(20)).expect("samples of the tracked outputs");
    other.follow(&wave(20)).expect("samples of the tracked outputs");
    assert_eq!(controller.follow(&[SVector::from([1.0])]), Err(RejectedReference::Dimension));
    assert_eq!(controller.follow(&[SVector::from([1.0; 3])]), Err(RejectedReference::Dimension));
    assert_eq!(controller.follow::<2>(&[]), Err(RejectedReference::NoSamples));
    for value in [f64::NAN, f64::INFINITY, f64::MAX] {
        let samples = [Sample::zeros(), SVector::from([value, -value])];
        assert_eq!(controller.follow(&samples), Err(RejectedReference::NotFinite));
    }
    let poison = Feedforward { displaced: &[SVector::from([f64::NAN])], ..Feedforward::NONE };
    assert_eq!(controller.set_feedforward(poison), Err(RejectedReference::NotFinite));
    for _ in 0..3 {
        assert_eq!(cycle(&mut controller), cycle(&mut other));
    }
}

#[test]
fn a_controller_without_preview_follows_nothing() {
    let bench = Bench::new(DefaultInput::Zero);
    let mut controller = lent::controller(bench.workshop.design(), Tick(0)).expect("a fitting design");
    assert_eq!(controller.follow(&wave(3)), Err(RejectedReference::NoPreview));
    assert_eq!(cycle(&mut controller), [0.0; LENGTH]);
}

#[test]
fn a_reference_of_zero_changes_no_bit_of_what_is_sent() {
    for default_input in BOTH {
        let bench = Bench::new(default_input);
        let mut plain = lent::controller(bench.workshop.design(), Tick(0)).expect("a fitting design");
        let (mut never, mut zero) = (bench.controller(), bench.controller());
        zero.follow(&[Sample::zeros(); 3]).expect("samples of the tracked outputs");
        for k in 0..50 {
            for controller in [&mut plain, &mut never, &mut zero] {
                measure(controller, (f64::from(k) * 0.4).sin());
            }
            let bits = |controller| cycle(controller).iter().map(|input| input.to_bits()).collect::<Vec<_>>();
            let expected = bits(&mut plain);
            assert_eq!(bits(&mut never), expected, "cycle {k}");
            assert_eq!(bits(&mut zero), expected, "cycle {k}");
        }
    }
}

/// Hands over a feedforward with a number for each input of a sequence.
fn feed_forward(controller: &mut Node64<'_>, numbers: [f64; LENGTH]) {
    let inputs = numbers.map(|number| SVector::from([number]));
    controller.set_feedforward(Feedforward { inputs: &inputs, ..Feedforward::NONE }).expect("finite");
}

#[test]
fn what_is_sent_is_the_law_plus_the_feedforward() {
    let bench = Bench::new(DefaultInput::Zero);
    let (mut plain, mut controller) =
        (lent::controller(bench.workshop.design(), Tick(0)).expect("a fitting design"), bench.controller());
    measure(&mut plain, 1.0);
    measure(&mut controller, 1.0);
    let (expected, _) =
        lent::feedforward(&bench.preview(), &wave(9)).expect("samples of the tracked outputs");
    controller.follow(&wave(9)).expect("samples of the tracked outputs");
    let law = cycle(&mut plain);
    for ((sent, law), feedforward) in cycle(&mut controller).iter().zip(law).zip(&expected) {
        assert_eq!(*sent, law + feedforward[0]);
    }
}

#[test]
fn a_task_brings_gains_and_feedforward_for_each_cycle() {
    let bench = Bench::new(DefaultInput::Zero);
    // No preview: what is added was computed beforehand.
    let mut controller = lent::controller(bench.workshop.design(), Tick(0)).expect("a fitting design");
    let numbers = [0.0; LENGTH * LENGTH];
    let nothing =
        gains::Tables::check(&numbers[..LENGTH * 2], &numbers[..LENGTH * (LENGTH - 1)], &numbers[..6])
            .expect("gains");
    let nothing =
        Gains::<f64, 2, 1>::check(LENGTH, DefaultInput::Zero, nothing).expect("tables of the right shape");
    measure(&mut controller, 1.0);
    feed_forward(&mut controller, [1.0, 2.0, 3.0, 4.0]);
    controller.set_gains(nothing).expect("the same length");
    assert_eq!(cycle(&mut controller), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(cycle(&mut controller), [1.0, 2.0, 3.0, 4.0], "it stays until the next");
    assert_eq!(controller.follow(&wave(3)), Err(RejectedReference::NoPreview));
    assert_eq!(cycle(&mut controller), [1.0, 2.0, 3.0, 4.0], "and if another is refused");
    feed_forward(&mut controller, [-1.0; LENGTH]);
    assert_eq!(cycle(&mut controller), [-1.0; LENGTH]);
}

/// Where the plant goes without noise, if no packet is ever late, and what the way costs; `known` gives what is handed over
/// in cycle `k`.
fn drive(bench: &Bench, reference: &[Sample], known: impl Fn(usize) -> Vec<Sample>) -> (Vec<Sample>, f64) {
    let mut controller = bench.controller();
    let mut actuator = lent::actuator(bench.workshop.settings, Tick(0), LENGTH);
    let (mut state, mut states, mut cost) = (Sample::zeros(), vec![], 0.0);
    let mut buffer = [0; 96];
    for (k, wanted) in reference.iter().enumerate() {
        measure(&mut controller, state[0]);
        controller.follow(&known(k)).expect("samples of the tracked outputs");
        let frame = controller.cycle(&mut buffer).expect("there is room").expect("finite");
        actuator.receive(frame).expect("newer than the last");
        let applied = actuator.step();
        let acknowledgement = Acknowledgement::of(applied.tick, applied.age);
        let frame =
            wire::encode_acknowledgement::<f64>(&acknowledgement, &mut buffer).expect("there is room");
        controller.receive(frame).expect("of use");
        let off = state - wanted;
        cost += WEIGHT[0] * off[0] * off[0] + WEIGHT[3] * off[1] * off[1];
        states.push(state);
        state = bench.workshop.model.a * state + bench.workshop.model.b * applied.input;
    }
    (states, cost)
}

#[test]
fn the_feedforward_takes_the_plant_to_its_set_point() {
    for default_input in BOTH {
        let set_point = Sample::from([3.0, 0.0]);
        let bench = Bench::new(default_input);
        let (states, _) = drive(&bench, &[set_point; 300], |_| vec![set_point]);
        assert!((states[299] - set_point).amax() < 1e-6, "{}", states[299]);
    }
}

#[test]
fn a_step_that_is_known_ahead_costs_less_than_one_that_is_not() {
    for default_input in BOTH {
        let bench = Bench::new(default_input);
        let reference: Vec<_> =
            (0..300).map(|k| Sample::from([if k < 100 { 0.0 } else { 1.0 }, 0.0])).collect();
        let ahead = |k: usize| (k + 1..=k + SAMPLES).map(|at| reference[at.min(299)]).collect();
        let (foreseen, less) = drive(&bench, &reference, ahead);
        let (surprised, more) = drive(&bench, &reference, |k| vec![reference[k]]);
        assert!(less < 0.6 * more, "{less} and {more}");
        assert!(foreseen[100][0] > 0.2, "it has set off before the step: {}", foreseen[100][0]);
        assert_eq!(surprised[100][0], 0.0);
    }
}

#[test]
fn a_set_point_is_reached_without_any_acknowledgement() {
    for default_input in BOTH {
        let bench = Bench::new(default_input);
        for merging in [Merging::Single, Merging::Imm, Merging::Gpb2] {
            let design = Design { preview: Some(bench.preview()), merging, ..bench.workshop.design() };
            let mut controller = lent::controller(design, Tick(0)).expect("a fitting design");
            controller.follow(&[Sample::from([2.0, 0.0])]).expect("samples of the tracked outputs");
            let mut actuator = lent::actuator(bench.workshop.settings, Tick(0), LENGTH);
            let model = &bench.workshop.model;
            let mut state = SVector::from([0.0, 0.0]);
            let mut buffer = [0; 96];
            for cycle in 0..300 {
                let measurement = Measurement { tick: Tick(cycle), output: model.c * state };
                let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
                controller.receive(frame).expect("of use");
                let frame = controller.cycle(&mut buffer).expect("there is room").expect("finite");
                // Two packets in three are lost.
                if cycle % 3 == 1 {
                    actuator.receive(frame).expect("newer than the last");
                }
                state = model.a * state + model.b * actuator.step().input;
            }
            assert!((state[0] - 2.0).abs() < 0.01, "{state} with {merging:?}");
            assert_eq!(controller.counts().unacknowledged, 299);
        }
    }
}
