//! What some controllers decide on the host, before or beside a cycle of the core.
//!
//! Estimate, bookkeeping of what is in flight, law and frames are the core's for every controller. Where more is to be
//! decided, a copy of the core's controller runs the cycle ahead: it tells the sequence that would be sent, or the estimate
//! and what is expected in flight. Then the controller itself runs it, with what was decided. The quadratic program of
//! constrained model predictive control is in `optimiser`; the rule of the deadband is [`crate::contender::Deadband`]'s.

mod optimiser;

use crate::{
    contender::Deadband,
    fitted::Fitted,
    size_class::{LONGEST_SEQUENCE, MEMORY, SimScalar},
};
use optimiser::Optimiser;
use slqg::{controller::Controller, gains::Gains, sequence::ControlSequence, tracking::Feedforward, wire};

/// A sequence of any size class.
type Sequence<T, const NU: usize> = ControlSequence<T, NU, LONGEST_SEQUENCE>;

/// What is decided in the cycles of one run, and what has to be remembered for it.
pub struct Decision<'f, T: SimScalar, const NX: usize, const NU: usize>(Rule<'f, T, NX, NU>);

enum Rule<'f, T: SimScalar, const NX: usize, const NU: usize> {
    /// Nothing: the core's law and its event trigger decide.
    Core,
    /// Whether to send.
    Deadband {
        rule: Deadband,
        /// The last sequence sent.
        sent: Option<Sequence<T, NU>>,
    },
    /// What to send.
    Constrained {
        /// Gains of which the sequence is what is expected in flight.
        probe: Gains<'f, T, NX, NU>,
        optimiser: Box<Optimiser>,
    },
}

impl<'f, T: SimScalar, const NX: usize, const NU: usize> Decision<'f, T, NX, NU> {
    /// For a run that begins.
    ///
    /// # Panics
    /// If [`Fitted::design`] refuses the tables.
    pub fn new<const NY: usize>(fitted: &'f Fitted<T, NX, NU, NY>) -> Self {
        Self(match (fitted.deadband(), fitted.constrained()) {
            (Some(rule), _) => Rule::Deadband { rule, sent: None },
            (None, Some((problem, probe))) => {
                Rule::Constrained { probe, optimiser: Box::new(Optimiser::new(problem)) }
            }
            (None, None) => Rule::Core,
        })
    }

    /// Runs one cycle of `controller`; what is to be sent stands in `buffer`, `None` if nothing is.
    ///
    /// # Panics
    /// If `buffer` does not hold every frame.
    pub fn cycle<'b, const NY: usize, const E: usize>(
        &mut self,
        controller: &mut Controller<'f, T, NX, NU, NY, LONGEST_SEQUENCE, MEMORY, E>,
        buffer: &'b mut [u8],
    ) -> Option<&'b [u8]> {
        match &mut self.0 {
            Rule::Core => {}
            Rule::Deadband { rule, sent } => {
                let mut ahead = controller.clone();
                let candidate = sequence(ahead.cycle(buffer).expect("the buffer holds every frame"));
                if !candidate.as_ref().is_some_and(|candidate| rule.sends(candidate, sent.as_ref())) {
                    // Without room for a frame the core notes that none was sent.
                    let _ = controller.cycle(&mut []);
                    return None;
                }
                *sent = candidate;
            }
            Rule::Constrained { probe, optimiser } => {
                let mut ahead = controller.clone();
                ahead.set_gains(*probe).expect("gains of the design's length");
                ahead.set_feedforward(Feedforward::default()).expect("none is finite");
                let expected = sequence(ahead.cycle(buffer).expect("the buffer holds every frame"));
                // Of nothing finite nothing can be planned; the core's own law has nothing to send then either.
                let feedforward = expected.map_or_else(Feedforward::default, |expected| {
                    optimiser.sequence(ahead.estimator().posterior_mean(), &expected.inputs)
                });
                controller.set_feedforward(feedforward).expect("inputs within limits are finite");
            }
        }
        controller.cycle(buffer).expect("the buffer holds every frame")
    }
}

/// The sequence in a frame that the core has just written.
fn sequence<T: SimScalar, const NU: usize>(frame: Option<&[u8]>) -> Option<Sequence<T, NU>> {
    frame.map(|frame| wire::decode_control(frame).expect("the core reads its own frames"))
}
