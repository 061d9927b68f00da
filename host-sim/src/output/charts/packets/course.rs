//! [`Course`]: what a packet did once it was sent - when it arrived and when its copies did, and which of them was of use.

use crate::closed_loop::CycleRecord;
use slqg_links::{loop_bus::Role, path::Fate};

/// One arrival of a packet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    /// Cycles it took.
    pub(super) delay: usize,
    pub(super) is_used: bool,
    /// Whether it is a copy that the link made.
    pub(super) is_copy: bool,
}

/// What a packet did.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Course {
    Lost,
    /// Not decided when the run ended.
    Open,
    /// The packet itself first, then its copies.
    Arrived(Vec<Leg>),
}

impl Course {
    /// Of the packet of `role` that was sent in cycle `sent` and met `fate`. Of all its arrivals only the first can be of
    /// use, and is if `is_used` says so of its delay.
    pub(super) fn of(
        run: &[CycleRecord],
        role: Role,
        sent: usize,
        fate: Fate,
        is_used: impl Fn(usize) -> bool,
    ) -> Self {
        let own = match fate {
            Fate::Lost => return Self::Lost,
            Fate::Open => return Self::Open,
            Fate::Delayed(own) => own,
        };
        let copies = copies(run, role, sent, own);
        let first = copies.iter().copied().fold(own, usize::min);
        let is_used = is_used(first);
        let copied = |delay| Leg { delay, is_used: is_used && own > first && delay == first, is_copy: true };
        let original = Leg { delay: own, is_used: is_used && own == first, is_copy: false };
        Self::Arrived(std::iter::once(original).chain(copies.into_iter().map(copied)).collect())
    }

    /// Whether the link made a copy of it.
    pub(super) fn has_copies(&self) -> bool {
        matches!(self, Self::Arrived(legs) if legs.len() > 1)
    }

    /// Cycles until its first arrival.
    fn first(&self) -> Option<usize> {
        match self {
            Self::Arrived(legs) => legs.iter().map(|leg| leg.delay).min(),
            Self::Lost | Self::Open => None,
        }
    }
}

/// Delays of the copies of a packet that itself took `own` cycles.
fn copies(run: &[CycleRecord], role: Role, sent: usize, own: usize) -> Vec<usize> {
    // An acknowledgement is about a cycle that is over, and taken in the next at the earliest.
    let earliest = sent + usize::from(role == Role::Acknowledgement);
    let taken = |record: &CycleRecord| {
        record.arrivals.iter().filter(|arrival| (arrival.role, arrival.sent) == (role, sent)).count()
    };
    let later = run.iter().skip(earliest).enumerate();
    let mut delays: Vec<usize> =
        later.flat_map(|(delay, record)| std::iter::repeat_n(delay, taken(record))).collect();
    if let Some(at) = delays.iter().position(|delay| *delay == own) {
        delays.remove(at);
    }
    delays
}

/// By the cycle it was sent in, whether an acknowledgement told of a cycle that none before it had told of. Each tells of
/// the last `cycles` cycles.
pub(super) fn tell_news(run: &[CycleRecord], cycles: usize) -> Vec<bool> {
    let first = |(sent, record): (usize, &CycleRecord)| {
        let fate = record.acknowledgement_frame?;
        Some((sent + Course::of(run, Role::Acknowledgement, sent, fate, |_| true).first()?, sent))
    };
    let mut arrivals: Vec<(usize, usize)> = run.iter().enumerate().filter_map(first).collect();
    arrivals.sort_unstable();
    let (mut told, mut news) = (vec![false; run.len()], vec![false; run.len()]);
    for (_, sent) in arrivals {
        for cycle in (sent + 1).saturating_sub(cycles)..=sent {
            news[sent] |= !told[cycle];
            told[cycle] = true;
        }
    }
    news
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::Arrival;

    /// A run in which acknowledgements meet `fates`.
    fn run(fates: &[Fate]) -> Vec<CycleRecord> {
        let record = |fate: &Fate| CycleRecord {
            state: Vec::new(),
            estimate: Vec::new(),
            deviation: Vec::new(),
            input: Vec::new(),
            tracked: Vec::new(),
            age: None,
            control_frame: None,
            measurement_frame: None,
            acknowledgement_frame: Some(*fate),
            arrivals: Vec::new(),
        };
        fates.iter().map(record).collect()
    }

    #[test]
    fn an_acknowledgement_that_is_overtaken_by_one_that_tells_more_is_no_news() {
        let fates = [Fate::Delayed(2), Fate::Delayed(0), Fate::Lost, Fate::Delayed(0)];
        assert_eq!(tell_news(&run(&fates), 1), [true, true, false, true]);
        assert_eq!(tell_news(&run(&fates), 2), [false, true, false, true]);
    }

    #[test]
    fn a_copy_that_comes_first_is_the_one_that_is_used() {
        let mut cycles = run(&[Fate::Delayed(3); 6]);
        let control = Arrival { role: Role::Control, sent: 1 };
        cycles[2].arrivals.push(control);
        cycles[4].arrivals.push(control);
        let leg = |delay, is_used, is_copy| Leg { delay, is_used, is_copy };
        let course = Course::of(&cycles, Role::Control, 1, Fate::Delayed(3), |_| true);
        assert_eq!(course, Course::Arrived(vec![leg(3, false, false), leg(1, true, true)]));
        let alone = Course::of(&cycles, Role::Control, 2, Fate::Delayed(1), |_| true);
        assert_eq!(alone, Course::Arrived(vec![leg(1, true, false)]));
        assert!(course.has_copies() && !alone.has_copies());
    }

    #[test]
    fn a_copy_of_an_acknowledgement_is_taken_a_cycle_after_its_delay() {
        let mut cycles = run(&[Fate::Delayed(0); 4]);
        let told = Arrival { role: Role::Acknowledgement, sent: 0 };
        cycles[1].arrivals.push(told);
        cycles[3].arrivals.push(told);
        assert_eq!(copies(&cycles, Role::Acknowledgement, 0, 0), [2]);
    }
}
