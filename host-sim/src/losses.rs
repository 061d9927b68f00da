//! How often a loop under input limits is lost: runs that leave the states from which inputs within the limits lead back.

use crate::closed_loop::RunResult;
use serde::Serialize;

/// Standard deviations of the normal distribution that 95 % are within.
const WITHIN: f64 = 1.959_963_984_540_054;
const SECONDS_PER_HOUR: f64 = 3600.0;

/// What the runs of a loop under limits came to. Time counts until a loop is lost, so a rate of losses does not depend on how long
/// the runs go on afterwards.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Losses {
    /// Runs that were lost: at their end the state was beyond what inputs within the limits bring back, or had diverged.
    pub lost: usize,
    /// Hours of operation, of all runs together.
    pub hours: f64,
    /// Losses per hour of operation.
    pub per_hour: f64,
    /// Bounds of a 95 % interval for it: losses as a Poisson process.
    pub per_hour_lower: f64,
    /// And its upper bound.
    pub per_hour_upper: f64,
}

impl Losses {
    /// Of runs of `steps` cycles of `sample_time` seconds.
    pub fn of(results: &[RunResult], steps: usize, sample_time: f64) -> Self {
        let lost = results.iter().filter(|result| result.lost_after.is_some()).count();
        let cycles: usize = results.iter().map(|result| result.lost_after.unwrap_or(steps)).sum();
        let hours = cycles as f64 * sample_time / SECONDS_PER_HOUR;
        let (lower, upper) = poisson_interval(lost);
        Self {
            lost,
            hours,
            per_hour: lost as f64 / hours,
            per_hour_lower: lower / hours,
            per_hour_upper: upper / hours,
        }
    }
}

/// Bounds on the mean of a Poisson distribution that has come to `count`, 95 % by Garwood's interval. Quantiles of chi-square as
/// Wilson and Hilferty have them, good to one percent; none at all is exact.
fn poisson_interval(count: usize) -> (f64, f64) {
    let half_quantile = |degrees: f64, deviations: f64| {
        let spread = 2.0 / (9.0 * degrees);
        0.5 * degrees * (1.0 - spread + deviations * spread.sqrt()).max(0.0).powi(3)
    };
    let count = count as f64;
    if count == 0.0 {
        return (0.0, -0.025_f64.ln());
    }
    (half_quantile(2.0 * count, -WITHIN), half_quantile(2.0 * count + 2.0, WITHIN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_garwoods() {
        for (count, lower, upper) in
            [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.39), (100, 81.36, 121.63)]
        {
            let (from, to) = poisson_interval(count);
            assert!((from - lower).abs() <= 0.01 * lower + 0.02, "{count}: {from}");
            assert!((to / upper - 1.0).abs() < 0.01, "{count}: {to}");
        }
    }

    #[test]
    fn time_counts_until_a_loop_is_lost() {
        let run = |lost_after| RunResult {
            cost: 0.0,
            diverged: false,
            lost_after,
            sent: 0,
            age_sum: 0,
            rejected: 0,
        };
        let found = Losses::of(&[run(None), run(Some(1200))], 6000, 0.5);
        assert_eq!((found.lost, found.hours, found.per_hour), (1, 1.0, 1.0));
    }
}
