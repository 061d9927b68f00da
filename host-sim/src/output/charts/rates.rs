//! Shares of the cycles in which each controller sends.

use super::{Axis, Drawn, INK, PANEL, colour, font, plot, svg};
use plotters::{
    element::{Rectangle, Text},
    style::{
        Color,
        text_anchor::{HPos, Pos, VPos},
    },
};

const ROW: f64 = 34.0;

/// The chart: names and control frames sent per cycle, 0 to 1.
pub(crate) fn rates(series: &[(String, f64)]) -> String {
    let x = Axis::between("control frames sent, in % of the cycles", 0.0, 112.0);
    let y = Axis::rows("controller", series.len());
    svg(PANEL, 60.0 + ROW * series.len() as f64, |canvas| {
        plot(canvas, &x, &y, |chart| -> Drawn {
            let place = |number: usize| (series.len() - 1 - number) as f64;
            let bar = |(number, (_, rate)): (usize, &(String, f64))| {
                let corners = [(0.0, place(number) - 0.42), (100.0 * rate, place(number) + 0.02)];
                Rectangle::new(corners, colour(number).filled())
            };
            chart.draw_series(series.iter().enumerate().map(bar))?;
            let left = Pos::new(HPos::Left, VPos::Center);
            let name = |(number, (name, rate)): (usize, &(String, f64))| {
                let text = format!("{name}: {:.1} %", 100.0 * rate);
                Text::new(text, (1.0, place(number) + 0.24), font(12.5).color(&INK).pos(left))
            };
            chart.draw_series(series.iter().enumerate().map(name))?;
            Ok(())
        })
    })
}
