//! [`Margins`] as JSON: those of the loop whose state is known by themselves, those of the flashed loop under `flashed`.

use crate::margins::{Bounds, Change, Flashed, LinkMargins, Margins, Matrix, PlantMargin};
use serde::Serialize;

/// [`Margins`].
#[derive(Serialize)]
pub(super) struct MarginFigures {
    extra_loss: f64,
    /// Null: any delay may come.
    extra_delay_steps: Option<usize>,
    input_gain_min: f64,
    input_gain_max: f64,
    /// Null: not known, see `flashed_not_given`.
    flashed: Option<FlashedFigures>,
    /// Why; null if they are there.
    flashed_not_given: Option<String>,
}

/// [`Flashed`].
#[derive(Serialize)]
struct FlashedFigures {
    control: LinkFigures,
    measurements: LinkFigures,
    measurement_limit_is_exact: bool,
    input_gain: PlantFigures,
    /// Null: no continuous plant is behind the discrete one.
    sample_time: Option<PlantFigures>,
    /// Null: too many of them.
    entries: Option<Vec<EntryFigures>>,
    /// Null: exact.
    accuracy: Option<f64>,
}

/// [`LinkMargins`].
#[derive(Serialize)]
struct LinkFigures {
    extra_loss: f64,
    /// Null: any delay may come.
    extra_delay_steps: Option<usize>,
}

/// [`PlantMargin`]. Null: stable as far as was tried.
#[derive(Serialize)]
struct PlantFigures {
    min: Option<f64>,
    max: Option<f64>,
    state_known_min: Option<f64>,
    state_known_max: Option<f64>,
}

/// One entry of the plant; row and column from 0.
#[derive(Serialize)]
struct EntryFigures {
    /// `a` or `b`.
    matrix: &'static str,
    row: usize,
    column: usize,
    #[serde(flatten)]
    figures: PlantFigures,
}

impl MarginFigures {
    pub(super) fn of(margins: &Margins) -> Self {
        let state_known = &margins.state_known;
        Self {
            extra_loss: state_known.extra_loss,
            extra_delay_steps: state_known.extra_delay,
            input_gain_min: state_known.input_gain_min,
            input_gain_max: state_known.input_gain_max,
            flashed: margins.flashed.as_ref().ok().map(FlashedFigures::of),
            flashed_not_given: margins.flashed.as_ref().err().map(ToString::to_string),
        }
    }
}

impl FlashedFigures {
    fn of(flashed: &Flashed) -> Self {
        let link = |margins: &LinkMargins| LinkFigures {
            extra_loss: margins.extra_loss,
            extra_delay_steps: margins.extra_delay,
        };
        let entries = flashed.entries.as_ref();
        Self {
            control: link(&flashed.control),
            measurements: link(&flashed.measurements),
            measurement_limit_is_exact: flashed.measurement_limit_is_exact,
            input_gain: PlantFigures::of(&flashed.input_gain),
            sample_time: flashed.sample_time.as_ref().map(PlantFigures::of),
            entries: entries.map(|margins| margins.iter().filter_map(EntryFigures::of).collect()),
            accuracy: flashed.accuracy,
        }
    }
}

impl PlantFigures {
    fn of(margin: &PlantMargin) -> Self {
        let PlantMargin { flashed, state_known, .. } = *margin;
        let Bounds { least: min, greatest: max } = flashed;
        Self { min, max, state_known_min: state_known.least, state_known_max: state_known.greatest }
    }
}

impl EntryFigures {
    /// `None` for what is no entry.
    fn of(margin: &PlantMargin) -> Option<Self> {
        let Change::Entry { matrix, row, column } = margin.change else { return None };
        let matrix = match matrix {
            Matrix::A => "a",
            Matrix::B => "b",
        };
        Some(Self { matrix, row, column, figures: PlantFigures::of(margin) })
    }
}
