//! Charts as SVG: black on white with the colours of Okabe and Ito, which colour-blind readers tell apart.
//!
//! One file per kind of chart; here is what they share: the canvas, the colours, a plot between two axes. Nothing is told
//! by colour alone. A page may give the colours listed here others, for a dark screen.

mod axis;
mod bars;
mod distribution;
mod legend;
mod lengths;
mod overlay;
mod packets;
mod rates;
mod size;
mod trajectory;

pub(super) use axis::Axis;
pub(super) use bars::{Bars, bars};
pub(super) use distribution::distribution;
pub(super) use legend::Mark;
pub(super) use lengths::against_length;
pub(crate) use lengths::{Curve, Start, against};
pub(crate) use overlay::{Quantity, overlay};
pub(super) use packets::{Ladder, packets};
pub(super) use rates::rates;
pub(crate) use size::{in_units, sized};
pub(super) use trajectory::{Trajectory, trajectory};

use legend::Swatch;
use plotters::{
    backend::SVGBackend,
    chart::{ChartBuilder, ChartContext},
    coord::{Shift, cartesian::Cartesian2d},
    drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea},
    style::{Color, FontDesc, FontFamily, FontStyle, RGBColor, WHITE},
};

const BLUE: RGBColor = RGBColor(0, 114, 178);
const VERMILLION: RGBColor = RGBColor(213, 94, 0);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const PURPLE: RGBColor = RGBColor(204, 121, 167);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
const SKY: RGBColor = RGBColor(86, 180, 233);
const COLOURS: [RGBColor; 6] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY];
/// Axes and titles.
const INK: RGBColor = RGBColor(26, 26, 26);
/// Names of axes, and what matters less.
const SOFT: RGBColor = RGBColor(85, 85, 85);
const GRID: RGBColor = RGBColor(221, 221, 221);

/// Pixels per unit of length: the backend draws on whole pixels, and one of them is then too fine to be seen.
pub(super) const FINE: u32 = 4;
/// Width of a chart that stands beside others, in units of length.
const PANEL: f64 = 460.0;

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'c, 'a> = ChartContext<'c, SVGBackend<'a>, Cartesian2d<Axis, Axis>>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// The colour of the series with this number.
fn colour(series: usize) -> RGBColor {
    COLOURS[series % COLOURS.len()]
}

/// Units of length in pixels.
fn px(units: f64) -> i32 {
    (units * f64::from(FINE)).round() as i32
}

/// A font of this size in units of length.
fn font(size: f64) -> FontDesc<'static> {
    // The backend writes a smaller size than it is given, by this factor.
    const SHRUNK: f64 = 1.24;
    FontDesc::new(FontFamily::SansSerif, size * f64::from(FINE) * SHRUNK, FontStyle::Normal)
}

/// A picture of this size in units of length.
fn svg(width: f64, height: f64, draw: impl FnOnce(&Canvas<'_>) -> Drawn) -> String {
    let mut text = String::new();
    {
        let size = (px(width) as u32, px(height) as u32);
        let canvas = SVGBackend::with_string(&mut text, size).into_drawing_area();
        // Into a string nothing can fail but the drawing itself, and an incomplete picture is still shown.
        let _ = canvas.fill(&WHITE).and_then(|()| draw(&canvas)).and_then(|()| canvas.present());
    }
    text
}

/// A chart as wide as a panel with a legend above: `height` is that of the rest.
fn panel(
    title: &str,
    entries: &[(Swatch, String)],
    height: f64,
    draw: impl FnOnce(&Canvas<'_>) -> Drawn,
) -> String {
    const SIDE: f64 = 8.0;
    let above = legend::height(title, entries, SIDE, PANEL - SIDE);
    svg(PANEL, above + height, |canvas| {
        legend::draw(canvas, title, entries, SIDE, PANEL - SIDE)?;
        let (_, below) = canvas.split_vertically(px(above));
        draw(&below)
    })
}

/// The two axes on all of `canvas`, and on them what `draw` draws.
fn plot<'a>(
    canvas: &Canvas<'a>,
    x: &Axis,
    y: &Axis,
    draw: impl FnOnce(&mut Chart<'_, 'a>) -> Drawn,
) -> Drawn {
    let mut chart = ChartBuilder::on(canvas)
        .margin_top(px(5.0))
        .margin_right(px(16.0))
        .margin_bottom(px(4.0))
        .margin_left(px(4.0))
        .x_label_area_size(px(40.0))
        .y_label_area_size(px(66.0))
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .x_desc(&x.label)
        .y_desc(&y.label)
        .set_all_tick_mark_size(px(4.0))
        .axis_style(INK.stroke_width(FINE))
        .bold_line_style(GRID.stroke_width(FINE))
        .light_line_style(WHITE.mix(0.0))
        .label_style(font(12.5).color(&INK))
        .axis_desc_style(font(13.0).color(&SOFT))
        .draw()?;
    draw(&mut chart)
}
