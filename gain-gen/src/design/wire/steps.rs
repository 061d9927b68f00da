//! What a count of one stands for on classic CAN: a limit divided by the counts that a frame has room for.

use super::{ValueLimits, WireSettings};
use crate::design::{Design, DeviceScalar};
use slqg::nalgebra::Vector1;
use slqg::wire::can::{Grid, LARGEST_COUNT, largest_count};

/// What counts of one stand for.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    /// Of inputs, whose frames have as many values as a sequence.
    pub inputs: Counted,
    /// Of outputs.
    pub outputs: Counted,
}

/// Values that are counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Counted {
    /// What a count of one stands for, for each value in its unit; as the device's scalar has it.
    pub steps: Vec<f64>,
    /// The largest count of all of them.
    pub largest_count: i16,
}

impl Design {
    /// What counts of one stand for; `None` where values are not counted. Frames that are full have coarser steps, so the
    /// sequence length counts, too.
    pub fn steps(&self) -> Option<Steps> {
        let WireSettings::CanClassic(ValueLimits { inputs, outputs }) = &self.wire else { return None };
        let scalar = self.controller.scalar;
        let counted = |limits: &[f64], values| {
            let largest_count = largest_count(values);
            let steps = limits.iter().map(|&limit| step(limit, largest_count, scalar)).collect();
            Counted { steps, largest_count }
        };
        let in_sequence = self.plant.inputs() * self.controller.sequence_length;
        Some(Steps { inputs: counted(inputs, in_sequence), outputs: counted(outputs, self.plant.outputs()) })
    }
}

/// The step that divides `limit` into counts, rounded as the device rounds.
fn step(limit: f64, largest_count: i16, scalar: DeviceScalar) -> f64 {
    match scalar {
        DeviceScalar::F32 => f64::from(limit as f32 / f32::from(largest_count)),
        DeviceScalar::F64 => limit / f64::from(largest_count),
    }
}

/// Whether the finest step of a limit can be computed with; then the coarser ones can, too.
pub(super) fn is_valid(limit: f64, scalar: DeviceScalar) -> bool {
    let (step, largest_count) = (step(limit, LARGEST_COUNT, scalar), LARGEST_COUNT);
    match scalar {
        DeviceScalar::F32 => Grid { step: Vector1::new(step as f32), largest_count }.is_valid(),
        DeviceScalar::F64 => Grid { step: Vector1::new(step), largest_count }.is_valid(),
    }
}
