//! Which of the last measurements have arrived, as a Markov chain.
//!
//! A measurement is uncertain until it has arrived or can no longer count. The chain tells apart the arrivals of the last
//! cycles: those of the *window*, which may still come, and before them those of the *memory*, which the filter's gains
//! still show. Beyond, it supposes what is usual. Where the window is shorter than the largest delay, what would come later
//! is taken to come when it leaves the window.

use crate::design::DelayDistribution;

/// Probabilities this close to 0 or 1 count as such.
const CERTAIN: f64 = 1e-9;

/// The chain for one number of uncertain arrivals.
#[derive(Debug, Clone)]
pub(super) struct Arrivals {
    /// Cycles for which a measurement may still come.
    pub(super) window: usize,
    /// Probability that a measurement counts in the end.
    pub(super) in_the_end: f64,
    /// For each state, whether the measurement of age 0, 1, .. has arrived: the window, the one that has just left it, and
    /// the memory.
    pub(super) patterns: Vec<Vec<bool>>,
    /// For each state, the states that may follow, with their probabilities.
    pub(super) next: Vec<Vec<(usize, f64)>>,
    /// Whether nothing is left out.
    pub(super) is_exact: bool,
}

impl Arrivals {
    /// The chain that tells `uncertain` arrivals apart, over a link whose measurements count until they are `buffer` cycles
    /// late.
    pub(super) fn new(link: &DelayDistribution, buffer: usize, uncertain: usize) -> Self {
        let latest = buffer.min(link.largest_delay());
        let in_the_end = link.arrival(latest);
        let is_lost_at_times = is_uncertain(in_the_end);
        let told = |window: usize| {
            (0..window).filter(|&age| is_uncertain(link.arrival(age))).count() + usize::from(is_lost_at_times)
        };
        let window = (0..=latest).rev().find(|&window| told(window) <= uncertain).unwrap_or(0);
        let memory =
            if is_lost_at_times && window == latest { uncertain - told(window).min(uncertain) } else { 0 };
        // P(arrived) by age.
        let arrived: Vec<f64> = (0..=window + memory)
            .map(|age| if age < window { link.arrival(age) } else { in_the_end })
            .collect();
        let open: Vec<usize> = (0..arrived.len()).filter(|&age| is_uncertain(arrived[age])).collect();
        let patterns: Vec<Vec<bool>> = (0..1_usize << open.len())
            .map(|state| {
                let mut pattern: Vec<bool> = arrived.iter().map(|&probability| probability > 0.5).collect();
                open.iter().enumerate().for_each(|(bit, &age)| pattern[age] = state >> bit & 1 == 1);
                pattern
            })
            .collect();
        let next = patterns.iter().map(|pattern| followers(pattern, &arrived, window, &open)).collect();
        Self { window, in_the_end, patterns, next, is_exact: window == latest && !is_lost_at_times }
    }
}

fn is_uncertain(probability: f64) -> bool {
    (CERTAIN..=1.0 - CERTAIN).contains(&probability)
}

/// States that may follow `pattern`, each with its probability. `open`: ages that are uncertain, one bit of a state each.
fn followers(pattern: &[bool], arrived: &[f64], window: usize, open: &[usize]) -> Vec<(usize, f64)> {
    let mut found = vec![(0, 1.0)];
    for (bit, &age) in open.iter().enumerate() {
        let probability = match age.checked_sub(1) {
            None => arrived[0],
            Some(before) if pattern[before] => 1.0,
            Some(before) if age <= window => (arrived[age] - arrived[before]) / (1.0 - arrived[before]),
            Some(_) => 0.0,
        };
        found = found
            .into_iter()
            .flat_map(|(state, so_far)| {
                [(state, so_far * (1.0 - probability)), (state | 1 << bit, so_far * probability)]
            })
            .filter(|&(_, probability)| probability > 0.0)
            .collect();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn link(probabilities: &[f64]) -> DelayDistribution {
        DelayDistribution::new(probabilities.to_vec()).expect("a distribution")
    }

    #[test]
    fn a_delay_that_never_varies_needs_one_state() {
        for (probabilities, window) in [(&[1.0][..], 0), (&[0.0, 0.0, 1.0], 2)] {
            let found = Arrivals::new(&link(probabilities), 5, 0);
            assert_eq!((found.window, found.patterns.len(), found.is_exact), (window, 1, true));
            assert_eq!(found.next, [[(0, 1.0)]]);
            assert!(found.patterns[0][window] && !found.patterns[0][..window].contains(&true));
        }
    }

    #[test]
    fn every_state_leads_somewhere_and_keeps_what_has_arrived() {
        for (probabilities, uncertain) in
            [(&[0.5, 0.2, 0.1][..], 5), (&[0.5, 0.2, 0.1], 2), (&[0.3, 0.7], 4), (&[0.0, 0.6, 0.4], 3)]
        {
            let found = Arrivals::new(&link(probabilities), 9, uncertain);
            assert!(found.patterns.len() <= 1 << uncertain);
            for (pattern, next) in found.patterns.iter().zip(&found.next) {
                let sum: f64 = next.iter().map(|(_, probability)| probability).sum();
                assert!((sum - 1.0).abs() < 1e-14);
                for (after, _) in next {
                    let after = &found.patterns[*after];
                    assert!(pattern.iter().zip(&after[1..]).all(|(before, after)| !before || *after));
                }
            }
        }
    }

    #[test]
    fn in_the_long_run_each_age_has_arrived_as_often_as_the_link_says() {
        let link = link(&[0.5, 0.2, 0.1]);
        let found = Arrivals::new(&link, 9, 5);
        let mut shares = vec![1.0 / found.patterns.len() as f64; found.patterns.len()];
        for _ in 0..20 {
            let mut after = vec![0.0; shares.len()];
            for (share, next) in shares.iter().zip(&found.next) {
                next.iter().for_each(|&(state, probability)| after[state] += share * probability);
            }
            shares = after;
        }
        for age in 0..=found.window {
            let arrived: f64 = shares
                .iter()
                .zip(&found.patterns)
                .filter(|(_, pattern)| pattern[age])
                .map(|(share, _)| share)
                .sum();
            assert!((arrived - link.arrival(age)).abs() < 1e-12, "{age}: {arrived}");
        }
    }
}
