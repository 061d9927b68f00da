//! `[wire]`: what carries the nodes' frames, and in what steps values are counted where they are.
//!
//! Whether frames are sealed is in `authentication`, whether they fit their carrier in `fit`, what a count of one stands for in
//! `steps`; the bytes themselves are [`slqg::wire`]'s.

mod authentication;
mod fit;
mod steps;

use super::document::{Field, Section, counted};
use super::{Acknowledgement, ControllerSettings, Design, DesignError, DeviceScalar, Network, Plant};
use slqg::wire::can::MOST_CYCLES;

pub use authentication::Authentication;
pub use fit::{FrameBytes, Misfit};
pub use steps::{Counted, Steps};

/// Keys of the table.
const KEYS: [&str; 3] = ["format", "output_limits", "authentication"];

/// What carries the frames of the loop.
#[derive(Debug, Clone, PartialEq)]
pub enum WireSettings {
    /// Anything that carries bytes: full frames.
    Bytes,
    /// Full frames, each in one CAN FD frame.
    CanFd,
    /// Compact frames, each in one classic CAN frame.
    CanClassic(ValueLimits),
}

/// What the largest count stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct ValueLimits {
    /// For each input, in its unit.
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

    /// Whether values are counted in steps.
    pub const fn counts_values(&self) -> bool {
        matches!(self, Self::CanClassic(_))
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
        let wire = table.section(&KEYS)?;
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
                Self::CanClassic(limits(root, &wire, plant, controller)?)
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

fn limits(
    root: &Section<'_>,
    wire: &Section<'_>,
    plant: &Plant,
    controller: &ControllerSettings,
) -> Result<ValueLimits, DesignError> {
    let field = wire.required("output_limits", "the largest absolute value of each output, above 0")?;
    let outputs = field.numbers()?;
    if outputs.len() != plant.outputs() {
        let (found, expected) = (counted(outputs.len(), "number"), counted(plant.outputs(), "output"));
        let found = format!("found {found}, but the plant has {expected}");
        return Err(field.reject_with(found, format!("give {}", counted(plant.outputs(), "number"))));
    }
    check_steps(&field, &outputs, controller.scalar)?;
    let field = root.optional("controller", "").and_then(|table| table.inner("input_limits"));
    let (Some(pairs), Some(field)) = (&controller.input_limits, field) else {
        let found = "missing, but wire.format = \"can-classic\" counts inputs".to_string();
        let allowed =
            "give one pair [least, greatest] per input: the greater absolute value is the largest count";
        return Err(wire.reject("controller.input_limits", found, allowed.into()));
    };
    let inputs: Vec<f64> = pairs.iter().map(|&(least, greatest)| greatest.max(-least)).collect();
    check_steps(&field, &inputs, controller.scalar)?;
    Ok(ValueLimits { inputs, outputs })
}

/// Rejects a limit in `field` without a step that the device could compute with.
fn check_steps(field: &Field<'_>, limits: &[f64], scalar: DeviceScalar) -> Result<(), DesignError> {
    match limits.iter().find(|limit| !steps::is_valid(**limit, scalar)) {
        None => Ok(()),
        Some(limit) => {
            let most = slqg::wire::can::LARGEST_COUNT;
            let allowed = format!("give one above 0 whose part of 1/{most} {} can hold", scalar.name());
            Err(field.reject_with(format!("found the limit {limit:?}"), allowed))
        }
    }
}

/// Whether acknowledgements travel at all.
fn acknowledges(network: &Network) -> bool {
    network.acknowledgement != Acknowledgement::None
}
