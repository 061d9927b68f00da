//! `Controller`: one control cycle, measurement and acknowledgement frames in, control frame out.
//!
//! It ties the rooms together and decides nothing itself: the estimate is [`crate::estimator`]'s, the
//! expected inputs [`crate::in_flight`]'s, the law [`crate::gains`]', the feedforward [`crate::tracking`]'s, whether to send
//! [`crate::event`]'s, the bytes [`crate::wire`]'s.
//!
//! | file | what lives there |
//! |---|---|
//! | `design` | what it is told at design time |
//! | `law` | what it may be told later: another law |
//! | `receive` | frames in |
//! | `cycle` | the cycle, and its frame out |

mod cycle;
mod design;
mod law;
mod receive;

use crate::{
    Scalar, Tick,
    actuator::Age,
    estimator::{ModeFilter, Surroundings},
    event::Trigger,
    gains::Gains,
    in_flight::InFlight,
    tracking::{Feedforward, RejectedReference},
};
use nalgebra::SVector;

pub use design::{Design, InvalidDesign};
pub use law::{CycleError, Law};
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
}

/// The controller end of the link.
///
/// Each cycle: any number of [`Controller::receive`], [`Controller::follow`] if the reference has moved, then one
/// [`Controller::cycle`].
///
/// A missing acknowledgement is no information: what the actuator may have played then is as likely as the link makes it,
/// and what the measurements make of it, until an acknowledgement decides. While the estimator remembers the cycle, a late
/// one does: what is believed depends on which acknowledgements have come, not on their order.
#[derive(Debug, Clone)]
pub struct Controller<
    'a,
    T: Scalar,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
    const E: usize = 1,
> {
    design: Design<'a, T, NX, NU, NY>,
    filter: ModeFilter<T, NX, NU, NY, N, H, E>,
    in_flight: InFlight<T, NU, N, H>,
    feedforward: Feedforward<T, NU, N>,
    rounds_age: bool,
    counts: Counts,
}

impl<
    'a,
    T: Scalar,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
    const E: usize,
> Controller<'a, T, NX, NU, NY, N, H, E>
{
    /// A controller whose first cycle is `tick`.
    ///
    /// # Errors
    /// If the gains' sequences or the measurement buffer do not fit the capacities, or the actuator behaves unlike
    /// the gains assume.
    pub fn new(design: Design<'a, T, NX, NU, NY>, tick: Tick) -> Result<Self, InvalidDesign> {
        design.check(N, H, E)?;
        Ok(Self {
            filter: ModeFilter::new(design.model, design.measurement_buffer, tick)
                .remembering(design.acknowledgement_buffer),
            in_flight: InFlight::default(),
            feedforward: Feedforward::default(),
            rounds_age: false,
            counts: Counts::default(),
            design,
        })
    }

    /// Replaces the control law from the next cycle on: for time-varying gains, or gains for a link that has changed.
    /// Preview gains and trigger stay as they are.
    ///
    /// # Errors
    /// If the gains are for sequences of another length or for another default input; the law stays as it was.
    pub fn set_gains(&mut self, gains: Gains<'a, T, NX, NU>) -> Result<(), InvalidDesign> {
        self.design.check_law(gains.length(), gains.default_input())?;
        self.design.gains = gains;
        Ok(())
    }

    /// Replaces the trigger from the next cycle on: where a packet's cost changes, [`Trigger::with_send_cost`], or the law
    /// does; `None` sends in every cycle.
    ///
    /// # Errors
    /// If it does not fit the design; the one before stays.
    pub fn set_trigger(&mut self, trigger: Option<Trigger<'a, T, NX, NU>>) -> Result<(), InvalidDesign> {
        let design = Design { trigger, ..self.design };
        design.check_trigger()?;
        self.design = design;
        Ok(())
    }

    /// Follows `reference`: the samples `z_{k+1}, z_{k+2}, ..`, where `k` is the cycle that [`Controller::cycle`] runs
    /// next.
    ///
    /// Samples beyond the design's preview change nothing, and of fewer the last one stands for those missing: a set point
    /// is one sample. The feedforward stays in force until the next call, so a reference that moves is handed over in
    /// every cycle. Before the first call the reference is zero.
    ///
    /// # Errors
    /// Says why the reference is not followed; the one before stays in force.
    pub fn follow<const NZ: usize>(&mut self, reference: &[SVector<T, NZ>]) -> Result<(), RejectedReference> {
        let preview = self.design.preview.as_ref().ok_or(RejectedReference::NoPreview)?;
        self.feedforward = preview.feedforward(reference)?;
        Ok(())
    }

    /// Sets the feedforward of the next cycle and those after it, where it was computed beforehand: for tasks of finite
    /// length, cycle by cycle along with [`Controller::set_gains`]. The design needs no preview for that.
    ///
    /// # Errors
    /// If it is not finite; the one before stays in force.
    pub fn set_feedforward(&mut self, feedforward: Feedforward<T, NU, N>) -> Result<(), RejectedReference> {
        if !feedforward.is_finite() {
            return Err(RejectedReference::NotFinite);
        }
        self.feedforward = feedforward;
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
    pub fn estimator(&self) -> &ModeFilter<T, NX, NU, NY, N, H, E> {
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
fn around<
    's,
    T: Scalar,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
>(
    design: &'s Design<'_, T, NX, NU, NY>,
    law: &'s Law<'_, T, NX, NU>,
    in_flight: &'s InFlight<T, NU, N, H>,
) -> Surroundings<'s, T, NX, NU, NY, N, H> {
    let Design { model, actuator, merging, .. } = design;
    let Law { gains, arrives_at_once } = law;
    Surroundings { model, in_flight, actuator, gains, arrives_at_once: *arrives_at_once, merging: *merging }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
