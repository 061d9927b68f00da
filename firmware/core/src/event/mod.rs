//! Whether a packet is worth sending: thesis chapter 5, exact under its rollout. THEORY 7.
//!
//! A sequence is sent iff it is expected to save more than a packet costs, given that every later one is sent. What it
//! saves is a quadratic in the estimate, in what is in flight and in the sequence itself, with constant tables. Which
//! packets were sent enters only through what is in flight; there is no table over the history of decisions.
//!
//! The tables come from [`crate::synthesis::Synthesis::fill_trigger`]; what is in flight is [`crate::in_flight`]'s.
//!
//! | file | what lives there |
//! |---|---|
//! | `always` | the tables, and what a packet is worth by them |
//! | `schedule` | the same where later packets go out in every p-th cycle; only with the feature `schedule` |

mod always;
#[cfg(feature = "schedule")]
mod schedule;

use crate::{
    Scalar,
    checked::NonNegative,
    gains::Gains,
    in_flight::InFlight,
    played::{DefaultInput, Played},
};
use nalgebra::SVector;

pub use always::{TableLengths, Tables, packed_index};
#[cfg(feature = "schedule")]
pub use schedule::{ScheduleTables, phase_len};

/// Decides whether a sequence is sent.
///
/// ```
/// use slqg::checked::{Finite, NonNegative};
/// use slqg::event::{Tables, Trigger};
/// use slqg::DefaultInput;
///
/// // One input a sequence: nothing is in flight, and sending `u` saves `2 u^2`.
/// let tables = Tables::check(&[], &[], &[2.0_f32]).expect("finite");
/// let cost = NonNegative::<f32>::new(10.0);
/// let trigger = Trigger::<f32, 1, 1>::check(1, DefaultInput::Zero, cost, tables).expect("tables that fit");
/// assert!(trigger.is_worth_sending(2.0 * 3.0 * 3.0));
/// assert!(!trigger.is_worth_sending(2.0 * 2.0 * 2.0));
/// # use slqg::event::Candidate;
/// # use slqg::{gains, in_flight::InFlight, nalgebra::Vector1, played::Played, Tick};
/// # let law = gains::Tables::check(&[-1.0], &[], &[]).expect("finite");
/// # let law = gains::Gains::<f32, 1, 1>::check(1, DefaultInput::Zero, law).expect("tables that fit");
/// # let (mut sent, mut inputs) = ([false; 3], [Vector1::zeros(); 3]);
/// # let in_flight = InFlight::new(1, Tick(0), &mut sent, &mut inputs);
/// let candidate = Candidate {
///     posterior_mean: &Vector1::new(-3.0),
///     expected: &[],
///     inputs: &[Vector1::new(3.0)],
///     displaced: &[],
///     played: Played::nothing(),
/// };
/// assert_eq!(trigger.benefit(&law, &in_flight, &candidate, &mut [], &mut []), 18.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trigger<'a, T, const NX: usize, const NU: usize> {
    length: usize,
    default_input: DefaultInput,
    send_cost: NonNegative<T>,
    later: Later<'a, T>,
}

/// What is done in later cycles, with the tables for it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Later<'a, T> {
    /// A packet is sent in each.
    Always(Tables<'a, T>),
    /// In every p-th.
    #[cfg(feature = "schedule")]
    Scheduled(ScheduleTables<'a, T>),
    /// The same, and a packet is sent in every p-th cycle whatever it is worth.
    #[cfg(feature = "schedule")]
    Fixed {
        /// `p`, at least 1.
        period: usize,
    },
}

/// Why tables are not a trigger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InvalidTrigger {
    /// A table has another length than [`TableLengths`] says.
    TableLength,
    /// A number in a table is not finite.
    NotFinite,
}

impl InvalidTrigger {
    const fn message(self) -> &'static str {
        match self {
            Self::TableLength => "a table does not have the entries that the dimensions ask for",
            Self::NotFinite => "a number is not finite",
        }
    }
}

impl core::fmt::Display for InvalidTrigger {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for InvalidTrigger {}

impl<'a, T: Copy, const NX: usize, const NU: usize> Trigger<'a, T, NX, NU> {
    /// A trigger for sequences of `length` inputs. The number in `send_cost` is the cost of one packet, in units of the stage
    /// cost; a packet that costs nothing is always sent.
    ///
    /// # Errors
    /// Says what about the tables is wrong.
    pub const fn check(
        length: usize,
        default_input: DefaultInput,
        send_cost: NonNegative<T>,
        tables: Tables<'a, T>,
    ) -> Result<Self, InvalidTrigger> {
        if !tables.fit(length, default_input, NX, NU) {
            return Err(InvalidTrigger::TableLength);
        }
        Ok(Self { length, default_input, send_cost, later: Later::Always(tables) })
    }

    /// A trigger that takes later packets to be sent in every p-th cycle; the law must be the one that is optimal for that.
    ///
    /// # Errors
    /// Says what about the tables is wrong.
    #[cfg(feature = "schedule")]
    pub const fn check_schedule(
        length: usize,
        default_input: DefaultInput,
        send_cost: NonNegative<T>,
        tables: ScheduleTables<'a, T>,
    ) -> Result<Self, InvalidTrigger> {
        if !tables.fit(length, default_input, NX, NU) {
            return Err(InvalidTrigger::TableLength);
        }
        Ok(Self { length, default_input, send_cost, later: Later::Scheduled(tables) })
    }

    /// No trigger at all: packets go out in the cycles whose number is a multiple of `period`, at least 1, whatever they are worth.
    /// The law must be the one that is optimal for that.
    ///
    /// What a time-triggered bus has slots for. Cycles are counted modulo 2^32; once they begin anew, one interval is shorter
    /// unless `period` is a power of two.
    #[cfg(feature = "schedule")]
    pub const fn fixed(
        length: usize,
        default_input: DefaultInput,
        send_cost: NonNegative<T>,
        period: usize,
    ) -> Self {
        Self {
            length,
            default_input,
            send_cost,
            later: Later::Fixed { period: if period == 0 { 1 } else { period } },
        }
    }

    /// The same from constant tables.
    ///
    /// # Panics
    /// On tables that it refuses. Meant for constants, where that is a compile error.
    #[cfg(feature = "schedule")]
    pub const fn scheduled(
        length: usize,
        default_input: DefaultInput,
        send_cost: NonNegative<T>,
        tables: ScheduleTables<'a, T>,
    ) -> Self {
        match Self::check_schedule(length, default_input, send_cost, tables) {
            Ok(trigger) => trigger,
            Err(error) => panic!("{}", error.message()),
        }
    }

    /// A trigger from constant tables; arguments as those of [`Trigger::check`].
    ///
    /// # Panics
    /// On tables that it refuses. Meant for constants, where that is a compile error.
    pub const fn new(
        length: usize,
        default_input: DefaultInput,
        send_cost: NonNegative<T>,
        tables: Tables<'a, T>,
    ) -> Self {
        match Self::check(length, default_input, send_cost, tables) {
            Ok(trigger) => trigger,
            Err(error) => panic!("{}", error.message()),
        }
    }
}

/// What is decided about: the sequence of the optimal law, and what the law made it from.
#[derive(Debug, Clone, Copy)]
pub struct Candidate<'c, T, const NX: usize, const NU: usize> {
    /// Estimate of the state, given all that has arrived.
    pub posterior_mean: &'c SVector<T, NX>,
    /// `vbar`, `n_v` inputs.
    pub expected: &'c [SVector<T, NU>],
    /// `U`, the sequence that might be sent, `N` inputs.
    pub inputs: &'c [SVector<T, NU>],
    /// What `expected` is worth towards the reference, see [`crate::tracking::Feedforward`]; empty without one.
    pub displaced: &'c [SVector<T, NU>],
    /// What was played in the last cycle.
    pub played: Played<'c, T, NU>,
}

impl<T: Scalar, const NX: usize, const NU: usize> Trigger<'_, T, NX, NU> {
    /// Inputs per sequence, `N`.
    pub const fn length(&self) -> usize {
        self.length
    }

    /// What it is made of: three tables.
    pub(crate) const fn tables(&self) -> [&[T]; 3] {
        match &self.later {
            Later::Always(tables) => {
                [tables.state.numbers(), tables.in_flight.numbers(), tables.sequence.numbers()]
            }
            #[cfg(feature = "schedule")]
            Later::Scheduled(tables) => {
                [tables.phases.numbers(), tables.in_flight.numbers(), tables.decided.numbers()]
            }
            #[cfg(feature = "schedule")]
            Later::Fixed { .. } => [&[], &[], &[]],
        }
    }

    /// Cycles from one later packet to the next.
    pub const fn period(&self) -> usize {
        match &self.later {
            Later::Always(_) => 1,
            #[cfg(feature = "schedule")]
            Later::Scheduled(tables) => tables.period,
            #[cfg(feature = "schedule")]
            Later::Fixed { period } => *period,
        }
    }

    /// Whether it knows what the inputs in flight are worth towards a reference.
    pub(crate) const fn follows_reference(&self) -> bool {
        matches!(self.later, Later::Always(_))
    }

    /// Numbers to work in that [`Trigger::benefit`] takes.
    pub const fn numbers_len(&self) -> usize {
        match &self.later {
            Later::Always(_) => 0,
            #[cfg(feature = "schedule")]
            Later::Scheduled(tables) => {
                schedule::numbers_len(self.default_input.in_flight(self.length) * NU, tables.period)
            }
            #[cfg(feature = "schedule")]
            Later::Fixed { .. } => 0,
        }
    }

    /// The cost of one packet, in units of the stage cost.
    pub(crate) const fn send_cost(&self) -> &T {
        self.send_cost.number_ref()
    }

    /// What the actuator does when its buffer has run out; the tables are for this choice only.
    pub const fn default_input(&self) -> DefaultInput {
        self.default_input
    }

    /// The same tables with another cost of a packet, which may change while the controller runs; what is negative or
    /// not a number counts as zero.
    #[must_use]
    pub fn with_send_cost(self, send_cost: T) -> Self {
        Self { send_cost: NonNegative::or_zero(send_cost), ..self }
    }

    /// Expected cost, over all time to come, that sending `candidate` saves against not sending in this cycle: thesis
    /// Lemma 5.1 with its sign turned and its misprints mended. `gains`, for sequences of the same length and the same
    /// default input, tell how likely what is in flight still arrives; `room` has room for `n_v` inputs to work with, `numbers` for
    /// [`Trigger::numbers_len`].
    ///
    /// Where later packets go out in every p-th cycle, it may be better to wait for `s` cycles and to send in every p-th from then on.
    /// Then it is the price of a packet up to which none of that is better. THEORY 15.
    ///
    /// It may be below zero: a packet that arrives late can part inputs in flight that were made for each other.
    pub fn benefit(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        in_flight: &InFlight<'_, T, NU>,
        candidate: &Candidate<'_, T, NX, NU>,
        room: &mut [SVector<T, NU>],
        numbers: &mut [T],
    ) -> T {
        // Sending always takes no numbers to work in.
        let _ = &numbers;
        match &self.later {
            Later::Always(tables) => tables.benefit(gains, in_flight, candidate, room),
            #[cfg(feature = "schedule")]
            Later::Scheduled(tables) => tables.benefit(gains, in_flight, candidate, room, numbers),
            // Nothing is weighed.
            #[cfg(feature = "schedule")]
            Later::Fixed { .. } => T::nearest(f64::INFINITY),
        }
    }

    /// Cycles between packets that go by the clock alone.
    pub(crate) const fn fixed_period(&self) -> Option<usize> {
        match &self.later {
            Later::Always(_) => None,
            #[cfg(feature = "schedule")]
            Later::Scheduled(_) => None,
            #[cfg(feature = "schedule")]
            Later::Fixed { period } => Some(*period),
        }
    }

    /// Whether something worth `benefit` is sent. What cannot be judged is sent.
    pub fn is_worth_sending(&self, benefit: T) -> bool {
        let send_cost = self.send_cost.number();
        let saves_too_little = send_cost > T::zero() && benefit <= send_cost;
        !saves_too_little
    }
}
