//! Numbers that wrap become numbers that do not: the time tells how many rounds a counter has made.

use super::super::{
    column::{Column, Sighting},
    time::{Nanoseconds, seconds},
};

/// Where numbers begin: room below for packets that were sent out of order.
pub(in super::super) const START: u64 = 1 << 40;
/// Where numbers stay, whatever the times are.
const LOWEST: u64 = 1 << 32;
const HIGHEST: u64 = 1 << 62;
/// Steps back of a sender's numbers that are no disorder.
const BACK: u64 = 16;
/// Of the numbers, at most this part may be far back, and a few more.
const FAR_BACK: f64 = 0.005;
const FEW: u64 = 8;
/// A capture of a bridge and its port has every packet twice; no more repeat.
const MOST_AGAIN: f64 = 0.7;
/// Steps by one from which the time between packets is taken.
const STEPS: usize = 10_000;

/// A packet seen, with a number that goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) struct Numbered {
    /// As it was seen.
    pub(in super::super) seen: u32,
    pub(in super::super) number: u64,
    pub(in super::super) time: Nanoseconds,
}

/// How the numbers of a link go on.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Rounds {
    modulus: u64,
    /// Nanoseconds between packets.
    period: f64,
}

impl Rounds {
    /// Of a sender's sightings, in the order of time.
    pub(in super::super) fn of(sent: &Column, modulus: u64) -> Self {
        let mut gaps: Vec<Nanoseconds> = Vec::new();
        let mut before: Option<Sighting> = None;
        for sighting in sent.iter() {
            if let Some(before) = before.replace(sighting)
                && forward(before.number, sighting.number, modulus) == 1
            {
                gaps.push(sighting.time - before.time);
                if gaps.len() == STEPS {
                    break;
                }
            }
        }
        gaps.sort_unstable();
        Self { modulus, period: gaps.get(gaps.len() / 2).map_or(1.0, |&gap| gap.max(1) as f64) }
    }

    /// Nanoseconds that a round takes.
    pub(in super::super) fn round(&self) -> f64 {
        self.period * self.modulus as f64
    }

    /// Whether only the time tells in which round a number is.
    pub(in super::super) fn is_narrow(&self) -> bool {
        self.modulus <= 1 << 16
    }

    /// The sender's numbers, gone on.
    pub(in super::super) fn sent<I: Iterator<Item = Sighting>>(
        &self,
        column: I,
    ) -> impl Iterator<Item = Numbered> + use<I> {
        let rounds = *self;
        let mut newest: Option<(Sighting, u64)> = None;
        column.map(move |sighting| {
            let number = match newest {
                None => START + u64::from(sighting.number),
                Some((before, number)) => {
                    number.saturating_add_signed(rounds.step(before, sighting)).clamp(LOWEST, HIGHEST)
                }
            };
            if newest.is_none_or(|(_, highest)| number >= highest) {
                newest = Some((sighting, number));
            }
            Numbered { seen: sighting.number, number, time: sighting.time }
        })
    }

    /// How far the number went between two sightings.
    fn step(&self, before: Sighting, after: Sighting) -> i64 {
        let step = forward(before.number, after.number, self.modulus) as i64;
        let modulus = self.modulus as i64;
        if !self.is_narrow() {
            return if step > modulus / 2 { step - modulus } else { step };
        }
        let expected = (after.time - before.time) as f64 / self.period;
        let rounds = ((expected - step as f64) / self.modulus as f64).round();
        step.saturating_add((rounds as i64).saturating_mul(modulus))
    }

    /// A number near all up to `highest`, if the counter does not come round meanwhile.
    pub(in super::super) fn middle(&self, first: u64, highest: u64) -> Option<u64> {
        let span = highest - first;
        (span < self.modulus / 4 && !self.is_narrow()).then_some(first + span / 2)
    }

    /// The number of a packet that arrives: of those that fit, the newest one that the sender had sent by then; of a wide
    /// counter, the nearest to `near`.
    pub(in super::super) fn received(&self, number: u32, near: u64) -> u64 {
        // Where clocks are a little apart, a packet may arrive before it is sent; that must be seen.
        let early = match self.modulus {
            65_536 => self.modulus / 4,
            narrow if narrow < 65_536 => 0,
            wide => wide / 2,
        };
        let highest = near + early;
        let of_highest = (highest - START) % self.modulus;
        let back = (of_highest + self.modulus - u64::from(number) % self.modulus) % self.modulus;
        highest.saturating_sub(back)
    }

    /// Looks through the numbers of a sender.
    pub(in super::super) fn survey(&self, sent: &Column) -> Survey {
        let mut survey = Survey { packets: sent.len, ..Survey::default() };
        let mut before: Option<Numbered> = None;
        let mut first = None;
        for numbered in self.sent(sent.iter()) {
            let Numbered { seen, number, time } = numbered;
            let begin = *first.get_or_insert(time);
            if let Some(before) = before.replace(numbered) {
                survey.again += u64::from(before.seen == seen);
                survey.jumps += u64::from(self.is_narrow() && self.is_jump(before, numbered));
            }
            if number + BACK < survey.highest {
                survey.back += 1;
                survey.back_after.get_or_insert(time - begin);
            }
            survey.highest = survey.highest.max(number);
        }
        survey
    }

    /// Whether a step is not what the time lets expect, by more than an eighth of a round.
    fn is_jump(&self, before: Numbered, after: Numbered) -> bool {
        let expected = (after.time - before.time) as f64 / self.period;
        (after.number as f64 - before.number as f64 - expected).abs() > (self.modulus as f64 / 8.0).max(3.0)
    }
}

/// What the numbers of a sender are like.
#[derive(Debug, Clone, Copy, Default)]
pub(in super::super) struct Survey {
    packets: u64,
    /// The largest number.
    pub(in super::super) highest: u64,
    /// Numbers that are that of the packet before.
    again: u64,
    /// Numbers that go back too far, and how long after the begin the first one does.
    back: u64,
    back_after: Option<Nanoseconds>,
    /// Jumps ahead that are against the time: of a counter that wraps early, a restart looks like one.
    pub(in super::super) jumps: u64,
}

impl Survey {
    /// Refuses numbers that go back again and again: two runs in one log, or no counter.
    pub(in super::super) fn check(&self) -> Result<(), String> {
        let Self { packets, again, back, .. } = *self;
        if again > FEW && again as f64 > MOST_AGAIN * packets as f64 {
            return Err(format!(
                "most numbers repeat: {again} of {packets} packets have the number of the one before; it is no counter, say where there is \
                 one, as --counter u16le@0"
            ));
        }
        if back as f64 <= FAR_BACK * packets as f64 + FEW as f64 && back * 4 <= packets {
            return Ok(());
        }
        Err(format!(
            "the sender's numbers go back and repeat, for the first time {:.3} s after the log begins, for {back} of {packets} packets: \
             did the sender restart, so that the log holds two runs? give one file per run; or is it no counter? then say where \
             it is, as --counter u16le@0",
            seconds(self.back_after.unwrap_or(0))
        ))
    }
}

fn forward(from: u32, to: u32, modulus: u64) -> u64 {
    (u64::from(to) + modulus - u64::from(from) % modulus) % modulus
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(packets: impl Iterator<Item = (i64, u64)>, modulus: u64) -> Column {
        packets
            .map(|(time, number)| Sighting { number: (number % modulus) as u32, time: time * 1_000_000 })
            .collect()
    }

    #[test]
    fn rounds_are_counted_by_the_time() {
        for modulus in [15, 16, 256, 65_536, 1 << 32] {
            // Most are sent; between 1000 and 1777 none.
            let sent = || (0..3000).filter(|n| !(1000..1777).contains(n)).map(|n| (10 * n, n as u64 + 200));
            let column = column(sent(), modulus);
            let rounds = Rounds::of(&column, modulus);
            assert!((rounds.round() - 1e7 * modulus as f64).abs() < 1.0);
            assert_eq!((rounds.survey(&column).check(), rounds.survey(&column).jumps), (Ok(()), 0));
            let begin = START + 200 % modulus - 200;
            for ((_, number), found) in sent().zip(rounds.sent(column.iter())) {
                assert_eq!(found.number, begin + number, "modulo {modulus}");
                // It arrives four cycles later.
                assert_eq!(rounds.received((number % modulus) as u32, found.number + 4), found.number);
            }
        }
    }

    #[test]
    fn a_sender_that_begins_anew_is_told() {
        for modulus in [65_536, 1 << 32] {
            let column =
                column((0..400).map(|n| (10 * n, if n < 150 { n } else { n - 150 } as u64)), modulus);
            let problem = Rounds::of(&column, modulus).survey(&column).check().expect_err("two runs");
            assert!(problem.contains("1.500 s after the log begins"), "{problem}");
        }
        // A narrow counter jumps ahead within its round then, and its packets are paired all the same.
        let column = column((0..400).map(|n| (10 * n, if n < 150 { n } else { n - 150 } as u64)), 256);
        let survey = Rounds::of(&column, 256).survey(&column);
        assert_eq!((survey.check(), survey.jumps), (Ok(()), 1));
    }
}
