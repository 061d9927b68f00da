//! What became of every packet in the first cycles of a run: a sequence diagram of sensor, controller and actuator, and the
//! age of what was applied.
//!
//! `course` says what a packet did and whether that was of use, `arrow` draws it; here is what they stand in.

mod arrow;
mod course;

use super::{BLUE, Canvas, Drawn, FINE, GRID, INK, SOFT, Swatch, VERMILLION, font, legend, px, svg};
use crate::closed_loop::CycleRecord;
use course::{Course, tell_news};
use plotters::{
    element::{PathElement, Rectangle, Text},
    style::{
        Color, FontStyle, WHITE,
        text_anchor::{HPos, Pos, VPos},
    },
};
use slqg_links::loop_bus::Role;

/// Most cycles drawn.
pub(crate) const CYCLES: usize = 60;
const CELL: f64 = 16.0;
/// Room for the names of the rows.
const LEFT: f64 = 118.0;
const RIGHT: f64 = 14.0;
/// Least width: that of a legend in two rows.
const NARROWEST: f64 = 560.0;
/// Height of the first node below the legend, and from one node to the next.
const FIRST: f64 = 18.0;
const STRIDE: f64 = 74.0;
/// From the last node to the ages, height of those, and of the axis below.
const ASIDE: f64 = 14.0;
const AGES: f64 = 20.0;
const AXIS: f64 = 44.0;

/// A run to draw.
pub(crate) struct Ladder<'a> {
    pub(crate) title: &'a str,
    /// Cycles from cycle 0 on.
    pub(crate) run: &'a [CycleRecord],
    /// Most cycles a measurement may be late and still count.
    pub(crate) measurement_buffer: usize,
    /// N: the age from which on the actuator applies its default input.
    pub(crate) sequence_length: usize,
    /// Cycles that an acknowledgement tells of; `None`: they have no link, and there is nothing to draw.
    pub(crate) acknowledged_cycles: Option<usize>,
}

/// Packets from one node to the next.
struct Lane {
    name: &'static str,
    /// By the cycle they are sent in.
    courses: Vec<Option<Course>>,
}

impl Ladder<'_> {
    fn cycles(&self) -> usize {
        self.run.len().min(CYCLES)
    }

    /// Whether an input of the sequence that was sent in `cycle` was ever applied.
    fn was_applied(&self, cycle: usize) -> bool {
        let reach = self.run.iter().enumerate().skip(cycle).take(self.sequence_length);
        reach.into_iter().any(|(at, record)| record.age == Some(at - cycle))
    }

    /// From the top: sensor to controller, controller to actuator, and back to the controller.
    fn lanes(&self) -> Vec<Lane> {
        let drawn = || self.run[..self.cycles()].iter().enumerate();
        let measurement = |(sent, record): (usize, &CycleRecord)| {
            let is_used = |delay| delay <= self.measurement_buffer;
            Some(Course::of(self.run, Role::Measurement, sent, record.measurement_frame?, is_used))
        };
        let sequence = |(sent, record): (usize, &CycleRecord)| {
            let is_used = |_| self.was_applied(sent);
            Some(Course::of(self.run, Role::Control, sent, record.control_frame?, is_used))
        };
        let mut lanes = vec![
            Lane { name: "measurements", courses: drawn().map(measurement).collect() },
            Lane { name: "sequences", courses: drawn().map(sequence).collect() },
        ];
        if let Some(cycles) = self.acknowledged_cycles {
            let news = tell_news(self.run, cycles);
            let told = |(sent, record): (usize, &CycleRecord)| {
                let fate = record.acknowledgement_frame?;
                Some(Course::of(self.run, Role::Acknowledgement, sent, fate, |_| news[sent]))
            };
            lanes.push(Lane { name: "acknowledgements", courses: drawn().map(told).collect() });
        }
        lanes
    }
}

/// Height of a node below the legend.
fn node(number: usize) -> f64 {
    FIRST + STRIDE * number as f64
}

/// The diagram.
pub(crate) fn packets(of: &Ladder<'_>) -> String {
    let (cycles, lanes) = (of.cycles(), of.lanes());
    let mut entries = vec![
        (Swatch::Dot(BLUE), "sent".to_string()),
        (Swatch::Line(BLUE), "arrived and used; slanted: late".into()),
        (Swatch::Unused, "arrived, never used".into()),
        (Swatch::Lost, "lost".into()),
    ];
    if lanes.iter().flat_map(|lane| lane.courses.iter().flatten()).any(Course::has_copies) {
        entries.push((Swatch::Dashes, "copy made by the link".into()));
    }
    let width = (LEFT + CELL * cycles as f64 + RIGHT).max(NARROWEST);
    let above = legend::height(of.title, &entries, 8.0, width);
    let ages = node(lanes.len()) + ASIDE;
    svg(width, above + ages + AGES + AXIS, |canvas| {
        legend::draw(canvas, of.title, &entries, 8.0, width)?;
        let (_, below) = canvas.split_vertically(px(above));
        nodes(&below, cycles, &lanes, ages)?;
        for (number, lane) in lanes.iter().enumerate() {
            let ends = (node(number), node(number + 1));
            for (cycle, course) in lane.courses.iter().enumerate() {
                if let Some(course) = course {
                    arrow::draw(&below, cycles, cycle, course, ends)?;
                }
            }
        }
        for (cycle, record) in of.run[..cycles].iter().enumerate() {
            age(&below, (cycle, ages), record.age, of.sequence_length)?;
        }
        axis(&below, cycles, ages + AGES)
    })
}

/// Middle of a cycle.
fn x(cycle: usize) -> f64 {
    LEFT + CELL * (cycle as f64 + 0.5)
}

fn nodes(canvas: &Canvas<'_>, cycles: usize, lanes: &[Lane], ages: f64) -> Drawn {
    let end = LEFT + CELL * cycles as f64;
    for cycle in (0..cycles).step_by(5) {
        let line = [(px(x(cycle)), px(FIRST - 6.0)), (px(x(cycle)), px(ages))];
        canvas.draw(&PathElement::new(line, GRID.stroke_width(FINE)))?;
    }
    let right = Pos::new(HPos::Right, VPos::Center);
    let name = |y: f64, name: &'static str| {
        canvas.draw(&Text::new(name, (px(LEFT - 6.0), px(y)), font(11.5).color(&INK).pos(right)))
    };
    // The controller stands on both sides of the actuator: what is sent to it does not cross what it sends.
    for (number, node_name) in
        ["sensor", "controller", "actuator", "controller"].into_iter().enumerate().take(lanes.len() + 1)
    {
        name(node(number), node_name)?;
        let line = [(px(LEFT), px(node(number))), (px(end), px(node(number)))];
        canvas.draw(&PathElement::new(line, SOFT.stroke_width(FINE)))?;
    }
    for (number, lane) in lanes.iter().enumerate() {
        let at = (px(LEFT - 6.0), px(node(number) + STRIDE / 2.0));
        canvas.draw(&Text::new(lane.name, at, font(10.5).color(&SOFT).pos(right)))?;
    }
    name(ages + AGES / 2.0, "age in cycles")
}

fn age(canvas: &Canvas<'_>, (cycle, top): (usize, f64), age: Option<usize>, length: usize) -> Drawn {
    let corners = |inset: f64| {
        [
            (px(x(cycle) - CELL / 2.0 + inset), px(top + inset)),
            (px(x(cycle) + CELL / 2.0 - inset), px(top + AGES - inset)),
        ]
    };
    let centre = (px(x(cycle)), px(top + AGES / 2.0));
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

fn axis(canvas: &Canvas<'_>, cycles: usize, top: f64) -> Drawn {
    let centre = Pos::new(HPos::Center, VPos::Top);
    for cycle in (0..cycles).step_by(5) {
        let style = font(11.5).color(&INK).pos(centre);
        canvas.draw(&Text::new(cycle.to_string(), (px(x(cycle)), px(top + 5.0)), style))?;
    }
    let style = font(12.0).color(&SOFT).pos(Pos::new(HPos::Left, VPos::Top));
    let label = "cycle; D: the default input, as no sequence reached so far";
    canvas.draw(&Text::new(label, (px(LEFT), px(top + 22.0)), style))
}
