//! The gains as JSON: every field of the report, then the model and the settings of both nodes.

use super::{Emission, Standing};
use crate::json::{joined, line_per_field, rows};
use serde::Serialize;

/// Name of the format; a reader that does not find it has another kind of file.
const FORMAT: &str = "slqg-gains";
/// Raised when a field changes its meaning or goes away; new fields may come at any time.
const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
struct Head {
    format: &'static str,
    format_version: u32,
}

#[derive(Serialize)]
struct Gains<'r> {
    /// As [`super::design_id`], in hexadecimal.
    design_id: String,
    /// Whether it was written although its `verdict` is not `stable`: `failed_conditions` says what is not shown.
    accepted_undecided_stability: bool,
    /// In seconds.
    sample_time: f64,
    /// Scalar of the arithmetic on the device; the numbers here are not rounded to it.
    scalar: &'static str,
    /// `N^B`, in steps.
    measurement_buffer: usize,
    /// `[least, greatest]` for each input; null: unlimited.
    input_limits: Option<&'r [(f64, f64)]>,
    model: Model<'r>,
}

/// Thesis (3.1)-(3.3), in discrete time.
#[derive(Serialize)]
struct Model<'r> {
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    process_noise: Vec<Vec<f64>>,
    measurement_noise: Vec<Vec<f64>>,
    initial_mean: &'r [f64],
    initial_covariance: Vec<Vec<f64>>,
}

pub(super) fn document(emission: &Emission<'_>) -> String {
    let (plant, settings) = (&emission.design.plant, &emission.design.controller);
    let head = line_per_field(&Head { format: FORMAT, format_version: FORMAT_VERSION });
    let gains = line_per_field(&Gains {
        design_id: super::design_id(emission.design).to_string(),
        accepted_undecided_stability: matches!(emission.standing, Standing::Accepted { .. }),
        sample_time: plant.sample_time,
        scalar: settings.scalar.name(),
        measurement_buffer: settings.measurement_buffer,
        input_limits: settings.input_limits.as_deref(),
        model: Model {
            a: rows(&plant.a),
            b: rows(&plant.b),
            c: rows(&plant.c),
            process_noise: rows(&emission.process_noise()),
            measurement_noise: rows(&plant.measurement_noise),
            initial_mean: plant.initial_mean.as_slice(),
            initial_covariance: rows(&plant.initial_covariance),
        },
    });
    joined(&[&head, &emission.figures.to_json(), &gains])
}
