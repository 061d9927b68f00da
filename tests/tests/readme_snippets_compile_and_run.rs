//! The README's Rust snippets compile as they stand, and close a loop.
//!
//! `build.rs` takes them from the README, in their order there, and compiles the design that they call `motor`.

// Controller and actuator, with what the snippet imports.
include!(concat!(env!("OUT_DIR"), "/snippet_2.rs"));

use slqg::Tick;

/// The build script of a firmware.
#[allow(dead_code)]
mod build_script {
    include!(concat!(env!("OUT_DIR"), "/snippet_1.rs"));
}

const SNIPPETS: &str = "2";

#[test]
fn every_snippet_of_the_readme_is_compiled() {
    assert_eq!(
        env!("README_SNIPPETS"),
        SNIPPETS,
        "a snippet is in the README that this test does not include"
    );
}

#[test]
fn the_snippets_bring_the_plant_to_its_reference() {
    let (mut memory, mut of_actuator) = (motor::Memory::new(), motor::ACTUATOR_MEMORY);
    let controller = motor::Controller::new(motor::DESIGN, Tick(0), memory.lend());
    let mut controller = controller.expect("a design");
    let mut actuator = motor::Actuator::new(motor::ACTUATOR, Tick(0), &mut of_actuator);
    let mut state = motor::MODEL.initial_mean;
    let ahead = [Sample::repeat(1.0)];
    let (mut sequence, mut told) = (Vec::new(), Vec::new());
    for cycle in 0..400 {
        let measurement = wire::Measurement { tick: Tick(cycle), output: motor::MODEL.c * state };
        let mut buffer = [0; 64];
        let measured = wire::encode_measurement(&measurement, &mut buffer).expect("it fits");
        let came: Vec<&[u8]> = [measured, &told].into_iter().filter(|frame| !frame.is_empty()).collect();
        sequence.clear();
        control(&mut controller, &came, &ahead, |frame| sequence.extend_from_slice(frame));
        told.clear();
        let input = act(&mut actuator, &[&sequence], |frame| told.extend_from_slice(frame));
        state = motor::MODEL.a * state + motor::MODEL.b * slqg::nalgebra::SVector::from(input);
    }
    let position = (motor::MODEL.c * state)[0];
    assert!((position - 1.0).abs() < 1e-2, "{position}");
}
