//! A task's generated source is compiled and run: its laws are those of the finite-horizon recursion, cycle by cycle, and
//! the core's controller takes them one after the other, with the feedforward where it follows a reference.

use gain_gen::{
    design::Design,
    emit::{Format, emit},
    report::Report,
    solve::{LoopProblem, Method, finite_horizon},
};
use slqg::{
    Tick,
    nalgebra::{DVector, SVector},
    wire,
};
use std::path::{Path, PathBuf};

/// `critical` with sequences of two inputs, with which no loop is stable for ever.
#[allow(dead_code, unreachable_pub)]
mod task {
    include!("generated/critical_task.rs");
}

/// `hoist`, on its way to a set point.
#[allow(dead_code, unreachable_pub)]
mod tracking_task {
    include!("generated/hoist_task.rs");
}

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(name)
}

fn hoist() -> Report {
    let design = Design::load(&path("data/hoist.toml")).expect("a design");
    let mut report = Report::new(&design, Method::InFlight);
    report.find_task(tracking_task::CYCLES).expect("a set point is known beforehand");
    report
}

fn design() -> Design {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs/critical.toml");
    let mut design = Design::load(&path).expect("a design");
    design.set_sequence_length(task::SEQUENCE_LENGTH);
    design
}

#[test]
fn the_committed_tasks_are_what_the_generator_writes_today() {
    let mut report = Report::new(&design(), Method::InFlight);
    report.find_task(task::CYCLES).expect("no reference to know, and no trigger");
    for (report, origin, name, options) in [
        (report, "critical.toml", "critical_task", "designs/critical.toml --sequence-length 2 --horizon 8"),
        (hoist(), "hoist.toml", "hoist_task", "gain-gen/tests/data/hoist.toml --horizon 4"),
    ] {
        let source = emit(&report.emission().expect("a task"), origin, Format::Rust).expect("a source");
        let committed =
            std::fs::read_to_string(path(&format!("generated/{name}.rs"))).expect("the committed source");
        assert!(
            source == committed,
            "regenerate: cargo run -p gain-gen -- emit {options} --to rust --output gain-gen/tests/generated/{name}.rs"
        );
    }
}

#[test]
fn each_cycle_has_the_law_of_the_finite_horizon_recursion() {
    let design = design();
    let problem = LoopProblem::of(&design);
    let expected = finite_horizon(&problem, &design.cost.terminal, task::CYCLES);
    for (law, reference) in task::HORIZON.iter().zip(&expected.laws) {
        for unit in 0..task::STATES + law.in_flight() {
            let state = SVector::from_fn(|row, _| if row == unit { 1.0 } else { 0.0 });
            let sent = [SVector::from([if unit >= task::STATES { 1.0 } else { 0.0 }])];
            let mut sequence = [SVector::zeros(); 2];
            law.fill_sequence(&state, &sent, &mut sequence);
            let column = if unit < task::STATES { reference.lx.column(unit) } else { reference.m.column(0) };
            let rounded = DVector::from_iterator(2, column.iter().map(|&gain| gain as f32));
            assert!(sequence.iter().zip(rounded.iter()).all(|(found, gain)| found[0] == *gain));
        }
    }
}

#[test]
fn a_controller_takes_the_laws_one_after_the_other() {
    let mut memory = task::Memory::new();
    let mut controller =
        task::Controller::new(task::DESIGN, Tick(0), memory.lend()).expect("a design that fits");
    let mut buffer = [0; 64];
    let mut first_inputs = Vec::new();
    for law in task::HORIZON {
        controller.set_gains(law).expect("laws of one length");
        let frame = controller.cycle(&mut buffer).expect("room").expect("a finite sequence");
        let mut room = [SVector::<f32, 1>::zeros(); 2];
        let sequence = wire::decode_control(frame, &mut room).expect("a control frame");
        first_inputs.push(sequence.inputs[0][0]);
    }
    assert_eq!(first_inputs.len(), task::CYCLES);
    assert!(first_inputs[0] < 0.0, "the plant starts at 10, 10");
    // In the last cycle only the weight of the next state is left; in the second input of a sequence nothing is.
    let last = task::HORIZON[task::CYCLES - 1];
    let mut at_the_end = [SVector::zeros(); 2];
    last.fill_sequence(&SVector::from([1.0, 1.0]), &[SVector::from([1.0])], &mut at_the_end);
    assert_eq!(at_the_end[1][0], 0.0);
}

#[test]
fn a_controller_takes_the_feedforward_cycle_by_cycle() {
    let report = hoist();
    let expected = &report.task.as_ref().expect("a task").tracked.as_ref().expect("a set point").feedforward;
    let mut memory = tracking_task::Memory::new();
    let mut controller = tracking_task::Controller::new(tracking_task::DESIGN, Tick(0), memory.lend())
        .expect("a design that fits");
    let mut buffer = [0; 64];
    for (cycle, inputs) in expected.iter().enumerate() {
        let law = tracking_task::HORIZON[cycle];
        let feedforward = &tracking_task::FEEDFORWARD[cycle];
        assert!(feedforward.iter().eq(inputs.iter()), "cycle {cycle}");
        controller.set_gains(law).expect("laws of one length");
        controller.set_feedforward_rows(feedforward).expect("finite");
        let frame = controller.cycle(&mut buffer).expect("room").expect("a finite sequence");
        let mut room = [SVector::<f64, 1>::zeros(); 3];
        let sequence = wire::decode_control(frame, &mut room).expect("a control frame");
        if cycle == 0 {
            // The state is held to be zero, and nothing is in flight.
            assert!(sequence.inputs.iter().flat_map(|input| input.iter()).eq(inputs.iter()));
        }
    }
    assert_eq!(expected.len(), tracking_task::CYCLES);
}
