//! Where a rate passes 1 on a way that leads away from the design.

/// Width to which the place where the rate passes 1 is narrowed.
pub(super) const WIDTH: f64 = 1e-9;
/// Narrowing steps at most; halving alone needs 30.
const NARROWINGS: usize = 60;
/// First step beside a place that is nearly right, as a part of the way to it.
const BESIDE: f64 = 1e-3;
/// Factor between such steps.
const WIDER: f64 = 4.0;

/// The last point, walking from `start` with `next` to `end`, up to which the rate is below 1; `end` itself if it stays
/// there. The rate at the point returned is below 1.
pub(super) fn boundary(
    start: f64,
    rate: f64,
    next: impl Fn(f64) -> f64,
    end: f64,
    width: f64,
    mut rate_at: impl FnMut(f64) -> f64,
) -> f64 {
    let (mut inside, mut inside_rate) = (start, rate);
    while inside != end {
        let outside = next(inside);
        let outside_rate = rate_at(outside);
        if !is_stable(outside_rate) {
            return narrowed((inside, inside_rate - 1.0), (outside, outside_rate - 1.0), width, rate_at);
        }
        (inside, inside_rate) = (outside, outside_rate);
    }
    end
}

/// The boundary that lies near `guess`, on a way from 0 to `end`: `None` if the rate stays below 1 to the end.
pub(super) fn boundary_near(
    guess: f64,
    end: f64,
    width: f64,
    mut rate_at: impl FnMut(f64) -> f64,
) -> Option<f64> {
    let excess = rate_at(guess) - 1.0;
    let mut last = (guess, excess);
    let mut step = BESIDE * guess;
    if excess < 0.0 {
        while last.0 < end {
            let at = (last.0 + step).min(end);
            let next = (at, rate_at(at) - 1.0);
            if !is_stable(next.1 + 1.0) {
                return Some(narrowed(last, next, width, rate_at));
            }
            (last, step) = (next, step * WIDER);
        }
        return None;
    }
    while last.0 > 0.0 {
        let at = (last.0 - step).max(0.0);
        let next = (at, rate_at(at) - 1.0);
        if is_stable(next.1 + 1.0) {
            return Some(narrowed(next, last, width, rate_at));
        }
        (last, step) = (next, step * WIDER);
    }
    Some(0.0)
}

/// Whether second moments shrink at this rate; what is no number does not.
pub(super) fn is_stable(rate: f64) -> bool {
    rate < 1.0
}

/// Where the rate passes 1 between a stable and an unstable point, each with its rate less 1: from the stable side.
///
/// Secants, with the weight of an end that stays halved (the Illinois rule), so that both ends close in.
fn narrowed(
    mut inside: (f64, f64),
    mut outside: (f64, f64),
    width: f64,
    mut rate_at: impl FnMut(f64) -> f64,
) -> f64 {
    let mut last_was_inside = None;
    for _ in 0..NARROWINGS {
        if (outside.0 - inside.0).abs() <= width * inside.0.abs().max(1.0) {
            break;
        }
        let secant = (inside.0 * outside.1 - outside.0 * inside.1) / (outside.1 - inside.1);
        // A rate beyond all numbers has no secant, and that of a rate of 1 leads nowhere.
        let leads_on = secant.is_finite() && secant != inside.0 && secant != outside.0;
        let middle = if leads_on { secant } else { 0.5 * (inside.0 + outside.0) };
        let excess = rate_at(middle) - 1.0;
        let is_inside = excess < 0.0;
        if is_inside {
            inside = (middle, excess);
        } else {
            outside = (middle, excess);
        }
        if last_was_inside == Some(is_inside) {
            let stayed = if is_inside { &mut outside } else { &mut inside };
            stayed.1 *= 0.5;
        }
        last_was_inside = Some(is_inside);
    }
    inside.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_boundary_is_found_from_either_side_of_a_guess() {
        let rate = |at: f64| 0.5 + 0.25 * at;
        for guess in [0.1, 1.9, 2.0, 2.2, 5.0] {
            let found = boundary_near(guess, 10.0, WIDTH, rate).expect("it is at 2");
            assert!((found - 2.0).abs() < 1e-8 && rate(found) < 1.0, "{guess}: {found}");
        }
        assert_eq!(boundary_near(1.0, 1.5, WIDTH, rate), None);
    }

    #[test]
    fn a_rate_that_is_no_number_is_outside() {
        let rate = |at: f64| if at < 3.0 { 0.5 } else { f64::INFINITY };
        let found = boundary(0.0, 0.5, |at| at + 1.0, 10.0, 1e-6, rate);
        assert!((found - 3.0).abs() < 1e-5, "{found}");
    }
}
