//! Whether the link stayed the same: the first half of the packets against the second.

use super::{chance::chi_square, independence::ENOUGH, sample::Sample};
use serde::Serialize;

/// Chi-square test of homogeneity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Drift {
    /// Sum of `(found - expected)^2 / expected`.
    pub chi_square: f64,
    /// Classes less one.
    pub degrees_of_freedom: usize,
    /// Probability of halves at least this different if the link stayed the same.
    pub p_value: f64,
    /// Mean delay of the first half and of the second, in cycles, of packets that arrived.
    pub mean_delay: [f64; 2],
    /// Share of lost packets in the first half and in the second.
    pub loss: [f64; 2],
}

/// Compares the halves; nothing to compare if fewer than two classes are large enough.
///
/// A class is a delay, or loss. Delays with expected counts below 5 are put together with the next longer ones.
pub fn drift(sample: &Sample) -> Option<Drift> {
    let all = sample.packets() as usize;
    let halves = [0..all / 2, all / 2..all].map(|half| tally(sample, half));
    let sizes = [(all / 2) as f64, (all - all / 2) as f64];
    let share = sizes.map(|size| size / all as f64);
    let enough = |class: &[f64; 2]| (class[0] + class[1]) * share[0].min(share[1]) >= ENOUGH;

    let mut classes: Vec<[f64; 2]> = Vec::new();
    let mut open = [0.0, 0.0];
    for delay in 0..sample.counts.len() {
        open = [open[0] + halves[0][delay], open[1] + halves[1][delay]];
        if enough(&open) {
            classes.push(std::mem::take(&mut open));
        }
    }
    // What is left of the tail belongs to the longest class.
    match classes.last_mut() {
        Some(longest) => *longest = [longest[0] + open[0], longest[1] + open[1]],
        None => classes.push(open),
    }
    let lost = [halves[0][sample.counts.len()], halves[1][sample.counts.len()]];
    if enough(&lost) {
        classes.push(lost);
    }
    if classes.len() < 2 || !classes.iter().all(enough) {
        return None;
    }
    let total = [0, 1].map(|half| classes.iter().map(|class| class[half]).sum::<f64>());
    let statistic = classes.iter().flat_map(|class| {
        [0, 1].map(|half| {
            let expected = (class[0] + class[1]) * total[half] / (total[0] + total[1]);
            (class[half] - expected).powi(2) / expected
        })
    });
    let (statistic, degrees_of_freedom) = (statistic.sum(), classes.len() - 1);
    Some(Drift {
        chi_square: statistic,
        degrees_of_freedom,
        p_value: chi_square(statistic, degrees_of_freedom),
        mean_delay: [0, 1].map(|half| mean_delay(&halves[half])),
        loss: [lost[0] / sizes[0], lost[1] / sizes[1]],
    })
}

/// Packets by delay, and the lost ones last.
fn tally(sample: &Sample, half: std::ops::Range<usize>) -> Vec<f64> {
    let delays = sample.counts.len();
    let mut counts = vec![0.0; delays + 1];
    sample.fates(half).for_each(|fate| counts[fate.unwrap_or(delays)] += 1.0);
    counts
}

fn mean_delay(half: &[f64]) -> f64 {
    let arrived = &half[..half.len() - 1];
    let sum: f64 = arrived.iter().enumerate().map(|(delay, count)| delay as f64 * count).sum();
    sum / arrived.iter().sum::<f64>()
}
