//! The rule that sends a sequence if it differs enough from the one sent before: thesis (5.20) and the text after it.

use slqg::{Scalar, sequence::ControlSequence};
use slqg_links::link::Link;

/// The `delta` of the thesis' DB(10).
pub const DEFAULT_DEADBAND: f64 = 10.0;

/// When a sequence is sent. The sequences themselves are the nominal controller's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deadband {
    /// `delta`: most change of an input, as a multiple of the new one, that is not worth a packet.
    pub delta: f64,
    /// Most cycles that a packet may be late, as the rule has it: the largest delay of the link. It knows of no losses.
    pub largest_delay: usize,
}

impl Deadband {
    /// DB(10) over `link`.
    pub(super) fn over(link: &Link) -> Self {
        Self { delta: DEFAULT_DEADBAND, largest_delay: link.largest_delay() }
    }

    /// Whether `candidate` is to be sent, `sent` being the sequence that was sent last.
    ///
    /// It is if (5.20) holds, or if the actuator is at risk of running dry: `sent` is `theta` cycles old, and the
    /// `N - theta - 1` inputs that are left of it after this cycle are fewer than a packet may be late. The maximum of (5.20)
    /// runs over the inputs that both sequences have, `i = 0..N-1-theta`; the thesis' `N - theta` is one too many.
    pub fn sends<T: Scalar, const NU: usize>(
        &self,
        candidate: &ControlSequence<'_, T, NU>,
        sent: Option<&ControlSequence<'_, T, NU>>,
    ) -> bool {
        let Some((sent, age)) =
            sent.and_then(|sent| Some((sent, candidate.tick.age_of(sent.tick)? as usize)))
        else {
            return true;
        };
        let left = sent.inputs.get(age..).unwrap_or_default();
        if left.is_empty() || left.len() - 1 < self.largest_delay {
            return true;
        }
        candidate.inputs.iter().zip(left).any(|(new, old)| {
            let size = new.amax().widen();
            // Not a quotient: a new input of zero differs from any other, however large the deadband.
            (new - old).amax().widen() > self.delta * size
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SVector;
    use slqg::Tick;

    fn sequence(tick: u32, inputs: [f64; 4]) -> ControlSequence<'static, f64, 1> {
        let inputs = inputs.map(|input| SVector::from([input]));
        ControlSequence { tick: Tick(tick), inputs: Box::leak(Box::new(inputs)) }
    }

    const RULE: Deadband = Deadband { delta: 0.5, largest_delay: 1 };

    #[test]
    fn a_sequence_that_says_what_the_last_one_said_is_not_sent() {
        let sent = sequence(7, [9.0, 1.0, 2.0, 3.0]);
        assert!(!RULE.sends(&sequence(8, [1.0, 2.0, 3.0, -9.0]), Some(&sent)));
        assert!(RULE.sends(&sequence(8, [1.0, 2.0, 3.0, -9.0]), None));
    }

    #[test]
    fn a_sequence_is_sent_if_one_input_that_is_left_changes_by_more_than_the_deadband() {
        let sent = sequence(7, [9.0, 1.0, 2.0, 3.0]);
        assert!(!RULE.sends(&sequence(8, [1.0, 2.0, 2.0, 0.0]), Some(&sent)), "3 is half of 2 away from 2");
        assert!(RULE.sends(&sequence(8, [1.0, 2.0, 1.9, 0.0]), Some(&sent)));
        assert!(RULE.sends(&sequence(8, [0.0, 2.0, 3.0, 0.0]), Some(&sent)), "zero is new");
    }

    #[test]
    fn a_sequence_is_sent_if_fewer_inputs_are_left_than_a_packet_may_be_late() {
        let sent = sequence(7, [9.0, 1.0, 2.0, 3.0]);
        assert!(
            !RULE.sends(&sequence(9, [2.0, 3.0, 0.0, 0.0]), Some(&sent)),
            "one is left for the next cycle"
        );
        assert!(RULE.sends(&sequence(10, [3.0, 0.0, 0.0, 0.0]), Some(&sent)));
        assert!(RULE.sends(&sequence(11, [0.0; 4]), Some(&sent)));
    }
}
