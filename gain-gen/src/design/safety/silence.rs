//! For how long a link that works may bring nothing.

use slqg_links::{
    delay::DelayDistribution,
    link::{Behaviour, Link},
};

/// Longer silences have this probability at most, in any one cycle.
const RARE: f64 = 1e-6;
/// Where packets depend on each other in a way that is not known, silences may be longer by this.
const UNKNOWN: usize = 3;
/// Beyond this many cycles it is not looked for.
const MOST: usize = 10_000;

/// Cycles without a packet that are as good as never seen on a `link`, on which packets that are up to `late` cycles late count;
/// `None` where nothing arrives for as long as anybody would wait.
pub(super) fn longest(link: &Link, late: usize) -> Option<usize> {
    let fails = |delays: &DelayDistribution| (1.0 - delays.arrival(late)).clamp(0.0, 1.0);
    let cycles = match (&link.behaviour, link.channel()) {
        (_, Some(channel)) => {
            // The probability of being in each state, and of nothing having arrived so far.
            let states = channel.states();
            let mut silent: Vec<f64> = channel.shares().to_vec();
            (1..=MOST).find(|_| {
                let failed: Vec<f64> = (0..states)
                    .map(|state| silent[state] * channel.delays(state).map_or(1.0, fails))
                    .collect();
                silent = (0..states)
                    .map(|to| (0..states).map(|from| failed[from] * channel.transition(from, to)).sum())
                    .collect();
                silent.iter().sum::<f64>() < RARE
            })
        }
        (behaviour, None) => {
            let fails = fails(&link.delays);
            let cycles = (1..=MOST).find(|cycles| fails.powi(*cycles as i32) < RARE);
            let independent = matches!(behaviour, Behaviour::Independent);
            cycles.map(|cycles| if independent { cycles } else { UNKNOWN * cycles })
        }
    };
    // The first packet that arrives may be as late as any.
    cycles.map(|cycles| cycles + link.largest_delay().min(late))
}
