//! A link whose delays and losses are written down, so that every run meets the same ones.

use heapless::Vec;

/// Longest frame the loop sends: a control frame of the pendulum's sequences.
pub(crate) const FRAME_CAPACITY: usize = 64;
/// More cycles than any delay in a script.
const SLOTS: usize = 8;
/// Packets that may arrive in one cycle.
const PER_CYCLE: usize = 4;

/// One frame's bytes.
pub(crate) type Frame = Vec<u8, FRAME_CAPACITY>;

/// A link that treats the `i`-th packet as the `i`-th entry of its script says, over and over.
pub(crate) struct ScriptedLink {
    /// Delay of each packet in cycles; `None` loses it.
    script: &'static [Option<u8>],
    sent: usize,
    now: usize,
    /// Packets by the cycle they arrive in, modulo [`SLOTS`].
    due: [Vec<Frame, PER_CYCLE>; SLOTS],
}

impl ScriptedLink {
    pub(crate) fn new(script: &'static [Option<u8>]) -> Self {
        Self { script, sent: 0, now: 0, due: [const { Vec::new() }; SLOTS] }
    }

    /// Sends a frame in the current cycle.
    pub(crate) fn send(&mut self, frame: &[u8]) {
        let fate = self.script.get(self.sent % self.script.len().max(1)).copied().flatten();
        self.sent += 1;
        if let (Some(delay), Ok(frame)) = (fate, Frame::from_slice(frame)) {
            // A fifth packet in one cycle is lost, as on a link with a short queue.
            let _ = self.due[(self.now + usize::from(delay)) % SLOTS].push(frame);
        }
    }

    /// Lets a cycle pass without sending; the next frame meets what it would have met.
    pub(crate) fn skip(&mut self) {
        self.sent += 1;
    }

    /// Frames that arrive in the current cycle; ends it.
    pub(crate) fn arrived(&mut self) -> Vec<Frame, PER_CYCLE> {
        let arrived = core::mem::take(&mut self.due[self.now % SLOTS]);
        self.now += 1;
        arrived
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_arrive_when_the_script_says() {
        let mut link = ScriptedLink::new(&[Some(1), None, Some(0)]);
        link.send(&[0]);
        assert!(link.arrived().is_empty());
        link.send(&[1]);
        let arrived = link.arrived();
        assert_eq!(arrived.len(), 1);
        assert_eq!(arrived[0], [0]);
        link.send(&[2]);
        assert_eq!(link.arrived()[0], [2]);
    }
}
