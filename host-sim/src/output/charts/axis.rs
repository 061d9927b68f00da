//! [`Axis`]: the range of a chart in one direction, its ticks and what they are called.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// Ratio of the largest to the smallest value above which a linear axis hides the small ones.
const DECADES: f64 = 30.0;
/// Beyond this size values are no longer drawn: differences of them would not be finite.
const LARGEST: f64 = 1e150;
/// Share of a range that is left free at each end.
const MARGIN: f64 = 0.05;

/// One axis of a chart.
#[derive(Clone)]
pub(crate) struct Axis {
    /// What it shows, with the unit.
    pub(super) label: String,
    /// Least coordinate.
    pub(super) low: f64,
    /// Greatest coordinate, above `low`.
    pub(super) high: f64,
    ticks: Vec<(f64, String)>,
    is_logarithmic: bool,
}

impl Axis {
    /// A linear axis that shows all of `values`, with a margin.
    pub(crate) fn linear(label: impl Into<String>, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = range(values).unwrap_or((0.0, 1.0));
        let margin = (MARGIN * (high - low)).max(1e-6 * high.abs().max(low.abs())).max(1e-12);
        Self::between(label, low - margin, high + margin)
    }

    /// A linear axis from 0 that shows all of `values`, none of them negative.
    pub(crate) fn from_zero(label: impl Into<String>, values: impl Iterator<Item = f64>) -> Self {
        let high = range(values).map_or(1.0, |(_, high)| high).max(1e-12);
        Self::between(label, 0.0, high * (1.0 + MARGIN))
    }

    /// A linear axis with these ends.
    pub(crate) fn between(label: impl Into<String>, low: f64, high: f64) -> Self {
        let step = step((high - low) / 5.0);
        let ticks = multiples(low, high, step).map(|value| (value, spelled(value, step))).collect();
        Self { label: label.into(), low, high, ticks, is_logarithmic: false }
    }

    /// An axis of whole numbers, of which about `most` are named.
    pub(crate) fn whole(label: impl Into<String>, first: usize, last: usize, most: usize) -> Self {
        let (low, high) = (first as f64, last as f64);
        let step = step((high - low) / most as f64).max(1.0).round();
        let ticks = multiples(low, high, step).map(|value| (value, format!("{value}"))).collect();
        Self { label: label.into(), low: low - 0.5, high: high + 0.5, ticks, is_logarithmic: false }
    }

    /// An axis that shows all of `values`: logarithmic where they are positive and span decades, otherwise linear.
    pub(crate) fn fitting(label: &str, values: &[f64]) -> Self {
        let Some((low, high)) =
            range(values.iter().copied()).filter(|&(low, high)| low > 0.0 && high > DECADES * low)
        else {
            return Self::linear(label, values.iter().copied());
        };
        let (low, high) = (low.log10(), high.log10());
        let margin = MARGIN * (high - low);
        let (low, high) = (low - margin, high + margin);
        let step = ((high - low) / 6.0).ceil().max(1.0);
        let ticks = multiples(low, high, step).map(|value| (value, power(value))).collect();
        Self { label: format!("{label}, log"), low, high, ticks, is_logarithmic: true }
    }

    /// An axis of `count` rows that are named where they are.
    pub(crate) fn rows(label: impl Into<String>, count: usize) -> Self {
        Self {
            label: label.into(),
            low: -0.5,
            high: count as f64 - 0.5,
            ticks: Vec::new(),
            is_logarithmic: false,
        }
    }

    /// Adds a place with a name of its own behind the last.
    pub(crate) fn append(&mut self, place: f64, name: &str) {
        self.ticks.push((place, name.into()));
        self.high = place + 0.5;
    }

    /// Where `value` is on the axis; `None` if it cannot be shown.
    pub(crate) fn at(&self, value: f64) -> Option<f64> {
        let place = if self.is_logarithmic { value.log10() } else { value };
        (place.is_finite() && place.abs() < LARGEST).then(|| place.clamp(self.low, self.high))
    }

    /// From one end to the other.
    pub(crate) fn length(&self) -> f64 {
        self.high - self.low
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (place - self.low) / self.length();
        from + (share * f64::from(to - from)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, _: H) -> Vec<f64> {
        self.ticks.iter().map(|(place, _)| *place).collect()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, place: &f64) -> String {
        let named = self.ticks.iter().find(|(tick, _)| tick == place);
        named.map(|(_, name)| name.clone()).unwrap_or_default()
    }
}

/// Least and greatest of the values that can be drawn.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.abs() < LARGEST).fold(None, |range, value| match range {
        None => Some((value, value)),
        Some((low, high)) => Some((value.min(low), value.max(high))),
    })
}

/// The next of 1, 2 and 5 times a power of ten.
fn step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0]
        .map(|factor| factor * power)
        .into_iter()
        .find(|step| *step >= least)
        .unwrap_or(10.0 * power)
}

fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(move |count| count as f64 * step)
}

/// `value`, a multiple of `step`, with as many digits as tell it from its neighbours.
fn spelled(value: f64, step: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        let digits = (value.abs().log10().floor() - step.log10().floor()).max(0.0) as usize;
        return format!("{value:.digits$e}");
    }
    let decimals = (-step.log10().floor()).clamp(0.0, 8.0) as usize;
    format!("{value:.decimals$}")
}

fn power(exponent: f64) -> String {
    match exponent {
        -2.0..=4.0 => format!("{}", 10_f64.powf(exponent)),
        _ => format!("1e{exponent}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, name)| name.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_numbers_with_the_digits_they_need() {
        assert_eq!(names(&Axis::between("", 0.0, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(names(&Axis::between("", -70.0, 120.0)), ["-50", "0", "50", "100"]);
        assert_eq!(names(&Axis::between("", 0.0, 3e12)), ["0", "1e12", "2e12", "3e12"]);
        assert_eq!(names(&Axis::whole("", 0, 3, 10)), ["0", "1", "2", "3"]);
    }

    #[test]
    fn an_axis_is_logarithmic_only_over_decades() {
        assert!(Axis::fitting("", &[1.0, 1e4]).is_logarithmic);
        assert!(!Axis::fitting("", &[1.0, 10.0]).is_logarithmic);
        assert!(!Axis::fitting("", &[0.0, 1e4]).is_logarithmic);
        assert_eq!(names(&Axis::fitting("", &[1.0, 1e3])), ["1", "10", "100", "1000"]);
    }

    #[test]
    fn values_that_are_not_finite_are_not_placed() {
        let axis = Axis::linear("", [1.0, f64::INFINITY, f64::NAN].into_iter());
        assert_eq!(axis.at(f64::NAN), None);
        assert_eq!(axis.at(f64::INFINITY), None);
        assert_eq!(axis.at(1.0), Some(1.0));
    }
}
