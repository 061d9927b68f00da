//! Several runs over time in one chart for each quantity, one below the other: what they have in common, and where they part.

use super::{Axis, Drawn, FINE, INK, PANEL, Swatch, colour, legend, plot, px, svg};
use plotters::{
    series::{DashedLineSeries, LineSeries},
    style::{Color, RGBColor},
};

const HEIGHT: f64 = 140.0;
const SIDE: f64 = 8.0;

/// One quantity of all runs, a value per cycle.
pub(crate) struct Quantity {
    /// What it is, with its unit.
    pub(crate) label: String,
    /// What it is to be; empty where that is not said.
    pub(crate) reference: Vec<f64>,
    /// In the order of the runs.
    pub(crate) runs: Vec<Vec<f64>>,
}

/// The charts; the first run's line is drawn through, the others' are dashed. Values are held for a cycle of `sample_time`
/// seconds.
pub(crate) fn overlay(names: &[&str], quantities: &[Quantity], sample_time: f64) -> String {
    let line = |run: usize, colour: RGBColor| match run {
        0 => Swatch::Line(colour),
        _ => Swatch::DashedLine(colour),
    };
    let of_run = |(run, name): (usize, &&str)| (line(run, colour(run)), name.to_string());
    let mut entries: Vec<_> = names.iter().enumerate().map(of_run).collect();
    entries.push((Swatch::ThinLine, "reference".into()));
    let above = legend::height("", &entries, SIDE, PANEL - SIDE);
    svg(PANEL, above + HEIGHT * quantities.len() as f64, |canvas| {
        legend::draw(canvas, "", &entries, SIDE, PANEL - SIDE)?;
        let (_, mut rest) = canvas.split_vertically(px(above));
        for (number, quantity) in quantities.iter().enumerate() {
            let (own, below) = rest.split_vertically(px(HEIGHT));
            let time = if number + 1 == quantities.len() { "time in s" } else { "" };
            chart(&own, quantity, time, sample_time)?;
            rest = below;
        }
        Ok(())
    })
}

fn chart(canvas: &super::Canvas<'_>, of: &Quantity, time: &str, sample_time: f64) -> Drawn {
    let cycles = of.runs.iter().map(Vec::len).max().unwrap_or(0).max(1);
    let x = Axis::between(time, 0.0, cycles as f64 * sample_time);
    let y = Axis::linear(of.label.as_str(), of.runs.iter().flatten().chain(&of.reference).copied());
    let held = |values: &[f64]| -> Vec<(f64, f64)> {
        let placed = values.iter().enumerate().filter_map(|(cycle, value)| Some((cycle, y.at(*value)?)));
        let ends = |cycle: usize| [cycle, cycle + 1].map(|cycle| cycle as f64 * sample_time);
        placed.flat_map(|(cycle, value)| ends(cycle).map(|time| (time, value))).collect()
    };
    plot(canvas, &x, &y, |chart| -> Drawn {
        chart.draw_series(LineSeries::new(held(&of.reference), INK.stroke_width(FINE * 3 / 4)))?;
        for (run, values) in of.runs.iter().enumerate() {
            let style = colour(run).stroke_width(px(1.5) as u32);
            if run == 0 {
                chart.draw_series(LineSeries::new(held(values), style))?;
            } else {
                chart.draw_series(DashedLineSeries::new(held(values), px(6.0), px(3.0), style))?;
            }
        }
        Ok(())
    })
}
