//! [`Sample`]: what became of every packet, in cycles, and how often.

use super::trace::{Trace, TraceError};

/// Most cycles that a design file holds: `delays` has at most 1000 entries.
pub const LONGEST: usize = 999;
/// A part of a cycle that is rounding, not time.
const ROUNDING: f64 = 1e-9;
/// Arrivals that are remembered to see which packets were overtaken.
const MOST_WAITING: usize = 1 << 16;
/// Among fates, which are delays up to [`LONGEST`].
const LOST: u16 = u16::MAX;

/// How times become cycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Seconds per cycle.
    pub sample_time: f64,
    /// Seconds from the begin of a cycle to the sending of its packet.
    pub offset: f64,
    /// Packets that are later than this many cycles count as lost.
    pub longest: usize,
}

impl Clock {
    /// Cycles from sending to arrival: `floor((received - sent + offset) / T)`, times in nanoseconds.
    pub fn cycles(&self, sent: i64, received: i64) -> usize {
        let seconds = (received - sent) as f64 / 1e9 + self.offset;
        // Saturates far beyond all delays there are.
        (seconds / self.sample_time + ROUNDING) as usize
    }
}

/// What became of the packets, in the order sent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sample {
    fates: Vec<u16>,
    /// Where files begin among the fates: a packet and the last one of another file are no neighbours.
    pub begins: Vec<usize>,
    /// Packets by delay, up to the longest that occurs.
    pub counts: Vec<u64>,
    /// Packets that were lost.
    pub lost: u64,
    /// Packets among them that arrived, but too late to count.
    pub late: u64,
    /// Packets that arrived after one which was sent later.
    pub reordered: u64,
}

impl Sample {
    /// Pools the traces of one link.
    ///
    /// # Errors
    /// No packet arrived.
    pub fn new(traces: &[Trace], clock: &Clock) -> Result<Self, TraceError> {
        let mut sample = Self {
            fates: Vec::new(),
            begins: Vec::new(),
            counts: Vec::new(),
            lost: 0,
            late: 0,
            reordered: 0,
        };
        for trace in traces {
            sample.begins.push(sample.fates.len());
            sample.fates.reserve(trace.logged_packets() as usize);
            let mut overtaken = Overtaken::default();
            for packet in trace.packets() {
                let arrived = packet.sent.zip(packet.received);
                let delay = arrived.map(|(sent, received)| clock.cycles(sent, received));
                let fate = delay.filter(|&delay| delay <= clock.longest);
                sample.late += u64::from(fate.is_none() && delay.is_some());
                sample.count(fate);
                if let Some(received) = packet.received {
                    overtaken.arrived(received);
                }
            }
            sample.reordered += overtaken.count;
        }
        match sample.counts.is_empty() {
            true => Err(TraceError::Whole(format!(
                "none of {} packets arrives within {} cycles: no delays to identify; check --sample-time, the unit of the times \
                 and the logs",
                sample.lost, clock.longest
            ))),
            false => Ok(sample),
        }
    }

    /// What became of packets that are known.
    #[cfg(test)]
    pub(super) fn of(fates: impl Iterator<Item = Option<usize>>) -> Self {
        let mut sample =
            Self { fates: Vec::new(), begins: vec![0], counts: Vec::new(), lost: 0, late: 0, reordered: 0 };
        fates.for_each(|fate| sample.count(fate));
        sample
    }

    fn count(&mut self, fate: Option<usize>) {
        self.fates.push(fate.map_or(LOST, |delay| delay as u16));
        match fate {
            None => self.lost += 1,
            Some(delay) => {
                if self.counts.len() <= delay {
                    self.counts.resize(delay + 1, 0);
                }
                self.counts[delay] += 1;
            }
        }
    }

    /// All packets.
    pub fn packets(&self) -> u64 {
        self.fates.len() as u64
    }

    /// Packets that arrived.
    pub fn arrived(&self) -> u64 {
        self.packets() - self.lost
    }

    /// Delay in cycles, or lost, of the packets of a range; file after file.
    pub fn fates(&self, range: std::ops::Range<usize>) -> impl Iterator<Item = Option<usize>> + '_ {
        self.fates[range].iter().map(|&fate| read(fate))
    }

    /// Where the packets of each file are among the fates.
    pub fn files(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let ends = self.begins.iter().skip(1).copied().chain([self.fates.len()]);
        self.begins.iter().zip(ends).map(|(&begin, end)| begin..end)
    }

    /// Whether packets were lost, each with the two that were sent after it.
    pub(super) fn triples(&self) -> impl Iterator<Item = [bool; 3]> + '_ {
        let is_lost = |triple: &[u16]| [triple[0] == LOST, triple[1] == LOST, triple[2] == LOST];
        self.files().flat_map(move |file| self.fates[file].windows(3).map(is_lost))
    }

    /// Each packet with the one sent after it.
    pub fn neighbours(&self) -> impl Iterator<Item = (Option<usize>, Option<usize>)> + '_ {
        self.files().flat_map(|file| self.fates[file].windows(2).map(|pair| (read(pair[0]), read(pair[1]))))
    }
}

fn read(fate: u16) -> Option<usize> {
    (fate != LOST).then_some(usize::from(fate))
}

/// Counts packets that arrive after one which was sent later, as packets come in the order sent.
#[derive(Debug, Default)]
struct Overtaken {
    count: u64,
    /// Arrivals, ascending, that a packet sent later may still come before.
    waiting: Vec<i64>,
}

impl Overtaken {
    fn arrived(&mut self, received: i64) {
        // Whatever arrives after this packet and was sent before it is overtaken, once.
        while self.waiting.pop_if(|earlier| *earlier > received).is_some() {
            self.count += 1;
        }
        self.waiting.push(received);
        // No packet is under way while twice that many others arrive.
        if self.waiting.len() > 2 * MOST_WAITING {
            self.waiting.drain(..MOST_WAITING);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packet_there_before_the_next_cycle_is_not_late() {
        let clock = Clock { sample_time: 0.01, offset: 0.0, longest: LONGEST };
        let cycles = [0, 9_999_999, 10_000_000, 19_999_999, 30_000_000].map(|late| clock.cycles(5, 5 + late));
        assert_eq!(cycles, [0, 0, 1, 1, 3]);
        let shifted = Clock { offset: 0.004, ..clock };
        assert_eq!([5_999_999, 6_000_000].map(|late| shifted.cycles(0, late)), [0, 1]);
    }

    #[test]
    fn a_packet_that_several_overtake_counts_once() {
        let mut overtaken = Overtaken::default();
        [50, 20, 30, 90, 85, 86, 95].into_iter().for_each(|time| overtaken.arrived(time));
        assert_eq!(overtaken.count, 2);
    }
}
