//! What a node counted: figures with names, as a table for people and as one JSON object.

use super::clock::Due;
use serde::{Serialize, Serializer};
use std::{fmt::Write, time::Duration};

/// One figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Figure {
    /// How many.
    Count(u64),
    /// Seconds.
    Seconds(f64),
    /// A number in units of the design; `None` if there is none, or it is not finite.
    Number(Option<f64>),
    /// Cycles, with a sign.
    Cycles(i64),
    /// Yes or no.
    Flag(bool),
}

impl Serialize for Figure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::Count(count) => serializer.serialize_u64(count),
            Self::Seconds(value) => serializer.serialize_f64(value),
            Self::Number(value) => value.filter(|value| value.is_finite()).serialize(serializer),
            Self::Cycles(cycles) => serializer.serialize_i64(cycles),
            Self::Flag(flag) => serializer.serialize_bool(flag),
        }
    }
}

impl Figure {
    fn text(self) -> String {
        match self {
            Self::Count(count) => count.to_string(),
            Self::Seconds(value) => format!("{:.3} ms", 1e3 * value),
            Self::Number(Some(value)) if value == 0.0 || (1e-3..1e6).contains(&value.abs()) => {
                format!("{value:.5}")
            }
            Self::Number(Some(value)) if value.is_finite() => format!("{value:.4e}"),
            Self::Number(_) => "-".into(),
            Self::Cycles(0) => "0".into(),
            Self::Cycles(cycles) => format!("{cycles:+}"),
            Self::Flag(flag) => if flag { "yes" } else { "no" }.into(),
        }
    }
}

/// Figures that belong together, in the order they are printed in.
pub type Section = (&'static str, Vec<(&'static str, Figure)>);

/// All that a node has to say at its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// Which node.
    pub node: &'static str,
    /// Name of the design.
    pub name: String,
    /// Its figures.
    pub sections: Vec<Section>,
}

struct Ordered<'s>(&'s [(&'static str, Figure)]);

impl Serialize for Ordered<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(key, figure)| (key, figure)))
    }
}

impl Serialize for Statistics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("node", self.node)?;
        map.serialize_entry("name", &self.name)?;
        for (key, figures) in &self.sections {
            map.serialize_entry(key, &Ordered(figures))?;
        }
        map.end()
    }
}

impl Statistics {
    /// One JSON object and the end of a line.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("numbers and strings are always JSON") + "\n"
    }

    /// For people.
    pub fn table(&self) -> String {
        let mut text = format!("{} of {}\n", self.node, self.name);
        let width = self.sections.iter().flat_map(|(_, figures)| figures).map(|(key, _)| key.len()).max();
        for (section, figures) in &self.sections {
            let _ = writeln!(text, "\n{}", section.replace('_', " "));
            for (key, figure) in figures {
                let key = key.replace('_', " ");
                let _ = writeln!(text, "  {key:<width$}  {:>12}", figure.text(), width = width.unwrap_or(0));
            }
        }
        text
    }
}

/// Mean and worst of a stream of numbers that are not negative; 0 of none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mean {
    count: u64,
    sum: f64,
    worst: f64,
}

impl Mean {
    /// Takes one more.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value;
        self.worst = self.worst.max(value);
    }

    /// Their mean.
    pub fn mean(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.sum / self.count as f64 }
    }

    /// The largest.
    pub fn worst(&self) -> f64 {
        self.worst
    }
}

/// How punctual a node was.
#[derive(Debug, Clone)]
pub struct Punctuality {
    tolerance: f64,
    cycles: u64,
    misses: u64,
    skipped: u64,
    begun_anew: u64,
    lateness: Mean,
}

impl Punctuality {
    /// Of a node that is late from `tolerance` after its phase on.
    pub fn new(tolerance: Duration) -> Self {
        let tolerance = tolerance.as_secs_f64();
        Self { tolerance, cycles: 0, misses: 0, skipped: 0, begun_anew: 0, lateness: Mean::default() }
    }

    /// Takes note of what was due.
    pub fn note(&mut self, due: Due) {
        let late = match due {
            Due::Nothing => return,
            Due::Act { skipped, late, .. } => {
                self.skipped += skipped;
                late
            }
            Due::BeginAnew { late, .. } => {
                self.begun_anew += 1;
                late
            }
        };
        self.cycles += 1;
        self.misses += u64::from(late.as_secs_f64() > self.tolerance);
        self.lateness.add(late.as_secs_f64());
    }

    /// Cycles acted in.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// Cycles acted in too late, and cycles not acted in.
    pub fn misses(&self) -> u64 {
        self.misses + self.skipped
    }

    /// To print.
    pub fn section(&self) -> Section {
        let figures = vec![
            ("cycles", Figure::Count(self.cycles)),
            ("misses", Figure::Count(self.misses)),
            ("skipped", Figure::Count(self.skipped)),
            ("begun_anew", Figure::Count(self.begun_anew)),
            ("mean_lateness", Figure::Seconds(self.lateness.mean())),
            ("worst_lateness", Figure::Seconds(self.lateness.worst())),
        ];
        ("timing", figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_misses_what_it_does_beyond_its_tolerance_or_not_at_all() {
        let mut punctuality = Punctuality::new(Duration::from_millis(1));
        for (skipped, late) in [(0, 1), (0, 2), (3, 0)] {
            punctuality.note(Due::Act { skipped, cycle: 0, late: Duration::from_millis(late) });
        }
        punctuality.note(Due::Nothing);
        assert_eq!((punctuality.cycles(), punctuality.misses()), (3, 4));
        assert_eq!((punctuality.lateness.mean(), punctuality.lateness.worst()), (0.001, 0.002));
    }

    #[test]
    fn json_keeps_the_order_and_has_null_for_what_is_not_finite() {
        let sections =
            vec![("plant", vec![("norm", Figure::Number(Some(f64::NAN))), ("a", Figure::Count(3))])];
        let statistics = Statistics { node: "plant", name: "axis".into(), sections };
        let text: String = statistics.json().split_whitespace().collect();
        assert_eq!(text, r#"{"node":"plant","name":"axis","plant":{"norm":null,"a":3}}"#);
    }
}
