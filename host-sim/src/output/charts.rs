//! Pictures as SVG: trajectories of one run, distribution of the cost.

use crate::closed_loop::CycleRecord;
use plotters::{
    backend::SVGBackend,
    chart::{ChartBuilder, ChartContext, SeriesLabelPosition},
    coord::{Shift, cartesian::Cartesian2d, types::RangedCoordf64},
    drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea},
    element::{PathElement, Rectangle},
    series::LineSeries,
    style::{Color, IntoFont, RGBColor, WHITE},
};

/// Distinct to colour-blind readers too (Okabe and Ito).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
const INK: RGBColor = RGBColor(60, 60, 60);
const FONT: &str = "sans-serif";
const WIDTH: u32 = 900;
const TRAJECTORY_HEIGHT: u32 = 220;
const DISTRIBUTION_HEIGHT: u32 = 320;
const BINS: usize = 48;

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// One line to draw: whose it is, and its points.
pub(super) struct Series<'a> {
    pub(super) name: &'a str,
    pub(super) points: Vec<(f64, f64)>,
}

fn svg(height: u32, draw: impl FnOnce(&Canvas<'_>) -> Drawn) -> String {
    let mut text = String::new();
    {
        let canvas = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        // Into a string nothing can fail but the drawing itself, and an incomplete picture is still shown.
        let _ = canvas.fill(&WHITE).and_then(|()| draw(&canvas)).and_then(|()| canvas.present());
    }
    text
}

/// Lines over time in seconds.
pub(super) fn trajectory(label: &str, series: &[Series<'_>]) -> String {
    svg(TRAJECTORY_HEIGHT, |canvas| {
        let finite = || series.iter().flat_map(|line| &line.points).filter(|(_, value)| value.is_finite());
        let end = finite().map(|point| point.0).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let (low, high) = spread(finite().map(|point| point.1));
        let mut chart = ChartBuilder::on(canvas)
            .margin(8)
            .x_label_area_size(36)
            .y_label_area_size(72)
            .build_cartesian_2d(0.0..end, low..high)?;
        chart
            .configure_mesh()
            .x_desc("time in s")
            .y_desc(label)
            .light_line_style(WHITE.mix(0.0))
            .label_style((FONT, 13))
            .axis_desc_style((FONT, 13))
            .draw()?;
        for (line, colour) in series.iter().zip(COLOURS.iter().cycle()) {
            let points = line.points.iter().copied().filter(|(_, value)| value.is_finite());
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(line.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
        }
        legend(&mut chart)
    })
}

/// Share of runs by cost, one outline per controller; the upper 1 % is left out so that a few runs do not squeeze the rest.
pub(super) fn distribution(series: &[(&str, &[f64])]) -> String {
    svg(DISTRIBUTION_HEIGHT, |canvas| {
        let costs =
            || series.iter().flat_map(|(_, costs)| costs.iter().copied()).filter(|cost| cost.is_finite());
        let upper = series
            .iter()
            .map(|(_, costs)| crate::monte_carlo::quantile(costs, 0.99))
            .filter(|cost| cost.is_finite())
            .fold(f64::MIN_POSITIVE, f64::max);
        let (low, high) = spread(costs().filter(|&cost| cost <= upper));
        let width = (high - low) / BINS as f64;
        let shares: Vec<Vec<f64>> = series
            .iter()
            .map(|(_, costs)| {
                let mut bins = vec![0.0; BINS];
                for cost in costs.iter().filter(|cost| (low..high).contains(*cost)) {
                    bins[(((cost - low) / width) as usize).min(BINS - 1)] += 100.0 / costs.len() as f64;
                }
                bins
            })
            .collect();
        let most = shares.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max) * 1.08;
        let mut chart = ChartBuilder::on(canvas)
            .margin(8)
            .x_label_area_size(40)
            .y_label_area_size(72)
            .build_cartesian_2d(low..high, 0.0..most)?;
        chart
            .configure_mesh()
            .x_desc("cost of a run")
            .y_desc("runs in %")
            .light_line_style(WHITE.mix(0.0))
            .label_style((FONT, 13))
            .axis_desc_style((FONT, 13))
            .draw()?;
        for (((name, _), bins), colour) in series.iter().zip(&shares).zip(COLOURS.iter().cycle()) {
            let bars = bins.iter().enumerate().map(|(bin, &share)| {
                let from = low + bin as f64 * width;
                Rectangle::new([(from, 0.0), (from + width, share)], colour.mix(0.35).filled())
            });
            chart.draw_series(bars)?.label(*name).legend(move |(x, y)| {
                Rectangle::new([(x, y - 5), (x + 14, y + 5)], colour.mix(0.6).filled())
            });
        }
        legend(&mut chart)
    })
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn legend<'b: 'a, 'a>(chart: &mut Chart<'a, 'b>) -> Drawn {
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.85))
        .border_style(INK.mix(0.3))
        .label_font((FONT, 13).into_font())
        .draw()
}

/// The values' range with a margin; never empty.
fn spread(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if !(low.is_finite() && high.is_finite()) {
        return (0.0, 1.0);
    }
    let margin = ((high - low) * 0.06).max(high.abs().max(low.abs()) * 1e-6).max(1e-12);
    (low - margin, high + margin)
}

/// One quantity of a recorded run over time.
pub(super) fn points(
    record: &[CycleRecord],
    sample_time: f64,
    value: impl Fn(&CycleRecord) -> f64,
) -> Vec<(f64, f64)> {
    record.iter().enumerate().map(|(cycle, entry)| (cycle as f64 * sample_time, value(entry))).collect()
}
