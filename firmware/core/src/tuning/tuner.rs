//! [`Tuner`]: beside a controller, what is done when.
//!
//! It listens to the acknowledgements, notices that the link is no longer the one in force, has it solved for slice by slice,
//! and switches to the new law once that is proved to stabilise the loop. Estimating is in `delays`, solving in `solver`.

use super::{
    Basis, Counts, DelayEstimate, Event, InvalidTuner, Kept, Parameters, Progress, Solver, threshold,
};
use crate::{
    Scalar, Tick,
    bank::{Bank, InvalidLaw},
    controller::{Controller, Design, Law},
};

/// Looks at the distance in the time of one memory.
const LOOKS: u32 = 64;
/// Memories after which what was observed before a change no longer counts.
const SETTLED: u32 = 4;

/// Learns the link and keeps the law up with it.
///
/// Each cycle, in this order: the controller takes what has come; [`Tuner::observe`]; the controller's
/// [`Controller::cycle_under`] the law of [`Tuner::law`], or [`Controller::cycle`] while that is `None`; and once the frame
/// is sent, [`Tuner::slice`]. `N` is the controller's capacity, `LEN` that of the bank.
#[derive(Debug)]
pub struct Tuner<'a, 'w, T, const NX: usize, const NU: usize, const N: usize, const LEN: usize> {
    parameters: Parameters,
    delays: DelayEstimate<T, N>,
    /// Its link is the one being solved for; while it is idle, the last one that was.
    solver: Solver<'a, 'w, T, NX, NU, N>,
    bank: Bank<T, NX, NU, LEN>,
    /// Survival function of the link that the law in force is for.
    in_force: [T; N],
    /// Most cycles ago that an acknowledgement may tell of: what is not known by then never will be.
    acknowledgement_buffer: u32,
    /// The cycle observed last.
    observed: Option<Tick>,
    /// Cycles until the next look at the distance.
    until_look: u32,
    /// Cycles until the estimate has forgotten what was before the last change.
    unsettled: u32,
    counts: Counts,
}

impl<'a, 'w, T: Scalar, const NX: usize, const NU: usize, const N: usize, const LEN: usize>
    Tuner<'a, 'w, T, NX, NU, N, LEN>
{
    /// A tuner for a controller of `design`, whose law is for `basis`. `memory` needs [`super::workspace_len`] numbers.
    ///
    /// # Errors
    /// If the design has tables that would not follow the link, or something does not fit.
    pub fn new<const NY: usize>(
        design: &Design<'_, T, NX, NU, NY>,
        basis: Basis<'a, T>,
        parameters: Parameters,
        memory: &'w mut [T],
    ) -> Result<Self, InvalidTuner> {
        if design.preview.is_some() {
            return Err(InvalidTuner::Preview);
        }
        if design.trigger.is_some() {
            return Err(InvalidTuner::Trigger);
        }
        let (length, default_input) = (design.gains.length(), design.gains.default_input());
        if basis.survival.len() != length || basis.default_input != default_input {
            return Err(InvalidTuner::Basis);
        }
        if parameters.memory == 0 {
            return Err(InvalidTuner::Parameters);
        }
        let solver =
            Solver::new(design.model, basis, parameters.most_steps, memory).map_err(InvalidTuner::Problem)?;
        let mut in_force = [T::zero(); N];
        in_force[..length].copy_from_slice(basis.survival);
        let number = |value: u32| T::nearest(f64::from(value));
        Ok(Self {
            delays: DelayEstimate::new(
                basis.survival,
                number(parameters.prior_packets),
                number(parameters.memory),
            ),
            bank: Bank::new(length, default_input).ok_or(InvalidTuner::Bank)?,
            solver,
            in_force,
            // Even an instant one tells of the cycle before.
            acknowledgement_buffer: u32::try_from(design.acknowledgement_buffer.max(1)).unwrap_or(u32::MAX),
            observed: None,
            until_look: 0,
            unsettled: 0,
            counts: Counts::default(),
            parameters,
        })
    }

    /// Takes what has become known of the link, between the last frame of a cycle and the controller's cycle.
    ///
    /// A cycle is looked at when acknowledgements can tell no more of it, so each counts once, in order, and it makes no
    /// difference which of them came when.
    pub fn observe<const NY: usize, const H: usize, const E: usize>(
        &mut self,
        controller: &Controller<'_, T, NX, NU, NY, N, H, E>,
    ) {
        let now = controller.tick();
        if self.observed.replace(now) == Some(now) {
            return;
        }
        let cycle = now - self.acknowledgement_buffer;
        let sent = |ago: usize| u32::try_from(ago).is_ok_and(|ago| controller.has_sent(cycle - ago));
        self.delays.told(controller.acknowledged_age(cycle), sent);
        self.until_look = self.until_look.saturating_sub(1);
        self.unsettled = self.unsettled.saturating_sub(1);
    }

    /// Whether gains are being computed: the next [`Tuner::slice`] has something to do.
    pub fn is_solving(&self) -> bool {
        !self.solver.is_idle()
    }

    /// Does one slice of what there is to do: after the frame, at least once a cycle, and while [`Tuner::is_solving`] as
    /// often as there is time. Most of the time it does nothing.
    pub fn slice(&mut self) -> Option<Event<T>> {
        if self.solver.is_idle() {
            return self.look();
        }
        count(&mut self.counts.slices);
        let outcome = match self.solver.slice() {
            Progress::Idle | Progress::Working => return None,
            Progress::Solved(solved) => self.switch().map(|()| solved).map_err(Kept::Law),
            Progress::Unsolved(why) => Err(Kept::Unsolved(why)),
        };
        Some(match outcome {
            Ok(solved) => {
                count(&mut self.counts.switched);
                Event::Switched(solved)
            }
            Err(why) => {
                count(&mut self.counts.kept);
                // Nothing better is to be expected before there is something new to go by.
                self.until_look = self.parameters.memory;
                Event::Kept(why)
            }
        })
    }

    /// Begins to solve if the link has changed by more than chance explains.
    fn look(&mut self) -> Option<Event<T>> {
        if self.until_look > 0 {
            return None;
        }
        self.until_look = (self.parameters.memory / LOOKS).max(1);
        let length = self.solver.survival().len();
        let threshold = threshold(length, T::nearest(f64::from(self.parameters.caution)));
        let is_another = self.delays.renew(threshold);
        let distance = self.delays.distance(&self.in_force[..length]);
        let has_changed = distance > threshold;
        if is_another || has_changed {
            self.unsettled = self.parameters.memory.saturating_mul(SETTLED);
        }
        // While the estimate still forgets what was before, the law follows it closely.
        if !has_changed && (self.unsettled == 0 || distance <= T::nearest(length as f64)) {
            return None;
        }
        let mut survival = [T::zero(); N];
        self.delays.fill_survival(&mut survival[..length]);
        self.solver.begin(&survival[..length]);
        count(&mut self.counts.started);
        Some(Event::Started { distance })
    }

    fn switch(&mut self) -> Result<(), InvalidLaw> {
        self.solver.write_law(self.bank.spare());
        let survival = self.solver.survival();
        self.bank.switch(T::one() - survival.first().copied().unwrap_or_else(T::one))?;
        self.in_force[..survival.len()].copy_from_slice(survival);
        Ok(())
    }

    /// The law in force; `None` while that of the design is.
    pub fn law(&self) -> Option<Law<'_, T, NX, NU>> {
        self.bank.law()
    }

    /// What is known of the link.
    pub fn delays(&self) -> &DelayEstimate<T, N> {
        &self.delays
    }

    /// `P(delay > d)`, `d = 0..N-1`, of the link that the law in force is for.
    pub fn survival_in_force(&self) -> &[T] {
        &self.in_force[..self.solver.survival().len()]
    }

    /// What was counted since the start.
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
