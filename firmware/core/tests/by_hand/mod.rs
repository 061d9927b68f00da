//! One controller, fed by hand.
#![allow(dead_code)]

use crate::double_integrator::{LENGTH, Node, Workshop};
use crate::lent;
use slqg::actuator::Settings;
use slqg::controller::RejectedFrame;
use slqg::nalgebra::SVector;
use slqg::wire::{self, Acknowledgement, Measurement};
use slqg::{Age, DefaultInput, Tick};

pub(crate) fn workshop(default_input: DefaultInput) -> Workshop<f32> {
    Workshop::double_integrator(Settings { default_input, limits: None, safe: None })
}

pub(crate) fn acknowledge(controller: &mut Node<'_, f32>, tick: u32, age: Age) -> Result<(), RejectedFrame> {
    let mut buffer = [0; 32];
    let acknowledgement = Acknowledgement::of(Tick(tick), age);
    let frame = wire::encode_acknowledgement::<f32>(&acknowledgement, &mut buffer).expect("there is room");
    controller.receive(frame)
}

pub(crate) fn measure(controller: &mut Node<'_, f32>, tick: u32, output: f32) {
    let mut buffer = [0; 32];
    let measurement = Measurement { tick: Tick(tick), output: SVector::from([output]) };
    let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
    controller.receive(frame).expect("of use");
}

/// Runs one cycle and returns the inputs sent.
pub(crate) fn cycle(controller: &mut Node<'_, f32>) -> Vec<f32> {
    let mut buffer = [0; 64];
    let frame = controller.cycle(&mut buffer).expect("there is room").expect("finite");
    let sequence = lent::decoded::<f32, 1>(frame, LENGTH).expect("a control frame");
    sequence.inputs.iter().map(|input| input[0]).collect()
}

/// A controller that has measured something and run cycles 0 to 4, with what it sent in each.
pub(crate) fn after_five_cycles(workshop: &Workshop<f32>) -> (Node<'_, f32>, Vec<Vec<f32>>) {
    let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
    measure(&mut controller, 0, 1.0);
    let sent = (0..5).map(|_| cycle(&mut controller)).collect();
    (controller, sent)
}

/// Hands over one frame that acknowledges cycle `tick` and those before it, newest first.
pub(crate) fn acknowledge_all(
    controller: &mut Node<'_, f32>,
    tick: u32,
    ages: &[Age],
) -> Result<(), RejectedFrame> {
    let mut buffer = [0; 32];
    let acknowledgement = Acknowledgement { tick: Tick(tick), ages: ages.iter().copied().collect() };
    let frame = wire::encode_acknowledgement::<f32>(&acknowledgement, &mut buffer).expect("there is room");
    controller.receive(frame)
}
