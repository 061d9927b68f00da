//! When a measurement is not believed, and when it is the estimate that is not.
//!
//! docs/safety.md tells what comes of it; where a measurement meets the estimate is in `estimate` and `step`.

use crate::Scalar;

/// What is believed of the measurements; constant data. Counts of cycles are of those in a row, and zero stands for never.
///
/// An output is judged by its innovation `e`, the difference between what is measured and what is expected, and by the variance `s`
/// that this has if estimate and model are right: it is not believed if `e^2 > gate s`. `gate` is the quantile of the chi-square
/// distribution with one degree of freedom at the probability that a right one passes.
///
/// Whatever is not believed widens the estimate, until `s` is four times as large: a plant that was pushed is believed a few
/// cycles later, and one reading that is wrong costs no more than that it is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plausibility<T, const NY: usize> {
    /// Squared innovations up to this many times their variance are believed; `None` believes all.
    pub gate: Option<T>,
    /// Cycles in which something was measured and nothing believed, after which the estimate begins anew with what was measured.
    pub doubt_after: u8,
    /// Smallest and largest reading of each output, in output units. What is outside is not measured.
    pub range: Option<[[T; 2]; NY]>,
    /// Readings of each output that are the same to the bit, after which it is held to be stuck.
    pub stuck_after: [u16; NY],
    /// Whether the readings of an output that is held to be stuck are taken for not measured.
    pub rejects_stuck: bool,
    /// Cycles without a measurement that is believed, after which the loop is degraded.
    pub stale_after: u16,
    /// Cycles without a measurement that is believed, after which the loop is lost.
    pub lost_after: u16,
}

impl<T, const NY: usize> Plausibility<T, NY> {
    /// Believes everything.
    pub const NONE: Self = Self {
        gate: None,
        doubt_after: 0,
        range: None,
        stuck_after: [0; NY],
        rejects_stuck: false,
        stale_after: 0,
        lost_after: 0,
    };
}

impl<T: Scalar, const NY: usize> Plausibility<T, NY> {
    /// Whether its numbers are such as it can be used with: a gate that is positive, ranges that are not empty.
    pub(crate) fn is_valid(&self) -> bool {
        // A number that is none is neither.
        self.gate.is_none_or(|gate| gate > T::zero())
            && self.range.is_none_or(|range| range.iter().all(|[least, most]| least < most))
    }

    /// `true` of a reading of output `output` that it cannot have.
    pub(crate) fn is_out_of_range(&self, output: usize, reading: T) -> bool {
        let range = self.range.as_ref().and_then(|range| range.get(output));
        range.is_some_and(|[least, most]| !(*least..=*most).contains(&reading))
    }
}

/// How what was measured has fitted the estimate, up to a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Standing<const NY: usize> {
    rejected: [u8; NY],
    silent: u16,
}

/// Before anything was believed there is nothing that a measurement would have to fit.
const NOTHING_YET: u8 = u8::MAX;

impl<const NY: usize> Standing<NY> {
    /// Before the first measurement.
    pub(super) const START: Self = Self { rejected: [NOTHING_YET; NY], silent: 0 };

    /// Times in a row that this output has been measured and not believed.
    pub fn rejected(&self, output: usize) -> u8 {
        self.rejected.get(output).copied().filter(|times| *times != NOTHING_YET).unwrap_or(0)
    }

    /// Cycles since an output was believed; saturates.
    pub fn silent(&self) -> u16 {
        self.silent
    }

    /// Whether the cycle that is told of by `heard`, in which nothing was believed, makes so many in a row that the estimate is
    /// doubted.
    pub(super) fn doubts(&self, heard: &Heard, doubt_after: u8) -> bool {
        let least = (0..NY).filter(|output| heard.has(*output)).map(|output| self.rejected[output]).min();
        least.is_some_and(|least| least == NOTHING_YET || (doubt_after > 0 && least >= doubt_after - 1))
    }

    /// One cycle on.
    pub(super) fn after(&self, heard: &Heard) -> Self {
        if heard.believed == Heard::all(NY) {
            return Self { rejected: [0; NY], silent: 0 };
        }
        let mut next = *self;
        next.silent = if heard.believes_none() { self.silent.saturating_add(1) } else { 0 };
        for output in 0..NY {
            if heard.believes(output) {
                next.rejected[output] = 0;
            } else if heard.has(output) && next.rejected[output] < NOTHING_YET - 1 {
                next.rejected[output] += 1;
            }
        }
        next
    }
}

/// What became of the measurement of one cycle, a bit for each output; of several estimates, of the one that believed most.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heard {
    believed: u32,
    rejected: u32,
}

/// Most outputs that there is a bit for.
pub(super) const MOST_OUTPUTS: usize = u32::BITS as usize;

impl Heard {
    pub(super) const NOTHING: Self = Self { believed: 0, rejected: 0 };

    const fn all(outputs: usize) -> u32 {
        if outputs < MOST_OUTPUTS { (1 << outputs) - 1 } else { u32::MAX }
    }

    /// With an output that was measured and believed.
    #[inline(always)]
    pub(super) fn believe(&mut self, output: usize) {
        self.believed |= 1 << output;
    }

    /// With one that was measured and not believed.
    pub(super) fn reject(&mut self, output: usize) {
        self.rejected |= 1 << output;
    }

    /// With what another estimate makes of the same measurement.
    #[inline(always)]
    pub(super) fn with(&mut self, other: &Self) {
        self.believed |= other.believed;
        self.rejected |= other.rejected;
    }

    fn has(&self, output: usize) -> bool {
        (self.believed | self.rejected) & (1 << output) != 0
    }

    fn believes(&self, output: usize) -> bool {
        self.believed & (1 << output) != 0
    }

    /// Whether nothing that was measured was rejected; of one estimate.
    pub(super) fn rejects_none(&self) -> bool {
        self.rejected == 0
    }

    pub(super) fn rejects(&self, output: usize) -> bool {
        self.rejected & (1 << output) != 0
    }

    pub(super) fn believes_none(&self) -> bool {
        self.believed == 0
    }
}
