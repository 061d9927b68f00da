//! The section on frames: how long they are on the bus, and what is lost where values are counted.

use super::super::Report;
use super::super::figure::{figure, percent};
use super::super::rounding::deviation;
use super::line;
use crate::design::{Authentication, FrameBytes, Steps, WireSettings};
use core::fmt::{self, Formatter};

impl Report {
    /// Nothing where full frames travel as they are.
    pub(super) fn wire(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (wire, authentication) = (&self.design.wire, self.design.authentication);
        if *wire == WireSettings::Bytes && authentication == Authentication::None {
            return Ok(());
        }
        writeln!(f, "\nWire: {}", wire.name())?;
        if authentication != Authentication::None {
            let bytes = authentication.bytes();
            let told = format!("{:<12}a tag and its head, {bytes} bytes a frame", authentication.name());
            line(f, "authentication", told)?;
        }
        if *wire == WireSettings::Bytes {
            return Ok(());
        }
        if let Some(misfit) = self.design.misfit() {
            return line(f, "does not fit", misfit);
        }
        let full = self.design.frame_bytes();
        let FrameBytes { measurement, control, acknowledgement } =
            self.design.carried_bytes().unwrap_or(full);
        let told = |carried: usize, full: usize| {
            format!("{:<12}bytes in a CAN frame, for a frame of {full}", carried)
        };
        line(f, "measurement", told(measurement, full.measurement))?;
        line(f, "control", told(control, full.control))?;
        if let (Some(carried), Some(full)) = (acknowledgement, full.acknowledgement) {
            line(f, "acknowledgement", told(carried, full))?;
        }
        self.design.steps().map_or(Ok(()), |steps| self.rounding(f, &steps))
    }

    fn rounding(&self, f: &mut Formatter<'_>, steps: &Steps) -> fmt::Result {
        let error = |step: f64| {
            format!("step {}, standard deviation of its error {}", figure(step), figure(deviation(step)))
        };
        for (at, &step) in (1..).zip(&steps.inputs.steps) {
            line(f, &format!("input u{at}"), error(step))?;
        }
        let noise = self.design.plant.measurement_noise.diagonal();
        for ((at, &step), variance) in (1..).zip(&steps.outputs.steps).zip(noise.iter()) {
            let share = percent(deviation(step) / variance.sqrt());
            line(f, &format!("output y{at}"), format!("{}, {share} of the sensor's", error(step)))?;
        }
        let Some(cost) = self.rounding_cost() else { return Ok(()) };
        let share = percent(cost / self.control_cost());
        line(
            f,
            "rounding of inputs",
            format!("{:<12}per step, estimated: {share} of the cost with the state known", figure(cost)),
        )
    }
}
