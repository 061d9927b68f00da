//! The counter that the payloads of a sender show: the bytes that go up by one from each packet to the next.

use super::{Counter, Shape};

/// Of a sender's steps, at least this part is small, and half is exactly one.
pub(in super::super) const IN_ORDER: f64 = 0.95;
/// The same of packets as they arrive: some overtake others.
pub(in super::super) const AS_THEY_ARRIVE: f64 = 0.7;
/// Steps up to this one may be packets that were not sent or not logged.
const SMALL: u64 = 8;
/// Payloads that are looked at before most places are given up.
const FIRST_LOOK: usize = 500;
/// Fewer steps show nothing.
const FEWEST: u64 = 2;

/// How a place behaves as a counter.
#[derive(Debug, Clone, Copy, Default)]
struct Steps {
    all: u64,
    ones: u64,
    /// Neither one nor a few.
    wrong: u64,
    smallest: u32,
    largest: u32,
    /// From the largest number so far to the smallest so far.
    wraps: u64,
    /// From a number to a smaller one, by a small step.
    carries: u64,
}

impl Steps {
    fn is_counter(&self, small_steps: f64) -> bool {
        let small = (self.all - self.wrong) as f64 >= small_steps * self.all as f64;
        self.all >= FEWEST && small && 2 * self.ones >= self.all
    }
}

/// The counter in payloads that are in the order sent: the widest that steps right, and among those the one with the fewest wrong steps.
/// `small_steps` is the part of the steps that must be small.
pub(in super::super) fn find<'p>(
    payloads: impl Iterator<Item = &'p [u8]> + Clone,
    small_steps: f64,
) -> Option<Counter> {
    let shortest = payloads.clone().map(<[u8]>::len).min()?;
    let places = (0..shortest).flat_map(|byte| Shape::ALL.map(|shape| Counter::new(shape, byte)));
    let found: Vec<(Counter, Steps)> = places
        .filter(|place| {
            steps(place, payloads.clone().take(FIRST_LOOK)).is_some_and(|steps| steps.is_counter(small_steps))
        })
        .filter_map(|place| Some((place, steps(&place, payloads.clone())?)))
        .filter(|(_, steps)| steps.is_counter(small_steps))
        .collect();
    // The lower part of a counter is one too, and it does not show that the counter began anew. But where it wraps and the whole does not
    // carry, the whole is none.
    let is_none = |(wide, of): &(Counter, Steps)| {
        let narrower = found.iter().filter(|(place, _)| place.modulus < wide.modulus);
        narrower
            .into_iter()
            .any(|(_, narrow)| narrow.wrong < of.wrong && of.wrong - narrow.wrong >= narrow.carries)
    };
    let whole = found.iter().filter(|place| !is_none(place));
    let (mut counter, steps) =
        *whole.min_by_key(|(place, steps)| (u64::MAX - place.modulus, steps.wrong, place.byte))?;
    // A narrow counter that wraps again and again below its largest number counts to where it wraps.
    let numbers = u64::from(steps.largest - steps.smallest) + 1;
    if counter.modulus <= 256 && numbers < counter.modulus && steps.wraps >= 2 && steps.all >= 2 * numbers {
        (counter.first, counter.modulus) = (steps.smallest, numbers);
    }
    Some(counter)
}

fn steps<'p>(place: &Counter, payloads: impl Iterator<Item = &'p [u8]>) -> Option<Steps> {
    let mut steps = Steps { smallest: u32::MAX, ..Steps::default() };
    let mut before: Option<(&[u8], u32)> = None;
    for payload in payloads {
        let number = place.read(payload)?;
        let Some((last, from)) = before.replace((payload, number)) else {
            (steps.smallest, steps.largest) = (number, number);
            continue;
        };
        // A packet that was logged twice is no step.
        if last == payload {
            continue;
        }
        let step = u64::from(number.wrapping_sub(from)) & (place.modulus - 1);
        let wraps = from == steps.largest && number <= steps.smallest && from != number;
        let most = SMALL.min(place.modulus / 4);
        steps.all += 1;
        steps.ones += u64::from(step == 1);
        steps.wrong += u64::from(step == 0 || step > most);
        steps.carries += u64::from(number < from && (1..=most).contains(&step));
        steps.wraps += u64::from(wraps && number < from);
        (steps.smallest, steps.largest) = (steps.smallest.min(number), steps.largest.max(number));
    }
    Some(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(payload: impl Fn(u32) -> Vec<u8>) -> Option<String> {
        let payloads: Vec<Vec<u8>> = (0..600).map(payload).collect();
        find(payloads.iter().map(Vec::as_slice), IN_ORDER).map(|counter| counter.to_string())
    }

    #[test]
    fn counters_are_found_where_they_are() {
        let noise = |n: u32| (n.wrapping_mul(2_654_435_761) >> 24) as u8;
        let some = |text: &str| Some(text.to_string());
        assert_eq!(found(|n| [&n.to_le_bytes()[..], &[9; 4]].concat()), some("u32le@0"));
        assert_eq!(found(|n| [&[noise(n)][..], &(n + 200).to_be_bytes()].concat()), some("u32be@1"));
        assert_eq!(found(|n| vec![n as u8, noise(n), noise(n + 1)]), some("u8@0"));
        // 65300 .. wraps, constant bytes behind it.
        assert_eq!(found(|n| [&((n + 65_300) as u16).to_le_bytes()[..], &[0, 0]].concat()), some("u16le@0"));
        assert_eq!(found(|n| vec![noise(n), noise(n) & 0xf0 | (n % 16) as u8]), some("nibble@1"));
        assert_eq!(
            found(|n| vec![noise(n), noise(n) & 0x0f | ((n % 15) << 4) as u8]),
            some("high-nibble@1 (0 .. 14)")
        );
        assert_eq!(found(|n| vec![noise(n), (n % 255) as u8 + 1, noise(n + 7)]), some("u8@1 (1 .. 255)"));
        // The sender began anew, and what follows the counter stays.
        assert_eq!(found(|n| (if n < 430 { n } else { n - 430 }).to_le_bytes().to_vec()), some("u32le@0"));
        // A counter that a sender steps on every cycle, though it leaves out some packets.
        assert_eq!(found(|n| (n + n / 3).to_le_bytes().to_vec()), some("u32le@0"));
    }

    #[test]
    fn what_is_no_counter_is_not_found() {
        assert_eq!(found(|n| vec![(n.wrapping_mul(2_654_435_761) >> 24) as u8, 7]), None);
        assert_eq!(found(|n| (10 * n).to_le_bytes().to_vec()), None, "a time in milliseconds");
        assert_eq!(found(|_| vec![]), None);
    }
}
