//! `[wire]`: what carries the nodes' frames, and in what steps values are counted where they are.
//!
//! Whether the design's frames fit their carrier is in `fit`; the bytes themselves are [`slqg::wire`]'s.

mod fit;

use super::document::{Field, Section, counted};
use super::{Acknowledgement, ControllerSettings, Design, DesignError, DeviceScalar, Network, Plant};
use slqg::nalgebra::Vector1;
use slqg::wire::can::{Grid, LARGEST_COUNT, MOST_CYCLES};

pub use fit::{FrameBytes, Misfit};

/// What carries the frames of the loop.
#[derive(Debug, Clone, PartialEq)]
pub enum WireSettings {
    /// Anything that carries bytes: full frames.
    Bytes,
    /// Full frames, each in one CAN FD frame.
    CanFd,
    /// Compact frames, each in one classic CAN frame.
    CanClassic(Steps),
}

/// What a count of one stands for. The largest count is 32767 for all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    /// For each input, in its unit; as the device's scalar has it.
    pub inputs: Vec<f64>,
    /// For each output likewise.
    pub outputs: Vec<f64>,
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Bytes,
    CanFd,
    CanClassic,
}

impl WireSettings {
    /// As in the design file.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Bytes => "bytes",
            Self::CanFd => "can-fd",
            Self::CanClassic(_) => "can-classic",
        }
    }

    /// The steps, where values are counted.
    pub const fn steps(&self) -> Option<&Steps> {
        match self {
            Self::CanClassic(steps) => Some(steps),
            Self::Bytes | Self::CanFd => None,
        }
    }

    /// Where the file leaves it open, `network` is told how many cycles an acknowledgement has room for.
    pub(super) fn read(
        root: &Section<'_>,
        plant: &Plant,
        controller: &ControllerSettings,
        network: &mut Network,
    ) -> Result<Self, DesignError> {
        let Some(table) = root.optional("wire", "a table with the key format") else {
            return Ok(Self::Bytes);
        };
        let wire = table.section(&["format", "output_limits"])?;
        let format = wire.required("format", "\"bytes\", \"can-fd\" or \"can-classic\"")?;
        let words =
            [("bytes", Format::Bytes), ("can-fd", Format::CanFd), ("can-classic", Format::CanClassic)];
        let format = format.choice(&words)?;
        if format != Format::CanClassic
            && let Some(limits) = wire.optional("output_limits", "")
        {
            let found = "found beside a format that does not round".to_string();
            let allowed = "give it with format = \"can-classic\" only";
            return Err(limits.reject_with(found, allowed.into()));
        }
        Ok(match format {
            Format::Bytes => Self::Bytes,
            Format::CanFd => Self::CanFd,
            Format::CanClassic => {
                let table = root.optional("network", "");
                if table.and_then(|table| table.inner("acknowledged_cycles")).is_none() {
                    network.acknowledged_cycles = network.acknowledged_cycles.min(MOST_CYCLES);
                }
                Self::CanClassic(steps(root, &wire, plant, controller)?)
            }
        })
    }

    /// Rejects a design whose frames do not fit, at the key that is at fault.
    pub(super) fn check(root: &Section<'_>, design: &Design) -> Result<(), DesignError> {
        let Some(misfit) = design.misfit() else { return Ok(()) };
        let (table, name) = misfit.key.split_once('.').unwrap_or(("", misfit.key));
        let field = root.optional(table, "").and_then(|table| table.inner(name));
        let Misfit { key, found, allowed } = misfit;
        Err(match field {
            Some(field) => field.reject_with(found, allowed),
            None => root.reject(key, found, allowed),
        })
    }
}

fn steps(
    root: &Section<'_>,
    wire: &Section<'_>,
    plant: &Plant,
    controller: &ControllerSettings,
) -> Result<Steps, DesignError> {
    let field = wire.required("output_limits", "the largest absolute value of each output, above 0")?;
    let limits = field.numbers()?;
    if limits.len() != plant.outputs() {
        let (found, outputs) = (counted(limits.len(), "number"), counted(plant.outputs(), "output"));
        let found = format!("found {found}, but the plant has {outputs}");
        return Err(field.reject_with(found, format!("give {}", counted(plant.outputs(), "number"))));
    }
    let outputs = steps_of(&field, limits, controller.scalar)?;
    let field = root.optional("controller", "").and_then(|table| table.inner("input_limits"));
    let (Some(pairs), Some(field)) = (&controller.input_limits, field) else {
        let found = "missing, but wire.format = \"can-classic\" counts inputs".to_string();
        let allowed = "give one pair [least, greatest] per input: the greater absolute value is 32767 counts";
        return Err(wire.reject("controller.input_limits", found, allowed.into()));
    };
    let largest = pairs.iter().map(|&(least, greatest)| greatest.max(-least)).collect();
    Ok(Steps { inputs: steps_of(&field, largest, controller.scalar)?, outputs })
}

/// One step for each limit that is given in `field`.
fn steps_of(field: &Field<'_>, limits: Vec<f64>, scalar: DeviceScalar) -> Result<Vec<f64>, DesignError> {
    let of = |limit: f64| {
        step(limit, scalar).ok_or_else(|| {
            let allowed = format!("give one above 0 whose part of 1/32767 {} can hold", scalar.name());
            field.reject_with(format!("found the limit {limit:?}"), allowed)
        })
    };
    limits.into_iter().map(of).collect()
}

/// The step that divides `limit` into the counts there are, rounded as the device rounds; `None` if there is none.
fn step(limit: f64, scalar: DeviceScalar) -> Option<f64> {
    let most = f32::from(LARGEST_COUNT);
    let (step, is_valid) = match scalar {
        DeviceScalar::F32 => {
            let step = limit as f32 / most;
            (f64::from(step), Grid { step: Vector1::new(step), largest_count: LARGEST_COUNT }.is_valid())
        }
        DeviceScalar::F64 => {
            let step = limit / f64::from(most);
            (step, Grid { step: Vector1::new(step), largest_count: LARGEST_COUNT }.is_valid())
        }
    };
    is_valid.then_some(step)
}

/// Whether acknowledgements travel at all.
fn acknowledges(network: &Network) -> bool {
    network.acknowledgement != Acknowledgement::None
}
