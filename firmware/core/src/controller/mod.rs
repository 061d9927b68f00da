//! `Controller`: one control cycle, measurement and acknowledgement frames in, control frame out.
//!
//! It ties the rooms together and decides nothing itself: the estimate is [`crate::estimator`]'s, the
//! expected inputs [`crate::in_flight`]'s, the law [`crate::gains`]', the feedforward [`crate::tracking`]'s, whether to send
//! [`crate::event`]'s, the bytes [`crate::wire`]'s.
//!
//! | file | what lives there |
//! |---|---|
//! | `design` | what it is told at design time |
//! | `memory` | what it is lent to remember in |
//! | `law` | what it may be told later: another law |
//! | `reference` | what it is to follow |
//! | `receive` | frames in |
//! | `integrity` | whether what it was told is still as it was |
//! | `watch` | readings that no sensor has, or that do not change; how this end is |
//! | `proposal` | a cycle in two steps: the sequence, and whether it is sent |
//! | `cycle` | the cycle, and its frame out |

mod cycle;
mod design;
mod integrity;
mod law;
mod memory;
mod proposal;
mod receive;
mod reference;
mod watch;

use crate::{
    Scalar, Tick,
    estimator::{ModeFilter, Remembered, Surroundings},
    event::Trigger,
    gains::Gains,
    in_flight::InFlight,
    played::Age,
};
use integrity::Check;
use nalgebra::SVector;
use watch::Watch;

pub use design::{Design, InvalidDesign};
pub use integrity::Checksums;
pub use law::{CycleError, Law};
pub use memory::{Memory, Sizes};
pub use proposal::{Proposal, RejectedInputs};
pub use receive::RejectedFrame;

/// What a controller counted since its start; every count saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames that changed nothing.
    pub rejected_frames: u32,
    /// Cycles whose acknowledgement had not come when the next one began.
    pub unacknowledged: u32,
    /// Cycles in which no finite sequence could be computed, and none was sent.
    pub not_finite: u32,
    /// Cycles in which the sequence was not worth a packet, and none was sent.
    pub not_worth_sending: u32,
    /// Cycles in which the estimate had become of no use, after too long without measurements, and began anew with what a
    /// controller that joins the loop knows.
    pub begun_anew: u32,
    /// Cycles in which nothing was sent because the loop was lost, [`Controller::health`].
    pub withheld: u32,
}

/// What happened in the cycle that ran last.
#[derive(Debug, Clone, Copy, Default)]
struct Last {
    begun_anew: bool,
    not_finite: bool,
}

/// The controller end of the link.
///
/// Each cycle: any number of [`Controller::receive`], [`Controller::follow`] if the reference has moved, then one
/// [`Controller::cycle`].
///
/// A missing acknowledgement is no information: what the actuator may have played then is as likely as the link makes it,
/// and what the measurements make of it, until an acknowledgement decides. While the estimator remembers the cycle, a late
/// one does: what is believed depends on which acknowledgements have come, not on their order.
///
/// ```
/// use slqg::actuator::Settings;
/// use slqg::controller::{Controller, Design, Sizes};
/// use slqg::estimator::{Merging, Model, Plausibility};
/// use slqg::nalgebra::{Matrix2, RowVector2, Vector1, Vector2};
/// use slqg::wire::{self, Acknowledgement, Measurement};
/// use slqg::{Age, DefaultInput, Tick};
/// # use slqg::checked::{Finite, Probabilities};
/// # use slqg::gains::{Gains, Tables};
/// # const LAW: Gains<'static, f32, 2, 1> = Gains::<f32, 2, 1>::new(
/// #     2,
/// #     DefaultInput::Zero,
/// #     Tables {
/// #         lx: Finite::<f32>::new(&[-3.0, -2.5, -2.5, -2.25]),
/// #         m: Finite::<f32>::new(&[0.0, -0.5]),
/// #         arrival: Probabilities::<f32>::new(&[0.5]),
/// #     },
/// # );
///
/// let model = Model {
///     a: Matrix2::new(1.0, 0.1, 0.0, 1.0),
///     b: Vector2::new(0.005, 0.1),
///     c: RowVector2::new(1.0, 0.0),
///     process_noise: Matrix2::identity() * 1e-4,
///     measurement_noise: Vector1::new(1e-4),
///     initial_mean: Vector2::zeros(),
///     initial_covariance: Matrix2::identity(),
/// };
/// // `LAW` is as in the example of `Gains`: two inputs a sequence.
/// let design = Design {
///     gains: LAW,
///     model: &model,
///     actuator: Settings { default_input: DefaultInput::Zero, limits: None, safe: None },
///     measurement_buffer: 4,
///     acknowledgement_buffer: 4,
///     preview: None,
///     trigger: None,
///     arrives_at_once: 0.5,
///     merging: Merging::Single,
///     plausibility: &Plausibility::NONE,
///     grid: None,
/// };
/// slqg::controller_memory!(struct Memory: f32, 2, 1, 1; Sizes::of(2, 5, 1));
/// let mut memory = Memory::new();
/// assert_eq!(design.sizes(), memory.lend().sizes());
/// let mut controller = Controller::new(design, Tick(0), memory.lend()).expect("a design that fits");
///
/// controller.measured(&Measurement { tick: Tick(0), output: Vector1::new(1.0) }).expect("in time");
/// let mut buffer = [0; wire::control_len(1, 2, 4)];
/// let frame = controller.cycle(&mut buffer).expect("there is room").expect("everything is sent");
/// assert_eq!(frame.len(), buffer.len());
/// controller.acknowledged(&Acknowledgement::of(Tick(0), Age::Steps(0))).expect("it was sent");
/// controller.cycle(&mut buffer).expect("there is room");
/// assert!(controller.expected_input(Tick(0)).expect("over")[0] < 0.0, "towards zero");
/// ```
#[derive(Debug)]
pub struct Controller<'m, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    design: Design<'m, T, NX, NU, NY>,
    filter: ModeFilter<'m, T, NX, NU, NY>,
    in_flight: InFlight<'m, T, NU>,
    /// `vbar` of the current cycle, once it is proposed.
    expected: &'m mut [SVector<T, NU>],
    /// `Uff`; zero unless a reference is followed.
    feedforward: &'m mut [SVector<T, NU>],
    is_fed_forward: bool,
    /// What is in flight is worth towards the reference, the first `displaced_len` of them.
    displaced: &'m mut [SVector<T, NU>],
    displaced_len: usize,
    room: &'m mut [SVector<T, NU>],
    /// Numbers to work in.
    #[cfg(feature = "schedule")]
    numbers: &'m mut [T],
    is_proposed: bool,
    rounds_age: bool,
    counts: Counts,
    watch: Watch<T, NY>,
    last: Last,
    check: Check,
}

impl<'m, T: Scalar, const NX: usize, const NU: usize, const NY: usize> Controller<'m, T, NX, NU, NY> {
    /// A controller whose first cycle is `tick`. It takes [`Design::sizes`] of memory.
    ///
    /// # Errors
    /// If the design does not fit together, or does not fit the memory.
    pub fn new(
        design: Design<'m, T, NX, NU, NY>,
        tick: Tick,
        memory: Memory<'m, T, NX, NU, NY>,
    ) -> Result<Self, InvalidDesign> {
        design.check()?;
        let (length, needed) = (design.gains.length(), design.sizes());
        if !memory.sizes().holds(&needed) {
            return Err(InvalidDesign::Memory(needed));
        }
        let Memory { cycles, estimates, ages, sent, inputs } = memory;
        let cycles = cycles.get_mut(..needed.cycles).unwrap_or_default();
        #[cfg(feature = "schedule")]
        let (numbers, ages) = ages.split_at_mut_checked(design.numbers()).unwrap_or_default();
        let remembered = if design.merging.is_linear() {
            Remembered::without_ages(cycles, estimates)
        } else {
            Remembered::new(cycles, ages, estimates, length, design.merging.estimates(length))
        };
        let remembered = remembered.ok_or(InvalidDesign::Memory(needed))?;
        let (inputs, rest) = inputs.split_at_mut(needed.in_flight(length));
        let (expected, rest) = rest.split_at_mut(length);
        let (feedforward, rest) = rest.split_at_mut(length);
        let (displaced, rest) = rest.split_at_mut(length);
        let sent = sent.get_mut(..needed.sent).unwrap_or_default();
        feedforward.fill(SVector::zeros());
        let mut in_flight = InFlight::new(length, tick, sent, inputs);
        if design.merging.is_linear() {
            in_flight.begin_mean();
        }
        Ok(Self {
            filter: ModeFilter::new(design.model, design.measurement_buffer, tick, remembered),
            in_flight,
            expected,
            feedforward,
            is_fed_forward: false,
            displaced,
            displaced_len: 0,
            room: rest.get_mut(..length).unwrap_or_default(),
            #[cfg(feature = "schedule")]
            numbers,
            is_proposed: false,
            rounds_age: false,
            counts: Counts::default(),
            watch: Watch::NEW,
            last: Last::default(),
            check: Check::NEW,
            design,
        })
    }

    /// Begins anew with cycle `tick` and this design, as a controller that has just been made in the same memory; but memory that
    /// has changed by itself is not trusted again.
    ///
    /// # Errors
    /// As [`Controller::new`]; then nothing has changed.
    pub fn restart(&mut self, design: Design<'m, T, NX, NU, NY>, tick: Tick) -> Result<(), InvalidDesign> {
        design.check()?;
        if design.sizes() != self.design.sizes() {
            return Err(InvalidDesign::Memory(design.sizes()));
        }
        self.filter.restart(design.model, design.measurement_buffer, tick);
        self.in_flight.restart(tick);
        if design.merging.is_linear() {
            self.in_flight.begin_mean();
        }
        self.forget_reference();
        (self.is_proposed, self.rounds_age, self.counts) = (false, false, Counts::default());
        (self.watch, self.last) = (Watch::NEW, Last::default());
        self.design = design;
        self.check.restart();
        Ok(())
    }

    /// Replaces the control law from the next cycle on: for time-varying gains, or gains for a link that has changed.
    /// Preview gains and trigger stay as they are.
    ///
    /// # Errors
    /// If the gains are for sequences of another length or for another default input; the law stays as it was.
    pub fn set_gains(&mut self, gains: Gains<'m, T, NX, NU>) -> Result<(), InvalidDesign> {
        self.design.check_law(gains.length(), gains.default_input())?;
        self.design.gains = gains;
        self.check.is_law_replaced = true;
        Ok(())
    }

    /// Replaces the trigger from the next cycle on: where a packet's cost changes, [`Trigger::with_send_cost`], or the law
    /// does; `None` sends in every cycle.
    ///
    /// # Errors
    /// If it does not fit the design; the one before stays.
    pub fn set_trigger(&mut self, trigger: Option<Trigger<'m, T, NX, NU>>) -> Result<(), InvalidDesign> {
        let design = Design { trigger, ..self.design };
        design.check_trigger()?;
        #[cfg(feature = "schedule")]
        if design.numbers() > self.numbers.len() {
            return Err(InvalidDesign::Memory(design.sizes()));
        }
        self.design = design;
        self.check.is_law_replaced = true;
        Ok(())
    }

    /// Whether the law takes the mean age, rounded, for certain: thesis (3.43), to compare with. As it is made a controller
    /// weighs every age with its probability, THEORY 8.
    pub fn round_age(&mut self, rounds_age: bool) {
        self.rounds_age = rounds_age;
    }

    /// The cycle that [`Controller::cycle`] will run next.
    pub fn tick(&self) -> Tick {
        self.filter.tick()
    }

    /// What was counted since the start.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The estimator; after [`Controller::cycle`] its posterior is that of the cycle that ran.
    pub fn estimator(&self) -> &ModeFilter<'m, T, NX, NU, NY> {
        &self.filter
    }

    /// What is held to have been applied in cycle `tick`, in input units, under the design's law: a mean if that may be
    /// several inputs. `None` if the cycle is not over, or not remembered, or no cycle has run since.
    pub fn expected_input(&self, tick: Tick) -> Option<SVector<T, NU>> {
        self.filter.expected_input(&around(&self.design, &self.design.law(), &self.in_flight), tick)
    }

    /// The age that cycle `tick` was acknowledged with; `None` if no acknowledgement has come, or it is too long ago.
    pub fn acknowledged_age(&self, tick: Tick) -> Option<Age> {
        self.filter.acknowledged_age(tick)
    }

    /// Whether a sequence was sent in cycle `tick`, as far as is remembered: longer than an acknowledgement may tell of.
    pub fn has_sent(&self, tick: Tick) -> bool {
        self.in_flight.made_at(tick).is_some()
    }
}

/// The loop as the estimator sees it.
fn around<'s, T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: &'s Design<'_, T, NX, NU, NY>,
    law: &'s Law<'_, T, NX, NU>,
    in_flight: &'s InFlight<'_, T, NU>,
) -> Surroundings<'s, T, NX, NU, NY> {
    let Design { model, actuator, merging, plausibility, .. } = design;
    let Law { gains, arrives_at_once } = law;
    let (arrives_at_once, merging) = (*arrives_at_once, *merging);
    Surroundings { model, in_flight, actuator, gains, arrives_at_once, merging, plausibility }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
