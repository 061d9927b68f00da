//! The line above a chart that says what is what.

use super::{Canvas, Drawn, INK, SOFT, font, px};
use plotters::{
    element::{Circle, PathElement, Polygon, Rectangle, Text},
    style::{
        Color, RGBColor,
        text_anchor::{HPos, Pos, VPos},
    },
};

/// Average width of a letter by its size: the backend cannot measure text.
const LETTER: f64 = 0.54;
const SIZE: f64 = 13.0;
const ROW: f64 = 18.0;
/// Of a row, above its lower edge.
const MIDDLE: f64 = 6.0;
const SWATCH: f64 = 20.0;
const GAP: f64 = 14.0;

/// How something is drawn.
#[derive(Clone, Copy)]
pub(crate) enum Swatch {
    Line(RGBColor),
    ThinLine,
    Dashes,
    DashedLine(RGBColor),
    Band(RGBColor),
    Bar(RGBColor),
    Marked(Mark, RGBColor),
    Dot(RGBColor),
    Lost,
    Unused,
}

/// Marks that are told apart without colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mark {
    Disc,
    Square,
    Triangle,
    Diamond,
    Ring,
    Cross,
}

impl Mark {
    pub(crate) const ALL: [Self; 6] =
        [Self::Disc, Self::Square, Self::Triangle, Self::Diamond, Self::Ring, Self::Cross];

    /// Draws it at a place in pixels.
    pub(super) fn draw(self, canvas: &Canvas<'_>, (x, y): (i32, i32), colour: RGBColor) -> Drawn {
        let r = px(4.0);
        let filled = |corners: Vec<(i32, i32)>| canvas.draw(&Polygon::new(corners, colour.filled()));
        match self {
            Self::Disc => canvas.draw(&Circle::new((x, y), r, colour.filled())),
            Self::Ring => canvas.draw(&Circle::new((x, y), r, colour.stroke_width(px(1.5) as u32))),
            Self::Square => canvas.draw(&Rectangle::new([(x - r, y - r), (x + r, y + r)], colour.filled())),
            Self::Triangle => {
                filled(vec![(x, y - r - r / 4), (x + r + r / 4, y + r), (x - r - r / 4, y + r)])
            }
            Self::Diamond => {
                filled(vec![(x, y - r - r / 3), (x + r + r / 3, y), (x, y + r + r / 3), (x - r - r / 3, y)])
            }
            Self::Cross => cross(canvas, (x, y), 4.0, colour),
        }
    }
}

/// Two strokes across each other.
pub(super) fn cross(canvas: &Canvas<'_>, (x, y): (i32, i32), half: f64, colour: RGBColor) -> Drawn {
    let (r, style) = (px(half), colour.stroke_width(px(2.0) as u32));
    canvas.draw(&PathElement::new([(x - r, y - r), (x + r, y + r)], style))?;
    canvas.draw(&PathElement::new([(x - r, y + r), (x + r, y - r)], style))
}

/// Width of `text` in units of length, about.
pub(super) fn width(text: &str, size: f64) -> f64 {
    LETTER * size * text.chars().count() as f64
}

/// Places in units of length for the title and each entry, and the height of them all.
fn places(title: &str, entries: &[(Swatch, String)], from: f64, to: f64) -> (Vec<(f64, f64)>, f64) {
    let indent = if title.is_empty() { from } else { from + 1.15 * width(title, SIZE) + GAP };
    let (mut x, mut y) = (indent, ROW);
    let mut places = Vec::with_capacity(entries.len());
    for (_, name) in entries {
        let length = SWATCH + 5.0 + width(name, SIZE);
        if x > from && x + length > to {
            (x, y) = (from, y + ROW);
        }
        places.push((x, y));
        x += length + GAP;
    }
    (places, y + 0.4 * ROW)
}

/// Height of the legend in units of length.
pub(super) fn height(title: &str, entries: &[(Swatch, String)], from: f64, to: f64) -> f64 {
    places(title, entries, from, to).1
}

/// Draws the title and the entries between `from` and `to`, in as many rows as it takes.
pub(super) fn draw(
    canvas: &Canvas<'_>,
    title: &str,
    entries: &[(Swatch, String)],
    from: f64,
    to: f64,
) -> Drawn {
    let left = Pos::new(HPos::Left, VPos::Center);
    if !title.is_empty() {
        let style = font(SIZE).style(plotters::style::FontStyle::Bold).color(&INK).pos(left);
        canvas.draw(&Text::new(title.to_string(), (px(from), px(ROW - MIDDLE)), style))?;
    }
    for ((swatch, name), (x, y)) in entries.iter().zip(places(title, entries, from, to).0) {
        self::swatch(canvas, *swatch, x, y - MIDDLE)?;
        let style = font(SIZE).color(&SOFT).pos(left);
        canvas.draw(&Text::new(name.clone(), (px(x + SWATCH + 5.0), px(y - MIDDLE)), style))?;
    }
    Ok(())
}

fn swatch(canvas: &Canvas<'_>, swatch: Swatch, x: f64, y: f64) -> Drawn {
    let line = |from: f64, to: f64, colour: RGBColor, width: f64| {
        let ends = [(px(x + from), px(y)), (px(x + to), px(y))];
        canvas.draw(&PathElement::new(ends, colour.stroke_width(px(width) as u32)))
    };
    let bar = |colour: RGBColor, share: f64| {
        let corners = [(px(x), px(y - 5.0)), (px(x + SWATCH), px(y + 5.0))];
        canvas.draw(&Rectangle::new(corners, colour.mix(share).filled()))
    };
    let middle = (px(x + SWATCH / 2.0), px(y));
    match swatch {
        Swatch::Line(colour) => line(0.0, SWATCH, colour, 2.0),
        Swatch::ThinLine => line(0.0, SWATCH, INK, 0.75),
        Swatch::Dashes => [0.0, 8.0, 16.0].into_iter().try_for_each(|at| line(at, at + 5.0, INK, 1.5)),
        Swatch::DashedLine(colour) => {
            [0.0, 8.0, 16.0].into_iter().try_for_each(|at| line(at, at + 5.0, colour, 2.0))
        }
        Swatch::Band(colour) => bar(colour, 0.25),
        Swatch::Bar(colour) => bar(colour, 1.0),
        Swatch::Marked(mark, colour) => {
            line(0.0, SWATCH, colour, 2.0)?;
            mark.draw(canvas, middle, colour)
        }
        Swatch::Dot(colour) => canvas.draw(&Circle::new(middle, px(3.5), colour.filled())),
        Swatch::Lost => cross(canvas, middle, 4.0, super::VERMILLION),
        Swatch::Unused => line(0.0, SWATCH, SOFT, 1.0),
    }
}
