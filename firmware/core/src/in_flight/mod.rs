//! What was sent and may still be applied, and the input to expect from it.
//!
//! The thesis carries all of it as the vector rho (3.26) and needs one gain per actuator mode. Here it is
//! condensed to `vbar`, the expected input in each coming cycle if nothing newer arrived (THEORY 3), which
//! is all that the optimal law needs to know of the mode.
//!
//! | file | what lives there |
//! |---|---|
//! | `expected` | the expected inputs |
//! | `newest` | the same, given which packet is the newest that has arrived |
//! | `arrivals` | the recursion that both come from, over packets that may yet arrive |
//! | `under_way` | these packets |
//! | `recent` | the ring that sequences are remembered in |

mod arrivals;
mod expected;
mod newest;
mod recent;
mod under_way;

use crate::{DefaultInput, Scalar, Tick, actuator::Age, estimator::Modes, sequence::ControlSequence};
use heapless::Vec;
use nalgebra::SVector;
use recent::Recent;

pub use arrivals::add_newer;

/// The sequences sent in the last `N + H` cycles, and the input applied last.
///
/// `N` is the capacity of a sequence; those sent in the last `N` cycles may still be applied. The ones before
/// may have been applied up to `H` cycles ago, of which an acknowledgement may tell late. One cycle is:
/// [`InFlight::acknowledge`] what was played in the last cycle, or [`InFlight::believe`] what may have been,
/// [`InFlight::expected_inputs`], then [`InFlight::push`] what was sent (or that nothing was).
#[derive(Debug, Clone)]
pub struct InFlight<T: Scalar, const NU: usize, const N: usize, const H: usize> {
    sent: Recent<T, NU, N, N>,
    /// What came before `sent`.
    run_out: Recent<T, NU, N, H>,
    played: Played<T, NU, N>,
}

/// What the actuator played in the last cycle.
#[derive(Debug, Clone)]
enum Played<T: Scalar, const NU: usize, const N: usize> {
    /// That for certain, and the input it made the actuator apply.
    Known(Age, SVector<T, NU>),
    /// One of several. `oldest` is what was applied if that was a sequence's last input.
    Believed { modes: Modes<T, NU, N>, oldest: SVector<T, NU> },
}

impl<T: Scalar, const NU: usize, const N: usize, const H: usize> Default for InFlight<T, NU, N, H> {
    fn default() -> Self {
        let played = Played::Known(Age::Empty, SVector::zeros());
        Self { sent: Recent::default(), run_out: Recent::default(), played }
    }
}

impl<T: Scalar, const NU: usize, const N: usize, const H: usize> InFlight<T, NU, N, H> {
    /// Takes note of what was sent in this cycle; `None` if nothing was.
    pub fn push(&mut self, sequence: Option<ControlSequence<T, NU, N>>) {
        let nothing = ControlSequence { tick: Tick(0), inputs: Vec::new() };
        let oldest = self.sent.push(sequence.unwrap_or(nothing));
        self.run_out.push(oldest);
    }

    /// The sequence made in cycle `tick`, if one was sent then and is remembered.
    pub fn made_at(&self, tick: Tick) -> Option<&ControlSequence<T, NU, N>> {
        self.sent.iter().chain(self.run_out.iter()).find(|sequence| sequence.tick == tick)
    }

    /// The input that the actuator applied in cycle `tick` if its buffer had `age` then.
    ///
    /// `None` if no such sequence was sent, or too long ago to remember: an acknowledgement that claims it
    /// deserves no belief. For [`Age::Empty`] with hold the input depends on the past; `held` is that of the
    /// cycle before.
    pub fn applied_input(
        &self,
        default_input: DefaultInput,
        tick: Tick,
        age: Age,
        held: &SVector<T, NU>,
    ) -> Option<SVector<T, NU>> {
        match age {
            Age::Steps(steps) => self.made_at(tick - u32::from(steps))?.input_at(tick).copied(),
            Age::Empty => Some(match default_input {
                DefaultInput::Zero => SVector::zeros(),
                DefaultInput::Hold => *held,
            }),
        }
    }

    /// Takes note of what the actuator played in the last cycle, for certain, and of what it applied.
    pub fn acknowledge(&mut self, age: Age, input: SVector<T, NU>) {
        self.played = Played::Known(age, input);
    }

    /// Takes note of what the actuator may have played in the last cycle, where that is not certain. `oldest` is what was
    /// applied if that was a sequence's last input.
    pub fn believe(&mut self, modes: Modes<T, NU, N>, oldest: SVector<T, NU>) {
        self.played = Played::Believed { modes, oldest };
    }
}
