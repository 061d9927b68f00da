//! Whether what becomes of a packet depends on what became of the one before.

use super::{
    chance::{NORMAL_95, chi_square, two_sided},
    sample::Sample,
};
use rand::{SeedableRng, seq::index};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

const PERMUTATIONS: u32 = 9999;
/// The test gives the same answer on the same log.
const SEED: u64 = 1;
/// Expected count from which on the chi-square distribution is near enough.
pub const ENOUGH: f64 = 5.0;

/// How a probability was computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Chi-square test of the 2x2 table.
    ChiSquare,
    /// Losses put to random places, 9999 times.
    Permutation,
}

/// Losses of neighbours against each other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Losses {
    /// `[[arrived then arrived, arrived then lost], [lost then arrived, lost then lost]]`.
    pub table: [[u64; 2]; 2],
    /// How `p_value` was computed.
    pub method: Method,
    /// Probability of a table at least this uneven if losses were independent.
    pub p_value: f64,
    /// P(lost) after a packet that arrived.
    pub loss_after_arrival: f64,
    /// P(lost) after a packet that was lost.
    pub loss_after_loss: f64,
}

/// Runs of consecutive losses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bursts {
    /// How many.
    pub count: u64,
    /// Mean length.
    pub mean: f64,
    /// Mean length of independent losses: 1 / (1 - loss).
    pub mean_if_independent: f64,
    /// Longest.
    pub longest: u64,
}

/// Correlation of the delays of neighbours that both arrived.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Correlation {
    /// How many pairs.
    pub pairs: u64,
    /// Of delays in cycles.
    pub correlation: f64,
    /// Independent delays stay within plus and minus this with 95 %.
    pub band: f64,
    /// Probability of a correlation at least this large if delays were independent.
    pub p_value: f64,
}

/// Tests losses; nothing to test if all packets share one fate.
pub fn losses(sample: &Sample) -> Option<Losses> {
    let mut table = [[0_u64; 2]; 2];
    for (before, after) in sample.neighbours() {
        table[usize::from(before.is_none())][usize::from(after.is_none())] += 1;
    }
    let rows = table.map(|row| row[0] + row[1]);
    let columns = [table[0][0] + table[1][0], table[0][1] + table[1][1]];
    if rows.contains(&0) || columns.contains(&0) {
        return None;
    }
    let pairs = (rows[0] + rows[1]) as f64;
    let expected = |row: usize, column: usize| rows[row] as f64 * columns[column] as f64 / pairs;
    let cells = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let (method, p_value) = if cells.iter().all(|&(row, column)| expected(row, column) >= ENOUGH) {
        let unevenness = cells.map(|(row, column)| {
            (table[row][column] as f64 - expected(row, column)).powi(2) / expected(row, column)
        });
        (Method::ChiSquare, chi_square(unevenness.iter().sum(), 1))
    } else {
        (Method::Permutation, permutation(sample, table))
    };
    let share = |row: usize| table[row][1] as f64 / rows[row] as f64;
    Some(Losses { table, method, p_value, loss_after_arrival: share(0), loss_after_loss: share(1) })
}

/// Puts the rarer fate to random places, and counts how often neighbours share it about as rarely or as often.
fn permutation(sample: &Sample, table: [[u64; 2]; 2]) -> f64 {
    let packets = sample.packets() as usize;
    let losses_are_rarer = sample.lost <= sample.arrived();
    let (rarer, observed) =
        if losses_are_rarer { (sample.lost, table[1][1]) } else { (sample.arrived(), table[0][0]) };
    let rarer = rarer as usize;
    let pairs = (packets - sample.begins.len()) as f64;
    let all = packets as f64;
    let expected = pairs * rarer as f64 * (rarer as f64 - 1.0) / (all * (all - 1.0));
    // Twins at the same distance from the expectation differ by rounding.
    let distance = (observed as f64 - expected).abs() - 1e-9;
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let as_uneven = (0..PERMUTATIONS).filter(|_| {
        let mut places = index::sample(&mut random, packets, rarer).into_vec();
        places.sort_unstable();
        let together =
            |pair: &&[usize]| pair[1] == pair[0] + 1 && sample.begins.binary_search(&pair[1]).is_err();
        let shared = places.windows(2).filter(together).count();
        (shared as f64 - expected).abs() >= distance
    });
    (1 + as_uneven.count()) as f64 / f64::from(1 + PERMUTATIONS)
}

/// Runs of losses; none if nothing is lost.
pub fn bursts(sample: &Sample) -> Option<Bursts> {
    let (mut count, mut longest) = (0, 0);
    for file in sample.files() {
        let mut run = 0;
        for fate in sample.fates(file) {
            run = if fate.is_none() { run + 1 } else { 0 };
            count += u64::from(run == 1);
            longest = longest.max(run);
        }
    }
    (count > 0).then(|| Bursts {
        count,
        mean: sample.lost as f64 / count as f64,
        mean_if_independent: sample.packets() as f64 / sample.arrived() as f64,
        longest,
    })
}

/// Correlation of delays at lag 1; none if there are fewer than three pairs or the delays are all the same.
pub fn delays(sample: &Sample) -> Option<Correlation> {
    let pairs = || {
        let both = sample.neighbours().filter_map(|(before, after)| before.zip(after));
        both.map(|(before, after)| (before as f64, after as f64))
    };
    let (pairs_there, before, after) =
        pairs().fold((0_u64, 0.0, 0.0), |sum, pair| (sum.0 + 1, sum.1 + pair.0, sum.2 + pair.1));
    if pairs_there < 3 {
        return None;
    }
    let count = pairs_there as f64;
    let (before, after) = (before / count, after / count);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs() {
        xx += (x - before) * (x - before);
        xy += (x - before) * (y - after);
        yy += (y - after) * (y - after);
    }
    if xx <= 0.0 || yy <= 0.0 {
        return None;
    }
    let correlation = xy / (xx * yy).sqrt();
    let p_value = two_sided(correlation * count.sqrt());
    Some(Correlation { pairs: pairs_there, correlation, band: NORMAL_95 / count.sqrt(), p_value })
}
