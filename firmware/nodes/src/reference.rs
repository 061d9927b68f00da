//! Samples of the reference that are known ahead, as the host sends them.
//!
//! What they add to the law is `slqg::tracking`'s.

use crate::design::Scalar;
use crate::dimensions::{PREVIEW_SAMPLES, TRACKED_OUTPUTS};
use heapless::Vec;
use slqg::{Tick, nalgebra::SVector, wire::Reference};

/// Most samples in one frame.
pub(crate) const PER_FRAME: usize = 8;
/// As many as the law looks ahead, and those of a frame that come before they are needed.
const ROOM: usize = PREVIEW_SAMPLES + PER_FRAME;

/// One sample.
pub(crate) type Sample = SVector<Scalar, TRACKED_OUTPUTS>;

/// The samples of the cycles to come, without a gap.
#[derive(Debug, Default)]
pub(crate) struct Window {
    /// The cycle of the first one.
    begin: Tick,
    samples: Vec<Sample, ROOM>,
}

impl Window {
    /// Takes samples: those that follow on what is there are kept, as many as there is room for; any others begin anew.
    /// The host sends them in order, and all of them after a pause.
    pub(crate) fn take(&mut self, reference: &Reference<Scalar, TRACKED_OUTPUTS, PER_FRAME>) {
        if reference.tick != self.begin + self.samples.len() as u32 {
            self.samples.clear();
            self.begin = reference.tick;
        }
        for sample in &reference.samples {
            // What there is no room for is sent again: the host sees no effect of what comes too early.
            let _ = self.samples.push(*sample);
        }
    }

    /// The samples of cycle `tick` and those after it; those before it are dropped. Empty if that of `tick` is not there.
    pub(crate) fn from(&mut self, tick: Tick) -> &[Sample] {
        let past = tick.since(self.begin);
        if past > 0 {
            let past = usize::try_from(past).unwrap_or(usize::MAX).min(self.samples.len());
            let left = self.samples.len() - past;
            self.samples.rotate_left(past);
            self.samples.truncate(left);
            self.begin = tick;
        }
        if past < 0 { &[] } else { &self.samples }
    }
}
