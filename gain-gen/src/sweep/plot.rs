//! The sweep as a picture: cost, rate and size of the tables over the length, one below the other, as SVG.

use super::{LengthFigures, Sweep};
use plotters::{
    backend::SVGBackend,
    chart::{ChartBuilder, SeriesLabelPosition},
    coord::{
        Shift,
        ranged1d::{AsRangedCoord, ValueFormatter},
    },
    drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea},
    element::{Circle, PathElement},
    prelude::{IntoLogRange, Ranged},
    series::LineSeries,
    style::{Color, RGBColor, WHITE},
};
use slqg::DefaultInput;
use std::ops::Range;

/// Distinct to colour-blind readers too (Okabe and Ito).
const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(204, 121, 167)];
const INK: RGBColor = RGBColor(60, 60, 60);
const FONT: (&str, u32) = ("sans-serif", 13);
/// Width and height in pixels.
const SIZE: (u32, u32) = (900, 900);
const PANELS: usize = 3;

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// One line: what it shows, and its points.
struct Series {
    name: String,
    points: Vec<(usize, f64)>,
}

/// One of the pictures: what it shows, and where the legend leaves the lines free.
struct Panel {
    label: &'static str,
    series: Vec<Series>,
    legend: SeriesLabelPosition,
}

impl Sweep {
    /// Three panels over the length `N`: cost per step, mean-square rate per step, bytes of the tables.
    ///
    /// Lengths without a finite cost have no point in the first panel.
    pub fn to_svg(&self) -> String {
        let mut text = String::new();
        {
            let canvas = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
            // Into a string nothing can fail but the drawing itself, and an incomplete picture is still shown.
            let _ = canvas.fill(&WHITE).and_then(|()| self.draw(&canvas)).and_then(|()| canvas.present());
        }
        text
    }

    fn draw(&self, canvas: &Canvas<'_>) -> Drawn {
        let title = format!("{}: what each sequence length brings", self.name.escape_debug());
        let canvas = canvas.titled(&title, ("sans-serif", 18))?;
        let panels = canvas.split_evenly((PANELS, 1));
        let lengths = self.results.iter().map(|figures| figures.sequence_length);
        let (first, last) = lengths.fold((usize::MAX, 0), |(low, high), n| (low.min(n), high.max(n)));
        // A margin of one length on both sides, so that no point lies on the frame.
        let range = first.saturating_sub(1)..last + 1;

        let costs = Panel {
            label: "cost per step, tr(P W)",
            series: self.per_default_input("", |figures| figures.control_cost),
            legend: SeriesLabelPosition::UpperRight,
        };
        costs.draw(&panels[0], range.clone(), decades(&costs.series).log_scale())?;
        let rates = Panel {
            label: "rate per step, stable below 1",
            series: self.per_default_input("", |figures| figures.mean_square_rate),
            legend: SeriesLabelPosition::UpperRight,
        };
        rates.draw(&panels[1], range.clone(), spread(&rates.series))?;
        let size = |prefix, floats: fn(&LengthFigures) -> usize| {
            self.per_default_input(prefix, |figures| self.bytes(floats(figures)) as f64)
        };
        let sizes = Panel {
            label: "tables in bytes",
            series: [
                size("Lx, M, r, ", |figures| figures.table_floats),
                size("coupled form, ", |figures| figures.coupled_table_floats),
            ]
            .into_iter()
            .flatten()
            .collect(),
            legend: SeriesLabelPosition::UpperLeft,
        };
        sizes.draw(&panels[2], range, decades(&sizes.series).log_scale())
    }

    /// One line for each default input; points that are not finite are left out.
    fn per_default_input(&self, prefix: &str, value: impl Fn(&LengthFigures) -> f64) -> Vec<Series> {
        let of = |input: DefaultInput| {
            let own = self.results.iter().filter(move |figures| figures.default_input == input);
            let points = own.map(|figures| (figures.sequence_length, value(figures)));
            points.filter(|(_, value)| value.is_finite()).collect()
        };
        let named = |&input: &DefaultInput| Series {
            name: format!("{prefix}default input {}", input.name()),
            points: of(input),
        };
        self.default_inputs.iter().map(named).collect()
    }
}

impl Panel {
    /// Axes, lines and legend; `values` is the vertical axis.
    fn draw<Y>(&self, canvas: &Canvas<'_>, lengths: Range<usize>, values: Y) -> Drawn
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut chart = ChartBuilder::on(canvas)
            .margin(10)
            .x_label_area_size(38)
            .y_label_area_size(84)
            .build_cartesian_2d(lengths, values)?;
        chart
            .configure_mesh()
            .x_desc("inputs per packet, N")
            .y_desc(self.label)
            .light_line_style(WHITE.mix(0.0))
            .label_style(FONT)
            .axis_desc_style(FONT)
            .draw()?;
        for (line, colour) in self.series.iter().zip(COLOURS) {
            chart
                .draw_series(LineSeries::new(line.points.iter().copied(), colour.stroke_width(2)))?
                .label(&line.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
            chart.draw_series(line.points.iter().map(|&point| Circle::new(point, 3, colour.filled())))?;
        }
        chart
            .configure_series_labels()
            .position(self.legend.clone())
            .background_style(WHITE.mix(0.85))
            .border_style(INK.mix(0.3))
            .label_font(FONT)
            .draw()
    }
}

/// The values' range with a margin; never empty.
fn spread(series: &[Series]) -> Range<f64> {
    let (low, high) = extremes(series, f64::NEG_INFINITY);
    let margin = (0.06 * (high - low)).max(0.01 * high.abs()).max(f64::MIN_POSITIVE);
    low - margin..high + margin
}

/// The range of the positive values with a margin, for a logarithmic axis; never empty.
fn decades(series: &[Series]) -> Range<f64> {
    let (low, high) = extremes(series, f64::MIN_POSITIVE);
    let margin = (high / low).powf(0.06).max(1.1);
    low / margin..high * margin
}

/// Least and greatest of the values from `least` on; 1 if there are none.
fn extremes(series: &[Series], least: f64) -> (f64, f64) {
    let values = series.iter().flat_map(|line| &line.points).map(|point| point.1);
    values
        .filter(|value| *value >= least)
        .map(|value| (value, value))
        .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)))
        .unwrap_or((1.0, 1.0))
}
