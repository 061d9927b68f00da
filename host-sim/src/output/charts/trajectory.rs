//! One quantity of one run over time: what it was, what it was taken for, what it was to be.

use super::{Axis, Drawn, FINE, INK, Swatch, colour, panel, plot, px};
use plotters::{
    element::Polygon,
    series::{DashedLineSeries, LineSeries},
    style::Color,
};

const HEIGHT: f64 = 200.0;

/// What to draw, one value per cycle from cycle 0 on.
pub(crate) struct Trajectory {
    /// Whose run, and its number among others, which picks the colour.
    pub(crate) title: String,
    pub(crate) number: usize,
    /// What the values are called.
    pub(crate) name: &'static str,
    pub(crate) values: Vec<f64>,
    /// The estimate of it with its standard deviation; empty where nothing is estimated.
    pub(crate) estimates: Vec<(f64, f64)>,
    /// What the middle of the band is called.
    pub(crate) expected: &'static str,
    /// What it is to be; empty where that is not said.
    pub(crate) reference: Vec<f64>,
    /// Whether it stays the same between two cycles, as inputs do.
    pub(crate) is_held: bool,
}

impl Trajectory {
    /// Everything that the axis has to show.
    pub(crate) fn extent(&self) -> impl Iterator<Item = f64> + '_ {
        let bands = self.estimates.iter().flat_map(|&(mean, deviation)| band(mean, deviation));
        self.values.iter().chain(&self.reference).copied().chain(bands)
    }
}

/// Two standard deviations to either side.
fn band(mean: f64, deviation: f64) -> [f64; 2] {
    [mean - 2.0 * deviation, mean + 2.0 * deviation]
}

/// The chart; `sample_time` in seconds.
pub(crate) fn trajectory(of: &Trajectory, y: &Axis, sample_time: f64) -> String {
    let colour = colour(of.number);
    let mut entries = vec![(Swatch::Line(colour), of.name.to_string())];
    if !of.estimates.is_empty() {
        entries.push((Swatch::ThinLine, of.expected.into()));
        entries.push((Swatch::Band(colour), "\u{b1} 2\u{3c3}".into()));
    }
    if !of.reference.is_empty() {
        entries.push((Swatch::Dashes, "reference".into()));
    }
    let end = of.values.len().max(1) as f64 * sample_time;
    let x = Axis::between("time in s", 0.0, end);
    let line = |values: &mut dyn Iterator<Item = f64>| -> Vec<(f64, f64)> {
        let placed = values.enumerate().filter_map(|(cycle, value)| Some((cycle, y.at(value)?)));
        placed.map(|(cycle, value)| (cycle as f64 * sample_time, value)).collect()
    };
    panel(&of.title, &entries, HEIGHT, |canvas| {
        plot(canvas, &x, y, |chart| -> Drawn {
            let edge = |side: usize| {
                line(&mut of.estimates.iter().map(|&(mean, deviation)| band(mean, deviation)[side]))
            };
            let mut outline = edge(0);
            outline.extend(edge(1).into_iter().rev());
            chart
                .draw_series((outline.len() > 2).then(|| Polygon::new(outline, colour.mix(0.25).filled())))?;
            let mut values = line(&mut of.values.iter().copied());
            if of.is_held {
                values = held(&values, sample_time);
            }
            chart.draw_series(LineSeries::new(values, colour.stroke_width(px(1.8) as u32)))?;
            let estimates = line(&mut of.estimates.iter().map(|estimate| estimate.0));
            chart.draw_series(LineSeries::new(estimates, INK.stroke_width(FINE * 3 / 4)))?;
            let reference = line(&mut of.reference.iter().copied());
            if !reference.is_empty() {
                let style = INK.stroke_width(px(1.5) as u32);
                chart.draw_series(DashedLineSeries::new(reference, px(6.0), px(4.0), style))?;
            }
            Ok(())
        })
    })
}

/// Steps through the points, each held for `time`.
fn held(points: &[(f64, f64)], time: f64) -> Vec<(f64, f64)> {
    points.iter().flat_map(|&(from, value)| [(from, value), (from + time, value)]).collect()
}
