//! How things are called in design files, reports and generated source.

use crate::design::DeviceScalar;
use slqg::DefaultInput;
use slqg::estimator::Merging;

/// As in design files, on the command line and in JSON.
pub(crate) const fn default_input_name(default_input: DefaultInput) -> &'static str {
    match default_input {
        DefaultInput::Zero => "zero",
        DefaultInput::Hold => "hold",
    }
}

/// As in design files and in Rust.
pub(crate) const fn scalar_name(scalar: DeviceScalar) -> &'static str {
    match scalar {
        DeviceScalar::F32 => "f32",
        DeviceScalar::F64 => "f64",
    }
}

/// As in design files and in JSON.
pub(crate) const fn estimator_name(estimator: Merging) -> &'static str {
    match estimator {
        Merging::Single => "single",
        Merging::Imm => "imm",
        Merging::Gpb2 => "gpb2",
    }
}
