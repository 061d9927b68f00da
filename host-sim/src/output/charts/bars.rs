//! Shares by a whole number, with bars of several series beside each other: delays of links, ages of inputs.

use super::{Axis, Swatch, colour, panel, plot};
use plotters::{element::Rectangle, style::Color};

const HEIGHT: f64 = 210.0;
/// Share of the room of a number that its bars take.
const FILLED: f64 = 0.8;
/// Numbers on the axis that can be read beside each other.
const NAMED: usize = 14;

/// One series.
pub(crate) struct Bars {
    pub(crate) name: String,
    /// Share of each number from 0 on, 0 to 1.
    pub(crate) shares: Vec<f64>,
    /// Share of what has no number, such as loss.
    pub(crate) rest: f64,
}

/// The chart. The bar of the rest, called `rest`, stands apart from the others.
pub(crate) fn bars(x_label: &str, y_label: &str, rest: &str, series: &[Bars]) -> String {
    let numbers = series.iter().map(|bars| bars.shares.len()).max().unwrap_or(0);
    let place_of_rest = numbers + 1;
    let mut x = Axis::whole(x_label, 0, numbers.saturating_sub(1), NAMED);
    x.append(place_of_rest as f64, rest);
    let all = || series.iter().flat_map(|bars| bars.shares.iter().copied().chain([bars.rest]));
    let y = Axis::from_zero(y_label, all().map(|share| 100.0 * share));
    let entries: Vec<_> = series
        .iter()
        .enumerate()
        .map(|(number, bars)| (Swatch::Bar(colour(number)), bars.name.clone()))
        .collect();
    panel("", &entries, HEIGHT, |canvas| {
        plot(canvas, &x, &y, |chart| {
            let width = FILLED / series.len() as f64;
            for (number, bars) in series.iter().enumerate() {
                let placed = bars.shares.iter().copied().enumerate().chain([(place_of_rest, bars.rest)]);
                let drawn = placed.filter(|(_, share)| *share > 0.0).map(|(place, share)| {
                    let from = place as f64 - FILLED / 2.0 + number as f64 * width;
                    Rectangle::new([(from, 0.0), (from + width, 100.0 * share)], colour(number).filled())
                });
                chart.draw_series(drawn)?;
            }
            Ok(())
        })
    })
}
