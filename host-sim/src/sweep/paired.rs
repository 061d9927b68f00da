//! Differences to a baseline, run by run.
//!
//! In the run of one number every case meets the same noise and the same fates of packets, so much of what makes a run cheap
//! or dear is common to both costs and drops out of their difference.

use super::row::Entry;
use crate::sample::{mean, standard_error};
use serde::Serialize;

/// Half the width of a 95 % interval of a normal variable, in standard deviations.
const HALF_WIDTH: f64 = 1.959_963_984_540_054;

/// What a case costs more than the baseline, per run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Difference {
    /// Mean over the runs: below zero, it is cheaper than the baseline.
    pub mean: Option<f64>,
    /// Standard error of the mean.
    pub std_error: Option<f64>,
    /// Where the true mean is with 95 % confidence, by the normal distribution: meant for 30 runs or more.
    pub interval_95: Option<[f64; 2]>,
}

impl Difference {
    /// Of the costs `of` entries to those of a baseline in the same runs; `None` where there is no such cost.
    pub fn between(
        entries: &[Entry],
        baseline: &[Entry],
        of: impl Fn(&Entry) -> Option<f64>,
    ) -> Option<Self> {
        let pairs = entries.iter().zip(baseline);
        let differences: Vec<f64> =
            pairs.map(|(own, base)| Some(of(own)? - of(base)?)).collect::<Option<_>>()?;
        let finite = |value: f64| value.is_finite().then_some(value);
        let (mean, std_error) = (finite(mean(&differences)), finite(standard_error(&differences)));
        let interval = |(mean, error): (f64, f64)| [mean - HALF_WIDTH * error, mean + HALF_WIDTH * error];
        Some(Self { mean, std_error, interval_95: mean.zip(std_error).map(interval) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::RunResult;

    fn entries(costs: [f64; 3]) -> Vec<Entry> {
        let entry = |cost| Entry {
            result: RunResult { cost, diverged: false, lost_after: None, sent: 0, age_sum: 0, rejected: 0 },
            total_cost: None,
        };
        costs.map(entry).to_vec()
    }

    #[test]
    fn what_both_have_in_common_drops_out() {
        let (base, own) = (entries([100.0, 1e6, 3.0]), entries([101.0, 1e6 + 2.0, 6.0]));
        let found = Difference::between(&own, &base, |entry| Some(entry.result.cost)).expect("costs");
        assert_eq!(found.mean, Some(2.0));
        let error = found.std_error.expect("finite");
        assert!((error - 1.0 / 3f64.sqrt()).abs() < 1e-12, "{error}");
        let [low, high] = found.interval_95.expect("finite");
        assert!((low - (2.0 - 1.96 * error)).abs() < 1e-3 && (high - (2.0 + 1.96 * error)).abs() < 1e-3);
    }

    #[test]
    fn a_run_that_cost_too_much_to_tell_leaves_no_difference() {
        let found = Difference::between(&entries([1.0, f64::INFINITY, 1.0]), &entries([1.0; 3]), |entry| {
            Some(entry.result.cost)
        });
        assert_eq!(found, Some(Difference { mean: None, std_error: None, interval_95: None }));
        assert_eq!(
            Difference::between(&entries([1.0; 3]), &entries([1.0; 3]), |entry| entry.total_cost),
            None
        );
    }
}
