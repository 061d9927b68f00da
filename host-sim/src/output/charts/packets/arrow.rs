//! One packet as it is drawn: a dot where it is sent, and lines to where it and its copies arrive, or are lost.

use super::{
    super::{BLUE, Canvas, Drawn, FINE, SOFT, VERMILLION, legend, px},
    CELL,
    course::{Course, Leg},
    x,
};
use plotters::{
    element::{Circle, PathElement, Polygon},
    style::{Color, RGBColor},
};

/// How far between two nodes a lost packet comes.
const HALF_WAY: f64 = 0.45;
/// A dash of the line of a copy, and a dash with the gap behind it.
const DASH: f64 = 4.0;
const PERIOD: f64 = 7.0;

/// The packet that is sent in `cycle` from one height to another, in a diagram of `cycles` cycles.
pub(super) fn draw(
    canvas: &Canvas<'_>,
    cycles: usize,
    cycle: usize,
    course: &Course,
    (from, to): (f64, f64),
) -> Drawn {
    let start = (px(x(cycle)), px(from));
    let colour = match course {
        Course::Lost => {
            let end = (px(x(cycle)), px(from + HALF_WAY * (to - from)));
            canvas.draw(&PathElement::new([start, end], VERMILLION.stroke_width(FINE)))?;
            legend::cross(canvas, end, 3.5, VERMILLION)?;
            VERMILLION
        }
        Course::Open => SOFT,
        Course::Arrived(legs) => {
            // What is used lies above what is not.
            for leg in legs.iter().filter(|leg| !leg.is_used).chain(legs.iter().filter(|leg| leg.is_used)) {
                arrow(canvas, cycles, cycle, *leg, (from, to))?;
            }
            if legs.iter().any(|leg| leg.is_used) { BLUE } else { SOFT }
        }
    };
    canvas.draw(&Circle::new(start, px(3.0), colour.filled()))
}

fn arrow(canvas: &Canvas<'_>, cycles: usize, cycle: usize, leg: Leg, (from, to): (f64, f64)) -> Drawn {
    let (colour, width) = if leg.is_used { (BLUE, 1.5) } else { (SOFT, 0.75) };
    // What arrives after the last cycle drawn ends at its edge, on its way.
    let shown = (leg.delay as f64).min((cycles - cycle) as f64 - 0.5);
    let share = if leg.delay == 0 { 1.0 } else { shown / leg.delay as f64 };
    let along = (CELL * shown, share * (to - from));
    let at = |share: f64| (px(x(cycle) + share * along.0), px(from + share * along.1));
    let style = colour.stroke_width(px(width) as u32);
    let length = along.0.hypot(along.1);
    let dashes = if leg.is_copy { (length / PERIOD).ceil() as usize } else { 1 };
    for dash in 0..dashes {
        let begin = dash as f64 * PERIOD / length;
        let end = if leg.is_copy { (begin + DASH / length).min(1.0) } else { 1.0 };
        canvas.draw(&PathElement::new([at(begin), at(end)], style))?;
    }
    if share == 1.0 {
        head(canvas, at(0.0), at(1.0), colour)?;
    }
    Ok(())
}

/// The head of an arrow.
fn head(canvas: &Canvas<'_>, start: (i32, i32), end: (i32, i32), colour: RGBColor) -> Drawn {
    let along = (f64::from(end.0 - start.0), f64::from(end.1 - start.1));
    let length = along.0.hypot(along.1);
    let (length_of_head, half) = (f64::from(px(7.0)) / length, f64::from(px(3.0)) / length);
    let corner = |side: f64| {
        let at = |end: i32, along: f64, across: f64| {
            end - (length_of_head * along - side * half * across).round() as i32
        };
        (at(end.0, along.0, -along.1), at(end.1, along.1, along.0))
    };
    canvas.draw(&Polygon::new(vec![end, corner(1.0), corner(-1.0)], colour.filled()))
}
