//! What some controllers decide on the host, between the core's proposal and the end of its cycle.
//!
//! Estimate, bookkeeping of what is in flight, law and frames are the core's for every controller. Where more is to be
//! decided, the core proposes a sequence and tells what it was made from; whether it is sent, or what in its place, is said
//! here. The quadratic program of constrained model predictive control is in `optimiser`; the rule of the deadband is
//! [`crate::contender::Deadband`]'s.

mod optimiser;

use crate::{contender::Deadband, fitted::Fitted};
use nalgebra::SVector;
use optimiser::Optimiser;
use slqg::{Scalar, Tick, controller::Controller, sequence::ControlSequence, wire};

/// What is decided in the cycles of one run, and what has to be remembered for it.
pub struct Decision<T: Scalar, const NU: usize>(Rule<T, NU>);

enum Rule<T: Scalar, const NU: usize> {
    /// Nothing: the core's law and its event trigger decide.
    Core,
    /// Whether to send.
    Deadband {
        rule: Deadband,
        /// The last sequence sent.
        sent: Option<(Tick, Vec<SVector<T, NU>>)>,
    },
    /// What to send.
    Constrained(Box<Optimiser>),
}

impl<T: Scalar, const NU: usize> Decision<T, NU> {
    /// For a run that begins.
    pub fn new<const NX: usize, const NY: usize>(fitted: &Fitted<T, NX, NU, NY>) -> Self {
        Self(match (fitted.deadband(), fitted.constrained()) {
            (Some(rule), _) => Rule::Deadband { rule, sent: None },
            (None, Some(problem)) => Rule::Constrained(Box::new(Optimiser::new(problem))),
            (None, None) => Rule::Core,
        })
    }

    /// Runs one cycle of `controller`; what is to be sent stands in `buffer`, `None` if nothing is.
    ///
    /// # Panics
    /// If `buffer` does not hold every frame.
    pub fn cycle<'b, const NX: usize, const NY: usize>(
        &mut self,
        controller: &mut Controller<'_, T, NX, NU, NY>,
        buffer: &'b mut [u8],
    ) -> Option<&'b [u8]> {
        let frame = match &mut self.0 {
            Rule::Core => return controller.cycle(buffer).expect("the buffer holds every frame"),
            Rule::Deadband { rule, sent } => {
                let candidate = controller.propose().sequence;
                let last = sent.as_ref().map(|(tick, inputs)| ControlSequence { tick: *tick, inputs });
                let is_sent = candidate.is_finite() && rule.sends(&candidate, last.as_ref());
                is_sent.then(|| {
                    *sent = Some((candidate.tick, candidate.inputs.to_vec()));
                    written(&candidate, buffer)
                })
            }
            Rule::Constrained(optimiser) => {
                let proposal = controller.propose();
                // Of nothing finite nothing can be planned; the core's own law has nothing to send then either.
                let plan = proposal
                    .sequence
                    .is_finite()
                    .then(|| optimiser.sequence(proposal.posterior_mean, proposal.expected));
                plan.map(|inputs| {
                    written(&controller.replace(&inputs).expect("inputs within limits are finite"), buffer)
                })
            }
        };
        controller.commit(frame.is_some());
        frame
    }
}

fn written<'b, T: Scalar, const NU: usize>(
    sequence: &ControlSequence<'_, T, NU>,
    buffer: &'b mut [u8],
) -> &'b [u8] {
    wire::encode_control(sequence, buffer).expect("the buffer holds every frame")
}
