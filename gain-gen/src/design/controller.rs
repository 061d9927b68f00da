//! `[controller]`: what is free to choose in the controller. Gains are not part of a design; they follow from it.

use super::DesignError;
use super::LengthChoice;
use super::document::{Field, Section, counted};
use slqg::DefaultInput;
use slqg::estimator::Merging;

/// Longest control sequence.
pub const LONGEST_SEQUENCE: usize = 128;
/// Longest measurement buffer.
const LONGEST_BUFFER: usize = 1000;
/// By what part more than long sequences a length chosen automatically may cost, unless the design says.
const LENGTH_TOLERANCE: f64 = 0.01;

/// Settings of controller and actuator node.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerSettings {
    /// N: inputs in a control sequence, 1 to 128.
    pub sequence_length: usize,
    /// How N was chosen where the design says "auto"; kept if N is changed, see [`super::Design::length_choice`].
    pub length_choice: Option<LengthChoice>,
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
    /// N^B: a measurement up to this many steps old still enters the estimate, thesis (3.34).
    pub measurement_buffer: usize,
    /// Whether the design gives it; otherwise it is the largest delay of a measurement.
    pub buffer_is_given: bool,
    /// Which ages the estimator keeps apart while no acknowledgement decides, if the design says; see [`super::Design::estimator`].
    pub estimator: Option<Merging>,
    /// Scalar type of the arithmetic on the device.
    pub scalar: DeviceScalar,
    /// (least, greatest) value the actuator can apply, one pair per input, in the input's unit; 0 lies within.
    /// `None`: unlimited.
    pub input_limits: Option<Vec<(f64, f64)>>,
    /// Whether the design says that there are none, and does not merely leave them out: for devices that is asked for.
    pub is_unlimited: bool,
    /// Most that the actuator changes each input in a second, in the input's unit. `None`: any.
    pub input_rates: Option<Vec<f64>>,
}

/// Floating point type on the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceScalar {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

impl DeviceScalar {
    /// As in design files and in Rust.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

impl ControllerSettings {
    /// Most that each input changes from one cycle of `sample_time` seconds to the next, if that is limited.
    pub fn rates_per_cycle(&self, sample_time: f64) -> Option<Vec<f64>> {
        Some(self.input_rates.as_ref()?.iter().map(|rate| rate * sample_time).collect())
    }

    /// `inputs`: nu of the plant. `latest_measurement`: largest delay of a measurement in steps; it sets the buffer if none is given.
    ///
    /// Also returns the tolerance with which the sequence length is to be chosen, if it is "auto"; until then it is 1.
    pub(super) fn read(
        root: &Section<'_>,
        inputs: usize,
        latest_measurement: usize,
    ) -> Result<(Self, Option<f64>), DesignError> {
        let controller = root.required("controller", "a table with the key sequence_length")?.section(&[
            "sequence_length",
            "length_tolerance",
            "default_input",
            "measurement_buffer",
            "estimator",
            "scalar",
            "input_limits",
            "unlimited_inputs",
            "input_rates",
        ])?;
        let (sequence_length, tolerance) = length_of(&controller)?;
        let default_input = match controller.optional("default_input", "\"zero\" or \"hold\"") {
            None => DefaultInput::Zero,
            Some(field) => field.choice(&[("zero", DefaultInput::Zero), ("hold", DefaultInput::Hold)])?,
        };
        let buffer = "a whole number of steps from 0 to 1000";
        let measurement_buffer = match controller.optional("measurement_buffer", buffer) {
            None => latest_measurement,
            Some(field) => field.whole_number(0..=LONGEST_BUFFER)?,
        };
        let names = "\"single\", \"imm\", \"gpb2\" or \"linear\"";
        let estimator = controller.optional("estimator", names).map(|field| {
            field.choice(&[
                ("single", Merging::Single),
                ("imm", Merging::Imm),
                ("gpb2", Merging::Gpb2),
                ("linear", Merging::Linear),
            ])
        });
        let estimator = estimator.transpose()?;
        let scalar = match controller.optional("scalar", "\"f32\" or \"f64\"") {
            None => DeviceScalar::F32,
            Some(field) => field.choice(&[("f32", DeviceScalar::F32), ("f64", DeviceScalar::F64)])?,
        };
        let limits = "one pair [least, greatest] per input: [[-1, 1], ..]";
        let input_limits = match controller.optional("input_limits", limits) {
            None => None,
            Some(field) => Some(limits_of(&field, inputs)?),
        };
        let is_unlimited = controller
            .optional("unlimited_inputs", "true or false")
            .map_or(Ok(false), |field| field.truth())?;
        let input_rates = rates_of(&controller, inputs, input_limits.is_some(), estimator)?;
        let settings = ControllerSettings {
            sequence_length,
            length_choice: None,
            default_input,
            measurement_buffer,
            buffer_is_given: controller.optional("measurement_buffer", buffer).is_some(),
            estimator,
            scalar,
            input_limits,
            is_unlimited,
            input_rates,
        };
        Ok((settings, tolerance))
    }
}

/// The length given, or 1 and the tolerance of the one to choose.
fn length_of(controller: &Section<'_>) -> Result<(usize, Option<f64>), DesignError> {
    let field =
        controller.required("sequence_length", "a whole number of inputs from 1 to 128, or \"auto\"")?;
    let tolerance = controller.optional("length_tolerance", "a number above 0 and below 1");
    if !field.is_text() {
        if let Some(tolerance) = tolerance {
            let found = "found beside a number of inputs".to_string();
            return Err(tolerance.reject_with(found, "give it with sequence_length = \"auto\" only".into()));
        }
        return Ok((field.whole_number(1..=LONGEST_SEQUENCE)?, None));
    }
    field.choice(&[("auto", ())])?;
    let Some(field) = tolerance else { return Ok((1, Some(LENGTH_TOLERANCE))) };
    let tolerance = field.number()?;
    if !(0.0 < tolerance && tolerance < 1.0) {
        return Err(field.reject(format!("found the number {tolerance}")));
    }
    Ok((1, Some(tolerance)))
}

/// Rates, which go with limits and with one estimate for all ages only.
fn rates_of(
    controller: &Section<'_>,
    inputs: usize,
    has_limits: bool,
    estimator: Option<Merging>,
) -> Result<Option<Vec<f64>>, DesignError> {
    let rates = "one number above 0 per input, in its unit per second: [10, ..]";
    let Some(field) = controller.optional("input_rates", rates) else { return Ok(None) };
    let values = field.numbers()?;
    if values.len() != inputs {
        let found = format!(
            "found {}, but the plant has {}",
            counted(values.len(), "number"),
            counted(inputs, "input")
        );
        return Err(field.reject(found));
    }
    if let Some(rate) = values.iter().find(|rate| **rate <= 0.0) {
        return Err(field.reject(format!("found the number {rate}")));
    }
    if !has_limits {
        return Err(field.reject_with("found without input_limits".into(), "give both, or neither".into()));
    }
    if let Some(estimator) = estimator.filter(|estimator| *estimator != Merging::Single) {
        let found = format!("found with estimator = \"{}\"", estimator.name());
        return Err(field.reject_with(found, "give it with estimator = \"single\" only".into()));
    }
    Ok(Some(values))
}

fn limits_of(field: &Field<'_>, inputs: usize) -> Result<Vec<(f64, f64)>, DesignError> {
    let limits = field.matrix()?;
    if limits.shape() != (inputs, 2) {
        let (rows, columns) = limits.shape();
        let found = format!(
            "found {} of {columns}, but the plant has {}",
            counted(rows, "row"),
            counted(inputs, "input")
        );
        return Err(field.reject(found));
    }
    let pairs: Vec<_> = limits.row_iter().map(|pair| (pair[0], pair[1])).collect();
    for (at, &(least, greatest)) in pairs.iter().enumerate() {
        if !(least <= 0.0 && 0.0 <= greatest && least < greatest) {
            let found = format!("found least {least} and greatest {greatest} for input {}", at + 1);
            let allowed = "give least <= 0 <= greatest, not both 0: zero input must be possible";
            return Err(field.reject_with(found, allowed.into()));
        }
    }
    Ok(pairs)
}
