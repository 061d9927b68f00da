//! [`DelayEstimate`]: what the acknowledged ages say about the delays of the link to the actuator.
//!
//! The actuator plays the newest sequence that has arrived. If it played age `a'` in cycle `k-1` and age `a` in cycle `k`,
//! then of the packets sent `d` cycles before `k`
//!
//! ```text
//! d < a, d <= a'     was under way at age d, and did not arrive in cycle k
//! d = a <= a'        was under way, and arrived in cycle k
//! a < d <= a'        was under way; whether it arrived is not told, a newer one was played
//! a = a' + 1         no packet newer than the one played has arrived: the first line is all there is
//! ```
//!
//! These are observations of the hazards `h(d) = P(delay = d | delay >= d)`, censored on the right. Whether packet `d` is
//! observed in cycle `k` depends on the past and on newer packets alone, not on its own fate in that cycle, so in the mean
//! `arrived(d) - h(d) under_way(d)` is zero, however ages and losses come about: the counts are unbiased. The likelihood
//! of all ages is a product of `h(d)^arrived(d) (1 - h(d))^(under_way(d) - arrived(d))`. Its conjugate prior has independent
//! Beta distributions on the hazards; those of a Dirichlet distribution over the delays, of as many packets as it is to
//! weigh, are taken (stick-breaking).
//!
//! Counts fade, so that the estimate follows a link that drifts. One that changes at once is noticed by a second set of counts,
//! which fades faster: where the recent contradict the others, those are dropped.

use crate::{Scalar, played::Age};

/// Packets that reached some age under way, and those of them that arrived at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Count<T> {
    /// Packets that were under way at that age, where it is told what became of them.
    pub under_way: T,
    /// Those that arrived at it.
    pub arrived: T,
}

impl<T: Scalar> Count<T> {
    fn none() -> Self {
        Self { under_way: T::zero(), arrived: T::zero() }
    }
}

/// How much faster recent counts fade than the others.
const RECENT: f64 = 16.0;

/// Numbers of memory that a [`DelayEstimate`] for sequences of `length` inputs is lent.
pub const fn memory_len(length: usize) -> usize {
    7 * length
}

/// Counts of packets by age.
#[derive(Debug)]
struct Counted<'m, T> {
    under_way: &'m mut [T],
    arrived: &'m mut [T],
}

impl<T: Scalar> Counted<'_, T> {
    fn iter(&self) -> impl Iterator<Item = Count<T>> + '_ {
        let both = self.under_way.iter().zip(self.arrived.iter());
        both.map(|(under_way, arrived)| Count { under_way: *under_way, arrived: *arrived })
    }

    fn iter_mut(&mut self) -> impl Iterator<Item = (&mut T, &mut T)> + '_ {
        self.under_way.iter_mut().zip(self.arrived.iter_mut())
    }

    fn fade(&mut self, kept: T) {
        for (under_way, arrived) in self.iter_mut() {
            *under_way *= kept;
            *arrived *= kept;
        }
    }
}

/// Posterior of a link's delay distribution, in memory that is lent.
#[derive(Debug)]
pub struct DelayEstimate<'m, T> {
    /// What a count keeps of itself from cycle to cycle.
    kept: T,
    prior: Counted<'m, T>,
    counted: Counted<'m, T>,
    /// What a recent count keeps of itself.
    recent_kept: T,
    recent: Counted<'m, T>,
    /// Room for a survival function, one number for each age.
    room: &'m mut [T],
    /// The age of the cycle that was told last, if it was known.
    before: Option<Age>,
}

impl<'m, T: Scalar> DelayEstimate<'m, T> {
    /// An estimate that is `survival` (`P(delay > d)` for `d = 0..N-1`) until something is told, and gives that the weight of
    /// `packets` packets. Each observation fades by `1 / memory` per cycle. `None` if there are fewer `numbers` than
    /// [`memory_len`].
    pub fn new(survival: &[T], packets: T, memory: T, numbers: &'m mut [T]) -> Option<Self> {
        let length = survival.len();
        let mut rest = numbers;
        let mut take = || {
            let (taken, others) = core::mem::take(&mut rest).split_at_mut_checked(length)?;
            rest = others;
            taken.fill(T::zero());
            Some(taken)
        };
        let mut counted = || Some(Counted { under_way: take()?, arrived: take()? });
        let (mut prior, none, recent) = (counted()?, counted()?, counted()?);
        let mut reached = T::one();
        for ((under_way, arrived), &left) in prior.iter_mut().zip(survival) {
            (*under_way, *arrived) = (packets * reached, packets * (reached - left));
            reached = left;
        }
        let kept = |fades: f64| (T::one() - T::nearest(fades) / memory).max(T::zero());
        let (kept, recent_kept) = (kept(1.0), kept(RECENT));
        Some(Self { kept, prior, counted: none, recent_kept, recent, room: take()?, before: None })
    }

    /// Takes the age that was played in the next cycle; `None` if that is not known, and never will be.
    ///
    /// `sent(d)` says whether a packet was sent `d` cycles before that cycle: only those were under way.
    pub fn told(&mut self, age: Option<Age>, sent: impl Fn(usize) -> bool) {
        self.counted.fade(self.kept);
        self.recent.fade(self.recent_kept);
        if let (Some(before), Some(now)) = (self.before, age) {
            self.count(before, now, sent);
        }
        self.before = age;
    }

    fn count(&mut self, before: Age, now: Age, sent: impl Fn(usize) -> bool) {
        let length = self.room.len();
        let played = now.steps().unwrap_or(length);
        // Of packets no newer than the one played before nothing is told.
        let newer = before.steps().map_or(length, |steps| steps + 1).min(length);
        for counts in [&mut self.counted, &mut self.recent] {
            let told = counts.iter_mut().take(newer).enumerate().take(played.saturating_add(1));
            for (d, (under_way, arrived)) in told.filter(|(d, _)| sent(*d)) {
                *under_way += T::one();
                if d == played {
                    *arrived += T::one();
                }
            }
        }
    }

    /// What was counted of packets that reached age `d`, without the prior; nothing beyond the last input.
    pub fn counted(&self, d: usize) -> Count<T> {
        self.counted.iter().nth(d).unwrap_or_else(Count::none)
    }

    /// Count and prior together.
    fn posterior(&self) -> impl Iterator<Item = Count<T>> + '_ {
        posterior(&self.counted, &self.prior)
    }

    /// Writes the posterior mean of `P(delay > d)` for `d = 0..N-1`; zero hazard where nothing is known.
    pub fn fill_survival(&self, survival: &mut [T]) {
        fill_survival(self.posterior(), survival);
    }

    /// How strongly the posterior speaks against the link `survival`: twice the sum over ages `d` of packets observed times
    /// the Kullback-Leibler divergence of the hazards, in nats. Infinite if something happened that it holds impossible.
    ///
    /// Of a link that has not changed it is about `N`, see [`threshold`].
    pub fn distance(&self, survival: &[T]) -> T {
        distance(self.posterior(), survival)
    }

    /// Drops what is not recent if the distance of the recent observations from the posterior exceeds `threshold`: then the
    /// link has become another one. Returns whether it has.
    pub fn renew(&mut self, threshold: T) -> bool {
        fill_survival(posterior(&self.counted, &self.prior), self.room);
        let has_changed = distance(self.recent.iter(), self.room) > threshold;
        if has_changed {
            self.counted.under_way.copy_from_slice(self.recent.under_way);
            self.counted.arrived.copy_from_slice(self.recent.arrived);
        }
        has_changed
    }
}

fn posterior<'c, T: Scalar>(
    counted: &'c Counted<'_, T>,
    prior: &'c Counted<'_, T>,
) -> impl Iterator<Item = Count<T>> + 'c {
    counted.iter().zip(prior.iter()).map(|(counted, prior)| Count {
        under_way: counted.under_way + prior.under_way,
        arrived: counted.arrived + prior.arrived,
    })
}

fn fill_survival<T: Scalar>(counts: impl Iterator<Item = Count<T>>, survival: &mut [T]) {
    let mut left = T::one();
    for (value, count) in survival.iter_mut().zip(counts) {
        left *= T::one() - hazard(count);
        *value = left;
    }
}

fn distance<T: Scalar>(counts: impl Iterator<Item = Count<T>>, survival: &[T]) -> T {
    let mut reached = T::one();
    let mut sum = T::zero();
    for (count, &left) in counts.zip(survival) {
        if reached > T::zero() && count.under_way > T::zero() {
            let assumed = (reached - left) / reached;
            sum += count.under_way * divergence(hazard(count), assumed);
        }
        reached = left;
    }
    sum + sum
}

/// The distance that a link which is as assumed exceeds with a probability of `exp(-caution)` at most, at one look:
/// `N + 2 sqrt(N caution) + 2 caution`, the tail of a chi-squared distribution of `N` degrees of freedom.
///
/// A sum that fades has half the variance of one over as many packets, and the assumed link is an estimate itself, which
/// doubles it. Source: Laurent and Massart (2000), lemma 1.
pub fn threshold<T: Scalar>(length: usize, caution: T) -> T {
    let degrees = T::nearest(length as f64);
    let two = T::one() + T::one();
    degrees + two * (degrees * caution).sqrt() + two * caution
}

fn hazard<T: Scalar>(count: Count<T>) -> T {
    if count.under_way > T::zero() { (count.arrived / count.under_way).min(T::one()) } else { T::zero() }
}

/// Kullback-Leibler divergence of a coin with probability `p` from one with `q`, in nats.
fn divergence<T: Scalar>(p: T, q: T) -> T {
    let part = |p: T, q: T| match (p > T::zero(), q > T::zero()) {
        (false, _) => T::zero(),
        (true, false) => T::nearest(f64::INFINITY),
        (true, true) => p * (p / q).logarithm(),
    };
    // Rounding may leave it below zero.
    (part(p, q) + part(T::one() - p, T::one() - q)).max(T::zero())
}

#[cfg(test)]
mod tests {
    use super::*;

    type Room = [f64; memory_len(4)];

    fn nothing_known(room: &mut Room) -> DelayEstimate<'_, f64> {
        DelayEstimate::new(&[1.0; 4], 0.0, f64::INFINITY, room).expect("room for four ages")
    }

    fn counts(ages: &[Age]) -> [(f64, f64); 4] {
        let mut room = [0.0; memory_len(4)];
        let mut estimate = nothing_known(&mut room);
        ages.iter().for_each(|&age| estimate.told(Some(age), |_| true));
        core::array::from_fn(|d| (estimate.counted(d).under_way, estimate.counted(d).arrived))
    }

    #[test]
    fn a_sequence_that_is_played_on_says_that_nothing_newer_has_arrived() {
        let seen = counts(&[Age::Steps(1), Age::Steps(2)]);
        assert_eq!(seen, [(1.0, 0.0), (1.0, 0.0), (0.0, 0.0), (0.0, 0.0)]);
    }

    #[test]
    fn a_newer_sequence_has_arrived_and_hides_what_is_older() {
        let seen = counts(&[Age::Steps(3), Age::Steps(1)]);
        assert_eq!(seen, [(1.0, 0.0), (1.0, 1.0), (0.0, 0.0), (0.0, 0.0)]);
    }

    #[test]
    fn a_buffer_that_stays_empty_says_that_no_packet_of_use_has_arrived() {
        for before in [Age::Empty, Age::Steps(3)] {
            assert_eq!(counts(&[before, Age::Empty]), [(1.0, 0.0); 4]);
        }
        assert_eq!(counts(&[Age::Empty, Age::Steps(3)])[3], (1.0, 1.0));
    }

    #[test]
    fn nothing_is_counted_across_a_cycle_of_which_nothing_is_known() {
        let mut room = [0.0; memory_len(4)];
        let mut estimate = nothing_known(&mut room);
        for age in [Some(Age::Empty), None, Some(Age::Steps(0))] {
            estimate.told(age, |_| true);
        }
        assert_eq!(estimate.counted(0).under_way, 0.0);
    }

    #[test]
    fn a_packet_that_was_not_sent_was_not_under_way() {
        let mut room = [0.0; memory_len(4)];
        let mut estimate = nothing_known(&mut room);
        estimate.told(Some(Age::Empty), |_| true);
        estimate.told(Some(Age::Steps(2)), |d| d != 1);
        assert_eq!([0, 1, 2, 3].map(|d| estimate.counted(d).under_way), [1.0, 0.0, 1.0, 0.0]);
    }

    #[test]
    fn the_prior_is_the_estimate_until_something_is_told_and_again_when_all_is_forgotten() {
        let prior = [0.5, 0.25, 0.0];
        let mut room = [0.0; memory_len(3)];
        let mut estimate = DelayEstimate::<f64>::new(&prior, 20.0, 10.0, &mut room).unwrap();
        let mut survival = [0.0; 3];
        estimate.fill_survival(&mut survival);
        assert_eq!(survival, prior);
        assert_eq!(estimate.distance(&prior), 0.0);
        (0..50).for_each(|_| estimate.told(Some(Age::Empty), |_| true));
        estimate.fill_survival(&mut survival);
        assert!(survival[0] > 0.6, "{survival:?}");
        assert!(estimate.distance(&prior) > 10.0);
        (0..400).for_each(|_| estimate.told(None, |_| true));
        estimate.fill_survival(&mut survival);
        assert!((survival[0] - 0.5).abs() < 1e-12, "{survival:?}");
    }

    #[test]
    fn a_link_that_changes_at_once_makes_the_estimate_drop_what_was_before() {
        let mut room = [0.0; memory_len(2)];
        let mut estimate = DelayEstimate::<f32>::new(&[0.1, 0.0], 10.0, 480.0, &mut room).unwrap();
        let enough = threshold(2, 14.0);
        let play = |estimate: &mut DelayEstimate<'_, f32>, age| estimate.told(Some(age), |_| true);
        for cycle in 0..1000 {
            play(&mut estimate, if cycle % 10 == 0 { Age::Steps(1) } else { Age::Steps(0) });
        }
        assert!(!estimate.renew(enough));
        // From now on every packet is one cycle late.
        let noticed = (0..100).position(|_| {
            play(&mut estimate, Age::Steps(1));
            estimate.renew(enough)
        });
        assert!(noticed.is_some_and(|cycles| cycles < 40), "{noticed:?}");
        let mut survival = [0.0; 2];
        estimate.fill_survival(&mut survival);
        assert!(survival[0] > 0.4, "{survival:?}");
        // Those before count for 480 packets, and would still be most of it.
    }

    #[test]
    fn what_is_held_impossible_is_infinitely_far() {
        let mut room = [0.0; memory_len(4)];
        let mut estimate = nothing_known(&mut room);
        [Age::Empty, Age::Steps(0)].into_iter().for_each(|age| estimate.told(Some(age), |_| true));
        assert_eq!(estimate.distance(&[1.0, 0.5, 0.5, 0.5]), f64::INFINITY);
    }
}
