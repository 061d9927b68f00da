//! What became of every packet in the first cycles of a run: a sequence diagram of sensor, controller and actuator, and the
//! age of what was applied.

use super::{BLUE, Canvas, Drawn, FINE, GRID, INK, SOFT, Swatch, VERMILLION, font, legend, px, svg};
use crate::closed_loop::CycleRecord;
use plotters::{
    element::{Circle, PathElement, Polygon, Rectangle, Text},
    style::{
        Color, FontStyle, WHITE,
        text_anchor::{HPos, Pos, VPos},
    },
};
use slqg_links::path::Fate;

/// Most cycles drawn.
pub(crate) const CYCLES: usize = 60;
const CELL: f64 = 16.0;
/// Room for the names of the rows.
const LEFT: f64 = 84.0;
const RIGHT: f64 = 14.0;
/// Heights of the three nodes, of the ages and of the axis.
const SENSOR: f64 = 44.0;
const CONTROLLER: f64 = 118.0;
const ACTUATOR: f64 = 192.0;
const AGES: f64 = 206.0;
const AGES_END: f64 = 226.0;
const BOTTOM: f64 = 270.0;
/// How far between two nodes a lost packet comes.
const HALF_WAY: f64 = 0.45;

/// A run to draw.
pub(crate) struct Ladder<'a> {
    pub(crate) title: &'a str,
    /// Cycles from cycle 0 on.
    pub(crate) run: &'a [CycleRecord],
    /// Most cycles a measurement may be late and still count.
    pub(crate) measurement_buffer: usize,
    /// N: the age from which on the actuator applies its default input.
    pub(crate) sequence_length: usize,
}

impl Ladder<'_> {
    fn cycles(&self) -> &[CycleRecord] {
        &self.run[..self.run.len().min(CYCLES)]
    }

    /// Whether an input of the sequence that was sent in `cycle` was ever applied.
    fn was_applied(&self, cycle: usize) -> bool {
        let reach = self.run.iter().enumerate().skip(cycle).take(self.sequence_length);
        reach.into_iter().any(|(at, record)| record.age == Some(at - cycle))
    }
}

/// The diagram.
pub(crate) fn packets(of: &Ladder<'_>) -> String {
    let cycles = of.cycles();
    let width = LEFT + CELL * cycles.len() as f64 + RIGHT;
    svg(width.max(560.0), BOTTOM, |canvas| {
        let entries = [
            (Swatch::Dot(BLUE), "sent".to_string()),
            (Swatch::Line(BLUE), "arrived and used; slanted: late".into()),
            (Swatch::Unused, "arrived, never used".into()),
            (Swatch::Lost, "lost".into()),
        ];
        legend::draw(canvas, of.title, &entries, 8.0, width.max(560.0))?;
        nodes(canvas, cycles.len())?;
        for (cycle, record) in cycles.iter().enumerate() {
            if let Some(fate) = record.measurement_frame {
                let counts = |delay| delay <= of.measurement_buffer;
                packet(canvas, cycles.len(), cycle, fate, (SENSOR, CONTROLLER), counts)?;
            }
            if let Some(fate) = record.control_frame {
                let counts = |_| of.was_applied(cycle);
                packet(canvas, cycles.len(), cycle, fate, (CONTROLLER, ACTUATOR), counts)?;
            }
            age(canvas, cycle, record.age, of.sequence_length)?;
        }
        axis(canvas, cycles.len())
    })
}

/// Middle of a cycle.
fn x(cycle: usize) -> f64 {
    LEFT + CELL * (cycle as f64 + 0.5)
}

fn nodes(canvas: &Canvas<'_>, cycles: usize) -> Drawn {
    let end = LEFT + CELL * cycles as f64;
    for cycle in (0..cycles).step_by(5) {
        let line = [(px(x(cycle)), px(SENSOR - 6.0)), (px(x(cycle)), px(AGES))];
        canvas.draw(&PathElement::new(line, GRID.stroke_width(FINE)))?;
    }
    let right = Pos::new(HPos::Right, VPos::Center);
    let names = [
        (SENSOR, "sensor"),
        (CONTROLLER, "controller"),
        (ACTUATOR, "actuator"),
        ((AGES + AGES_END) / 2.0, "age in cycles"),
    ];
    for (y, name) in names {
        canvas.draw(&Text::new(name, (px(LEFT - 6.0), px(y)), font(11.5).color(&INK).pos(right)))?;
        if y < AGES {
            let line = [(px(LEFT), px(y)), (px(end), px(y))];
            canvas.draw(&PathElement::new(line, SOFT.stroke_width(FINE)))?;
        }
    }
    Ok(())
}

fn packet(
    canvas: &Canvas<'_>,
    cycles: usize,
    cycle: usize,
    fate: Fate,
    (from, to): (f64, f64),
    is_used: impl Fn(usize) -> bool,
) -> Drawn {
    let start = (px(x(cycle)), px(from));
    let colour = match fate {
        Fate::Lost => {
            let end = (px(x(cycle)), px(from + HALF_WAY * (to - from)));
            canvas.draw(&PathElement::new([start, end], VERMILLION.stroke_width(FINE)))?;
            legend::cross(canvas, end, 3.5, VERMILLION)?;
            VERMILLION
        }
        Fate::Open => SOFT,
        Fate::Delayed(delay) => {
            let (colour, width) = match is_used(delay) {
                true => (BLUE, 1.5),
                false => (SOFT, 0.75),
            };
            // What arrives after the last cycle drawn ends at its edge, on its way.
            let shown = (delay as f64).min((cycles - cycle) as f64 - 0.5);
            let share = if delay == 0 { 1.0 } else { shown / delay as f64 };
            let end = (px(x(cycle) + CELL * shown), px(from + share * (to - from)));
            canvas.draw(&PathElement::new([start, end], colour.stroke_width(px(width) as u32)))?;
            if share == 1.0 {
                head(canvas, start, end, colour)?;
            }
            colour
        }
    };
    canvas.draw(&Circle::new(start, px(3.0), colour.filled()))
}

/// The head of an arrow.
fn head(canvas: &Canvas<'_>, start: (i32, i32), end: (i32, i32), colour: plotters::style::RGBColor) -> Drawn {
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

fn age(canvas: &Canvas<'_>, cycle: usize, age: Option<usize>, length: usize) -> Drawn {
    let corners = |inset: f64| {
        [
            (px(x(cycle) - CELL / 2.0 + inset), px(AGES + inset)),
            (px(x(cycle) + CELL / 2.0 - inset), px(AGES_END - inset)),
        ]
    };
    let centre = (px(x(cycle)), px((AGES + AGES_END) / 2.0));
    let text = |text: String, size: f64| {
        let style = font(size).color(&INK).pos(Pos::new(HPos::Center, VPos::Center));
        canvas.draw(&Text::new(text, centre, style))
    };
    match age {
        Some(age) => {
            let share = 0.08 + 0.4 * age as f64 / length.max(1) as f64;
            canvas.draw(&Rectangle::new(corners(0.5), BLUE.mix(share).filled()))?;
            text(age.to_string(), if age < 100 { 11.0 } else { 8.5 })
        }
        None => {
            canvas.draw(&Rectangle::new(corners(0.5), VERMILLION.filled()))?;
            canvas.draw(&Rectangle::new(corners(2.5), WHITE.filled()))?;
            let style =
                font(11.0).style(FontStyle::Bold).color(&INK).pos(Pos::new(HPos::Center, VPos::Center));
            canvas.draw(&Text::new("D", centre, style))
        }
    }
}

fn axis(canvas: &Canvas<'_>, cycles: usize) -> Drawn {
    let centre = Pos::new(HPos::Center, VPos::Top);
    for cycle in (0..cycles).step_by(5) {
        let style = font(11.5).color(&INK).pos(centre);
        canvas.draw(&Text::new(cycle.to_string(), (px(x(cycle)), px(AGES_END + 5.0)), style))?;
    }
    let style = font(12.0).color(&SOFT).pos(Pos::new(HPos::Left, VPos::Top));
    let label = "cycle; D: the default input, as no sequence reached so far";
    canvas.draw(&Text::new(label, (px(LEFT), px(AGES_END + 22.0)), style))
}
