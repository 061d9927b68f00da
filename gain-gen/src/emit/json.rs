//! The gains as JSON: every field of the report, then the model and the settings of both nodes.

use crate::report::{Document, ModeGains, Report, Verdict, line_per_field, rows, scalar_name};
use serde::Serialize;

/// Name of the format; a reader that does not find it has another kind of file.
const FORMAT: &str = "slqg-gains";
/// Raised when a field changes its meaning or goes away; new fields may come at any time.
const FORMAT_VERSION: u32 = 1;

#[derive(Serialize)]
struct Gains<'r> {
    format: &'static str,
    format_version: u32,
    #[serde(flatten)]
    report: Document<'r>,
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

pub(super) fn document(report: &Report) -> String {
    let (plant, settings) = (&report.design.plant, &report.design.controller);
    line_per_field(&Gains {
        format: FORMAT,
        format_version: FORMAT_VERSION,
        report: Document::of(report, ModeGains::Small),
        design_id: super::design_id(&report.design).to_string(),
        accepted_undecided_stability: report.task.is_none() && report.verdict() != Verdict::Stable,
        sample_time: plant.sample_time,
        scalar: scalar_name(settings.scalar),
        measurement_buffer: settings.measurement_buffer,
        input_limits: settings.input_limits.as_deref(),
        model: Model {
            a: rows(&plant.a),
            b: rows(&plant.b),
            c: rows(&plant.c),
            process_noise: rows(&plant.process_noise),
            measurement_noise: rows(&plant.measurement_noise),
            initial_mean: plant.initial_mean.as_slice(),
            initial_covariance: rows(&plant.initial_covariance),
        },
    })
}
