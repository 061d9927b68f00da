//! The widest corridor between the delays of both ways.
//!
//! Forward delays by two clocks are `d + offset(t)`, backward ones `-d + offset(t)`, with delays d that are not negative. So the
//! line `offset(t) = offset + drift t` lies below all forward points and above all backward ones. Of all such lines the one in the
//! middle of the widest corridor is taken: it maximises the smaller of the shortest delays of both ways. Without knowing more,
//! any line between the points may be the true one: how far they are from this one is the margin.

use super::envelope::{Point, height};

/// Clocks that differ by more than this are broken: one in a thousand.
const FASTEST: f64 = 1e-3;
const STEPS: usize = 120;

/// A line in the middle of a corridor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corridor {
    pub(super) offset: f64,
    pub(super) drift: f64,
    /// Half the width, in nanoseconds; below zero if no line is between the points.
    pub(super) half: f64,
}

impl Corridor {
    /// How far, at most, a line between the points is from this one, at the times 0 and `until` and so at all between.
    pub(super) fn margin(&self, forward: &[Point], backward: &[Point], until: f64) -> f64 {
        let is_between = |drift: f64| height(forward, drift) + height(backward, -drift) >= 0.0;
        let steepest = |end: f64| {
            let (mut good, mut bad) = (self.drift, end);
            for _ in 0..STEPS {
                let middle = (good + bad) / 2.0;
                if is_between(middle) { good = middle } else { bad = middle }
            }
            good
        };
        let drifts = (steepest(-FASTEST), steepest(FASTEST));
        let ends = [0.0, until].map(|time| {
            let here = self.offset + self.drift * time;
            // The highest line at a time is concave in the drift, the lowest convex.
            let highest = largest(drifts, |drift| height(forward, drift) + drift * time).1;
            let lowest = -largest(drifts, |drift| height(backward, -drift) - drift * time).1;
            (highest - here).max(here - lowest)
        });
        ends[0].max(ends[1]).max(0.0)
    }
}

/// Where a concave function is largest, and how large.
fn largest((mut low, mut high): (f64, f64), of: impl Fn(f64) -> f64) -> (f64, f64) {
    for _ in 0..STEPS {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if of(left) < of(right) { low = left } else { high = right }
    }
    let middle = (low + high) / 2.0;
    (middle, of(middle))
}

/// Of the lower corners of forward points, and of backward points turned upside down.
pub(super) fn widest(forward: &[Point], backward: &[Point]) -> Corridor {
    // Concave in the drift, piecewise linear.
    let (drift, width) =
        largest((-FASTEST, FASTEST), |drift| height(forward, drift) + height(backward, -drift));
    Corridor { offset: (height(forward, drift) - height(backward, -drift)) / 2.0, drift, half: width / 2.0 }
}

#[cfg(test)]
mod tests {
    use super::{super::envelope::lower, *};

    #[test]
    fn a_line_between_both_ways_is_found() {
        // 3.2 s and 40 ppm, at least 2 ms each way.
        let offset = |time: f64| 3.2e9 + 40e-6 * time;
        let delay = |n: f64| 2e6 + 1e6 * (n * 0.7).sin().abs();
        let times = || (0..1000).map(f64::from).map(|n| (n, n * 1e7));
        let forward = lower(times().map(|(n, time)| (time, offset(time) + delay(n))));
        let backward = lower(times().map(|(n, time)| (time, delay(n + 0.3) - offset(time))));
        let found = widest(&forward, &backward);
        assert!((found.drift - 40e-6).abs() < 5e-7 && (found.offset - 3.2e9).abs() < 5e3, "{found:?}");
        assert!((found.half - 2e6).abs() < 5e3);
        // No true line is farther away than the margin, which is little more than half the corridor here.
        let margin = found.margin(&forward, &backward, 1e10);
        assert!((2e6..2.5e6).contains(&margin), "{margin}");
        for end in [0.0, 1e10] {
            assert!((found.offset + found.drift * end - offset(end)).abs() <= margin);
        }
    }
}
