//! The widest corridor between the delays of both ways.
//!
//! Forward delays by two clocks are `d + offset(t)`, backward ones `-d + offset(t)`, with delays d that are not negative. So the
//! line `offset(t) = offset + drift t` lies below all forward points and above all backward ones. Of all such lines the one in the
//! middle of the widest corridor is taken: it maximises the smaller of the shortest delays of both ways. Without knowing more,
//! the offset may be wrong by half the width of the corridor.

use super::envelope::{Point, height};

/// Clocks that differ by more than this are broken: one in a thousand.
const FASTEST: f64 = 1e-3;
const STEPS: usize = 120;

/// A line in the middle of a corridor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corridor {
    pub(super) offset: f64,
    pub(super) drift: f64,
    /// Half the width, in nanoseconds; below zero if there is no line.
    pub(super) margin: f64,
}

/// Of the lower corners of forward points, and of backward points turned upside down.
pub(super) fn widest(forward: &[Point], backward: &[Point]) -> Corridor {
    // Concave in the drift, piecewise linear.
    let margin = |drift: f64| (height(forward, drift) + height(backward, -drift)) / 2.0;
    let (mut low, mut high) = (-FASTEST, FASTEST);
    for _ in 0..STEPS {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if margin(left) < margin(right) {
            low = left;
        } else {
            high = right;
        }
    }
    let drift = (low + high) / 2.0;
    Corridor {
        offset: (height(forward, drift) - height(backward, -drift)) / 2.0,
        drift,
        margin: margin(drift),
    }
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
        assert!((found.margin - 2e6).abs() < 5e3);
    }
}
