//! A figure against the sequence length, one curve per controller, or against another whole number.

use super::{Axis, Drawn, INK, Mark, Swatch, colour, panel, plot, px};
use plotters::{
    element::PathElement,
    series::{DashedLineSeries, LineSeries},
    style::Color,
};

/// How far the next curve stands to the right, in lengths: equal figures would cover each other.
const ASIDE: f64 = 0.07;
const HEIGHT: f64 = 290.0;

/// One controller's figures.
pub(crate) struct Curve {
    pub(crate) name: String,
    /// Length (or other number), figure, and half the length of its error bar.
    pub(crate) points: Vec<(usize, f64, f64)>,
    /// Whether the figure is the same for every length.
    pub(crate) is_level: bool,
}

/// Where the axis of the figures begins.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Start {
    /// At zero.
    AtZero,
    /// Below the least of them; logarithmic where they span decades.
    AtLeast,
}

/// The chart over the lengths of sequences.
pub(crate) fn against_length(label: &str, start: Start, curves: &[Curve]) -> String {
    against(("inputs per sequence, N", 12), label, start, curves)
}

/// The chart over any whole numbers: what they are, and how many of them the axis names at most.
pub(crate) fn against(across: (&str, usize), label: &str, start: Start, curves: &[Curve]) -> String {
    let lengths = || curves.iter().filter(|curve| !curve.is_level).flat_map(|curve| &curve.points);
    let first = lengths().map(|point| point.0).min().unwrap_or(1);
    let last = lengths().map(|point| point.0).max().unwrap_or(1);
    let x = Axis::whole(across.0, first, last, across.1);
    let ends = |&(_, value, half): &(usize, f64, f64)| [value - half, value + half, value];
    let values: Vec<f64> =
        curves.iter().flat_map(|curve| &curve.points).flat_map(ends).filter(|value| *value > 0.0).collect();
    let y = match start {
        Start::AtZero => Axis::from_zero(label, values.into_iter()),
        Start::AtLeast => Axis::fitting(label, &values),
    };
    let swatch = |(number, curve): (usize, &Curve)| match curve.is_level {
        true => (Swatch::Dashes, curve.name.clone()),
        false => (Swatch::Marked(Mark::ALL[number % 6], colour(number)), curve.name.clone()),
    };
    let entries: Vec<_> = curves.iter().enumerate().map(swatch).collect();
    panel("", &entries, HEIGHT, |canvas| {
        plot(canvas, &x, &y, |chart| -> Drawn {
            for (number, curve) in curves.iter().enumerate() {
                let across = |length: usize| length as f64 + ASIDE * number as f64;
                let place = |&(length, value, _): &(usize, f64, f64)| Some((across(length), y.at(value)?));
                let points: Vec<(f64, f64)> = curve.points.iter().filter_map(place).collect();
                if curve.is_level {
                    let level =
                        points.first().map_or(vec![], |point| vec![(x.low, point.1), (x.high, point.1)]);
                    let style = INK.stroke_width(px(1.5) as u32);
                    chart.draw_series(DashedLineSeries::new(level, px(6.0), px(4.0), style))?;
                    continue;
                }
                let style = colour(number).stroke_width(px(1.8) as u32);
                let bars = curve.points.iter().filter_map(|&(length, value, half)| {
                    let (low, high) = (y.at(value - half).unwrap_or(y.low), y.at(value + half)?);
                    Some(PathElement::new([(across(length), low), (across(length), high)], style))
                });
                chart.draw_series(bars)?;
                chart.draw_series(LineSeries::new(points.iter().copied(), style))?;
                for point in points {
                    let place = chart.backend_coord(&point);
                    Mark::ALL[number % 6].draw(canvas, relative(canvas, place), colour(number))?;
                }
            }
            Ok(())
        })
    })
}

/// A place on the backend as one on `canvas`.
fn relative(canvas: &super::Canvas<'_>, (x, y): (i32, i32)) -> (i32, i32) {
    let (left, top) = canvas.get_base_pixel();
    (x - left, y - top)
}
