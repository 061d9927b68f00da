//! The channel of two states that losses in bursts come from, where they are not independent: Gilbert's.
//!
//! In the bad state all packets are lost, in the good one none. What becomes of a packet then depends on the one before alone, so the
//! likelihood is largest at the shares that were counted: `to_bad = P(lost after an arrival)`, `to_good = P(arrival after a loss)`.

use super::{
    chance::chi_square,
    independence::{ENOUGH, Losses},
    sample::Sample,
};
use serde::Serialize;

/// Independence is refused below this probability.
const LEVEL: f64 = 0.01;

/// A fitted channel, as a design file's `gilbert_elliott` takes it, with an empty list for the bad state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Channel {
    /// P(good to bad) per packet.
    pub to_bad: f64,
    /// P(bad to good) per packet.
    pub to_good: f64,
    /// Delays in the good state.
    pub good: Vec<f64>,
    /// Twice the logarithm of how much likelier the losses are than independent ones.
    pub likelihood_ratio: f64,
    /// By how much the Bayesian information criterion is lower: the ratio less `ln n` for the one parameter more.
    pub bic_gain: f64,
    /// Probability of losses that depend at least this much on the packet before the last one too, if they come from this channel;
    /// nothing if too few were lost to tell. If small, bursts are not of this kind.
    pub fit_p_value: Option<f64>,
}

/// Fits a channel; none if losses may be independent, or the better likelihood is not worth a parameter.
pub fn channel(sample: &Sample, losses: &Losses) -> Option<Channel> {
    if losses.p_value >= LEVEL {
        return None;
    }
    let pairs: u64 = losses.table.iter().flatten().sum();
    let likelihood_ratio = ratio(losses.table);
    let bic_gain = likelihood_ratio - (pairs as f64).ln();
    let arrived = sample.arrived() as f64;
    let (to_bad, to_good) = (losses.loss_after_arrival, 1.0 - losses.loss_after_loss);
    // A channel that never changes is none.
    (bic_gain > 0.0 && to_bad > 0.0 && to_good > 0.0).then(|| Channel {
        to_bad,
        to_good,
        good: sample.counts.iter().map(|&count| count as f64 / arrived).collect(),
        likelihood_ratio,
        bic_gain,
        fit_p_value: fit(sample),
    })
}

/// `2 sum O ln(O / E)` of a table, with what is expected of independent rows and columns.
fn ratio(table: [[u64; 2]; 2]) -> f64 {
    let all: f64 = table.iter().flatten().sum::<u64>() as f64;
    let cells = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(row, column)| {
        let seen = table[row][column] as f64;
        let of_row: u64 = table[row].iter().sum();
        let of_column = table[0][column] + table[1][column];
        if seen == 0.0 { 0.0 } else { seen * (seen * all / (of_row as f64 * of_column as f64)).ln() }
    });
    2.0 * cells.iter().sum::<f64>()
}

/// Whether a packet's fate depends on the one before the last too, given the last: the ratio of both tables, with a degree of freedom each.
fn fit(sample: &Sample) -> Option<f64> {
    let mut tables = [[[0_u64; 2]; 2]; 2];
    for [first, last, now] in sample.triples() {
        tables[usize::from(last)][usize::from(first)][usize::from(now)] += 1;
    }
    let enough = |table: &&[[u64; 2]; 2]| {
        let all: u64 = table.iter().flatten().sum();
        let expected = |row: usize, column: usize| {
            let of_row: u64 = table[row].iter().sum();
            of_row as f64 * (table[0][column] + table[1][column]) as f64 / all as f64
        };
        [(0, 0), (0, 1), (1, 0), (1, 1)].iter().all(|&(row, column)| expected(row, column) >= ENOUGH)
    };
    let tested: Vec<f64> = tables.iter().filter(enough).map(|table| ratio(*table)).collect();
    (!tested.is_empty()).then(|| chi_square(tested.iter().sum(), tested.len()))
}

#[cfg(test)]
mod tests {
    use super::{super::independence::losses, *};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const PACKETS: usize = 20_000;

    /// Whether packets of a process arrive, by what became of the two before.
    fn drawn(seed: u64, lost: impl Fn(bool, bool) -> f64) -> Sample {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (mut before, mut last) = (false, false);
        let fates = (0..PACKETS).map(|index| {
            (before, last) = (last, random.random_bool(lost(before, last)));
            (!last).then_some(index % 2)
        });
        Sample::of(fates)
    }

    fn fitted(sample: &Sample) -> Option<Channel> {
        channel(sample, &losses(sample)?)
    }

    #[test]
    fn the_channel_that_losses_come_from_is_given_back() {
        let mut poor = 0;
        for seed in 0..20 {
            let channel = fitted(&drawn(seed, |_, last| if last { 0.7 } else { 0.03 })).expect("a channel");
            // About 1800 losses and 18000 arrivals: within four standard errors.
            assert!((channel.to_bad - 0.03).abs() < 4.0 * (0.03 * 0.97 / 18_000.0_f64).sqrt(), "{channel:?}");
            assert!((channel.to_good - 0.3).abs() < 4.0 * (0.3 * 0.7 / 1800.0_f64).sqrt(), "{channel:?}");
            assert!((channel.good.iter().sum::<f64>() - 1.0).abs() < 1e-12 && channel.bic_gain > 100.0);
            poor += u32::from(channel.fit_p_value.is_some_and(|p_value| p_value < 0.05));
        }
        assert!(poor <= 4, "{poor} of 20 fits are refused at 5 %");
    }

    #[test]
    fn independent_losses_get_no_channel() {
        let found = (0..20).filter_map(|seed| fitted(&drawn(100 + seed, |_, _| 0.09))).count();
        assert_eq!(found, 0);
    }

    #[test]
    fn bursts_of_another_kind_fit_poorly() {
        // Losses come in pairs at least.
        let lost = |before: bool, last: bool| match (before, last) {
            (false, true) => 0.95,
            (true, true) => 0.3,
            _ => 0.03,
        };
        let channel = fitted(&drawn(1, lost)).expect("a channel");
        assert!(channel.fit_p_value.expect("enough losses") < 1e-6);
    }
}
