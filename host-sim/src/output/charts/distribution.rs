//! How costs of runs are distributed: one row per controller over one axis.

use super::{Axis, Drawn, FINE, INK, PANEL, Swatch, colour, legend, plot, px, svg};
use plotters::{
    element::{PathElement, Rectangle},
    style::Color,
};

const BINS: usize = 40;
/// Ratio to the least cost of the greatest that is told from others: runs that diverge would squeeze the rest.
const MOST: f64 = 1e10;
/// Height of a row, its axis included.
const ROW: f64 = 150.0;
/// Room above a row for its name.
const NAME: f64 = 25.0;

/// The chart: names and costs of the runs. Costs that are not numbers are left out.
pub(crate) fn distribution(label: &str, series: &[(String, &[f64])]) -> String {
    let all = || series.iter().flat_map(|(_, costs)| costs.iter().copied());
    let least = all().filter(|cost| *cost > 0.0).fold(f64::INFINITY, f64::min);
    let most = least * MOST;
    let ends = if all().any(|cost| cost > most) { "; last bar: and above" } else { "" };
    let shown: Vec<f64> = all().map(|cost| cost.min(most)).collect();
    let mut x = Axis::fitting(label, &shown);
    x.label += ends;
    let width = (x.high - x.low) / BINS as f64;
    let shares: Vec<Vec<f64>> = series
        .iter()
        .map(|(_, costs)| {
            let mut bins = vec![0.0; BINS];
            for place in costs.iter().filter_map(|&cost| x.at(cost.min(most))) {
                bins[(((place - x.low) / width) as usize).min(BINS - 1)] += 100.0 / costs.len() as f64;
            }
            bins
        })
        .collect();
    svg(PANEL, (NAME + ROW) * series.len() as f64, |canvas| {
        for (number, ((name, costs), bins)) in series.iter().zip(&shares).enumerate() {
            let from = px((NAME + ROW) * number as f64);
            let (_, rest) = canvas.split_vertically(from);
            let (row, _) = rest.split_vertically(px(NAME + ROW));
            let median = crate::sample::quantile(costs, 0.5);
            let mean = crate::sample::mean(costs);
            let entries = [(Swatch::ThinLine, "median".into()), (Swatch::Dashes, "mean".into())];
            legend::draw(&row, name, &entries, 8.0, PANEL)?;
            let (_, chart) = row.split_vertically(px(NAME));
            let y = Axis::from_zero("runs in %", bins.iter().copied());
            plot(&chart, &x, &y, |chart| -> Drawn {
                let bars = bins.iter().enumerate().filter(|(_, share)| **share > 0.0).map(|(bin, &share)| {
                    let from = x.low + bin as f64 * width;
                    Rectangle::new([(from, 0.0), (from + width, share)], colour(number).mix(0.8).filled())
                });
                chart.draw_series(bars)?;
                let upright = |at: f64, low: f64, high: f64, stroke: u32| {
                    PathElement::new([(at, low * y.high), (at, high * y.high)], INK.stroke_width(stroke))
                };
                if let Some(at) = x.at(median.min(most)) {
                    chart.draw_series([upright(at, 0.0, 1.0, FINE)])?;
                }
                if let Some(at) = x.at(mean.min(most)) {
                    let dashes = (0..8).map(|dash| f64::from(dash) / 8.0);
                    chart.draw_series(dashes.map(|low| upright(at, low, low + 0.07, FINE * 2)))?;
                }
                Ok(())
            })?;
        }
        Ok(())
    })
}
