//! Distances to instability: of the loop as flashed, and of the one whose state is known beside it.

use super::super::Report;
use super::super::figure::{duration, figure, percent};
use super::line;
use crate::margins::{
    Bounds, Change, Flashed, LARGEST_FACTOR, LARGEST_INPUT_GAIN, LARGEST_SAMPLE_TIME, LinkMargins, Matrix,
    PlantMargin, StateKnown,
};
use core::fmt::{self, Formatter};

/// A loss beyond which nothing has to arrive but now and then.
const ALL_BUT_FEW: f64 = 1.0 - 1e-6;

impl Report {
    pub(super) fn margins(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(reason) = &self.margins_not_given {
            writeln!(f, "\nMargins")?;
            return line(f, "not given", reason);
        }
        let Some(margins) = &self.margins else { return Ok(()) };
        writeln!(
            f,
            "\nMargins of the loop as flashed: mean square, outputs measured, controller as designed"
        )?;
        if self.design.controller.input_limits.is_some() {
            line(f, "input limits", "not part of them: all margins hold only while no input meets a limit")?;
        }
        match &margins.flashed {
            Ok(flashed) => self.flashed(f, flashed)?,
            Err(reason) => line(f, "not given", reason)?,
        }
        self.state_known(f, &margins.state_known)
    }

    fn flashed(&self, f: &mut Formatter<'_>, flashed: &Flashed) -> fmt::Result {
        let at_least = if flashed.measurement_limit_is_exact { "" } else { "at least " };
        self.link_margins(f, "control packets", &flashed.control, "")?;
        self.link_margins(f, "measurements", &flashed.measurements, at_least)?;
        line(f, "factor on", format!("{:<30}state known", "as flashed"))?;
        self.plant_margin(f, "B, every input", &flashed.input_gain)?;
        match &flashed.sample_time {
            Some(margin) => self.plant_margin(f, "sample time", margin)?,
            None => line(f, "sample time", "not given: no continuous plant has this A and B")?,
        }
        match &flashed.entries {
            Some(entries) => entries
                .iter()
                .try_for_each(|margin| self.plant_margin(f, &self.spelled(margin.change), margin))?,
            None => line(f, "entries of a, b", "not given: the loop has too many of its size")?,
        }
        match flashed.accuracy {
            None => line(f, "accuracy", "exact but for rounding"),
            Some(moved) => {
                let what = "or less: how far factors moved from 1 more or less in the last refinement";
                line(f, "accuracy", format!("{:<12}{what}", percent(moved)))
            }
        }
    }

    fn link_margins(
        &self,
        f: &mut Formatter<'_>,
        packets: &str,
        margins: &LinkMargins,
        at_least: &str,
    ) -> fmt::Result {
        let loss = match margins.extra_loss {
            1.0 => "all may be lost".into(),
            share if share > ALL_BUT_FEW => "any share short of all may be lost".into(),
            share => format!("{at_least}{} of those that arrive may be lost in addition", percent(share)),
        };
        let delay = match margins.extra_delay {
            None => "they may come however late".into(),
            Some(0) => "none may come later".into(),
            Some(steps) => format!("all may come {at_least}{} later", self.steps(steps as f64)),
        };
        line(f, packets, format!("{loss}; {delay}"))
    }

    fn plant_margin(&self, f: &mut Formatter<'_>, what: &str, margin: &PlantMargin) -> fmt::Result {
        let bounds = |bounds| between(margin.change, bounds);
        line(f, what, format!("{:<30}{}", bounds(margin.flashed), bounds(margin.state_known)))
    }

    /// An entry with its value, as the design file has it.
    fn spelled(&self, change: Change) -> String {
        match change {
            Change::Entry { matrix, row, column } => {
                let plant = &self.design.plant;
                let (a, b) = match &plant.continuous {
                    Some((a, b)) => (a, b),
                    None => (&plant.a, &plant.b),
                };
                let (name, values) = match matrix {
                    Matrix::A => ("a", a),
                    Matrix::B => ("b", b),
                };
                format!("{name}[{},{}] = {}", row + 1, column + 1, duration(values[(row, column)]))
            }
            Change::InputGain => "B".into(),
            Change::SampleTime => "sample time".into(),
        }
    }

    fn state_known(&self, f: &mut Formatter<'_>, margins: &StateKnown) -> fmt::Result {
        writeln!(f, "\nMargins, state known, controller as designed")?;
        let loss = match margins.extra_loss {
            1.0 => "stable even if all are lost".into(),
            share => format!("{:<12}of the packets that arrive may be lost in addition", percent(share)),
        };
        line(f, "extra loss", loss)?;
        let delay = match (margins.extra_delay, margins.rate_beyond_extra_delay) {
            (Some(0), Some(rate)) => format!("none; one step on every packet gives rate {}", figure(rate)),
            (Some(steps), Some(rate)) => {
                let late = self.steps(steps as f64);
                format!("{late} on every packet; with one more, rate {}", figure(rate))
            }
            _ => "stable however late packets come".into(),
        };
        line(f, "extra delay", delay)?;
        let least = match margins.input_gain_min {
            0.0 => "0 (needs no input)".into(),
            least if least < 1e-6 => "just above 0".into(),
            least => figure(least),
        };
        let most = match margins.input_gain_max {
            LARGEST_INPUT_GAIN => "beyond 100".into(),
            most => figure(most),
        };
        line(f, "input gain", format!("from {least} to {most}, times the design's B"))
    }
}

/// Two factors with four digits, or where the search for them ended.
fn between(change: Change, bounds: Bounds) -> String {
    let least = match (bounds.least, change) {
        (Some(least), _) if least.abs() < 1e-6 => "just above 0".into(),
        (Some(least), _) => duration(least),
        (None, Change::InputGain) => "0".into(),
        (None, Change::SampleTime) => format!("below {}", duration(1.0 / LARGEST_SAMPLE_TIME)),
        (None, Change::Entry { .. }) => format!("below {}", duration(1.0 - LARGEST_FACTOR)),
    };
    let greatest = match (bounds.greatest, change) {
        (Some(greatest), _) => duration(greatest),
        (None, Change::SampleTime) => format!("beyond {}", duration(LARGEST_SAMPLE_TIME)),
        (None, _) => format!("beyond {}", duration(1.0 + LARGEST_FACTOR)),
    };
    format!("{least} to {greatest}")
}
