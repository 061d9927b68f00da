//! The filter's memory: what becomes known late is put where it belongs, and everything after it is filtered again.
//!
//! Thesis 3.4.1 after Schenato (2008), and for ages that are not acknowledged an interacting-multiple-model filter
//! (thesis 3.6.2, THEORY 8). The estimate is the one that would have come out had all that is known been known at
//! once: the order of arrival within the memory does not matter, to the bit. What happens in one cycle is in `step`.

use super::step::Belief;
use super::{Estimate, MOST_STATES, Model, Modes, Surroundings};
use crate::{Scalar, Tick, actuator::Age};
use heapless::Deque;
use nalgebra::{SMatrix, SVector};

/// Why a measurement did not enter the filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectedMeasurement {
    /// Older than the filter remembers.
    TooOld,
    /// From a cycle that has not begun: the two ends' ticks disagree.
    Future,
    /// There is already one for that cycle.
    Duplicate,
    /// It holds a number that is not finite.
    NotFinite,
}

/// One remembered cycle.
#[derive(Debug, Clone)]
struct Cycle<T: Scalar, const NX: usize, const NU: usize, const NY: usize, const N: usize, const E: usize> {
    measured: Option<SVector<T, NY>>,
    /// The age played in this cycle, if it was acknowledged.
    known: Option<Age>,
    /// Given all measurements up to this cycle's; `None` before it is filtered for the first time.
    belief: Option<Belief<T, NX, NU, N, E>>,
}

/// State and ages given everything that has arrived.
///
/// `H` is the capacity of the memory in cycles, the current one included; how late a measurement may be is data. `E` is
/// the number of estimates that are kept apart at once, [`super::Merging::estimates`] of them. What was applied in a
/// cycle is known only after it, so the filter runs as lazily as it can: where every age is acknowledged in time, a cycle
/// costs one prediction and one update.
#[derive(Debug, Clone)]
pub struct ModeFilter<
    T: Scalar,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
    const E: usize = 1,
> {
    /// The current cycle, the last one in memory.
    tick: Tick,
    /// Most cycles a measurement may be late, `N^B`.
    measurement_buffer: usize,
    /// Cycles remembered beside the current one, at most `H - 1`.
    remembered: usize,
    /// The cycle before the oldest in memory; `None` if that is the first of all.
    before: Option<Cycle<T, NX, NU, NY, N, E>>,
    /// Oldest first, the current cycle last. Never empty.
    memory: Deque<Cycle<T, NX, NU, NY, N, E>, H>,
    /// Position of the first cycle that must be filtered, if any.
    changed: Option<usize>,
    posterior: Estimate<T, NX>,
}

impl<
    T: Scalar,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
    const E: usize,
> ModeFilter<T, NX, NU, NY, N, H, E>
{
    /// A filter whose first cycle is `tick` and which takes measurements up to `measurement_buffer` cycles
    /// late (`N^B`, thesis 3.34), at most `H - 1`.
    ///
    /// Does not compile for `H < 2`: the last cycle's input becomes known in the current one; nor for `E = 0`, nor for more
    /// than [`MOST_STATES`] states.
    pub fn new(model: &Model<T, NX, NU, NY>, measurement_buffer: usize, tick: Tick) -> Self {
        const { assert!(H >= 2, "the filter must remember the current cycle and the one before") };
        const { assert!(E >= 1, "the filter must keep an estimate") };
        const { assert!(NX <= MOST_STATES, "a controller runs with at most 32 states") };
        let mut memory = Deque::new();
        // There is room: H >= 2.
        let _ = memory.push_back(Cycle { measured: None, known: None, belief: None });
        Self {
            tick,
            measurement_buffer: measurement_buffer.min(H - 1),
            remembered: measurement_buffer.clamp(1, H - 1),
            before: None,
            memory,
            changed: Some(0),
            posterior: Estimate::initial(model),
        }
    }

    /// The same filter, which remembers `cycles` cycles beside the current one at least, at most `H - 1`: so many ago may be
    /// what an acknowledgement tells of.
    #[must_use]
    pub fn remembering(self, cycles: usize) -> Self {
        Self { remembered: self.remembered.max(cycles.min(H - 1)), ..self }
    }

    /// The current cycle.
    pub fn tick(&self) -> Tick {
        self.tick
    }

    /// Position of `tick` in memory.
    fn position(&self, tick: Tick) -> Option<usize> {
        let age = usize::try_from(self.tick.age_of(tick)?).ok()?;
        (self.memory.len() - 1).checked_sub(age)
    }

    fn must_filter_from(&mut self, position: usize) {
        self.changed = Some(self.changed.map_or(position, |earlier| earlier.min(position)));
    }

    /// Takes the measurement of cycle `tick`, late or not. [`ModeFilter::filter`] makes it count.
    ///
    /// # Errors
    /// Says why the filter did not take it.
    pub fn measure(&mut self, tick: Tick, output: SVector<T, NY>) -> Result<(), RejectedMeasurement> {
        if !output.iter().all(|value| value.is_finite()) {
            return Err(RejectedMeasurement::NotFinite);
        }
        let age = self.tick.age_of(tick).ok_or(RejectedMeasurement::Future)?;
        let position = self.position(tick).ok_or(RejectedMeasurement::TooOld)?;
        if usize::try_from(age).map_or(true, |age| age > self.measurement_buffer) {
            return Err(RejectedMeasurement::TooOld);
        }
        let cycle = self.memory.get_mut(position).ok_or(RejectedMeasurement::TooOld)?;
        if cycle.measured.is_some() {
            return Err(RejectedMeasurement::Duplicate);
        }
        cycle.measured = Some(output);
        self.must_filter_from(position);
        Ok(())
    }

    /// Whether the age played in cycle `tick` was acknowledged; `None` if that cycle is not over or not remembered.
    pub fn is_acknowledged(&self, tick: Tick) -> Option<bool> {
        let position = self.position(tick).filter(|position| position + 1 < self.memory.len())?;
        self.memory.get(position).map(|cycle| cycle.known.is_some())
    }

    /// The age that cycle `tick` was acknowledged with; `None` if it was not, is not over or is not remembered.
    pub fn acknowledged_age(&self, tick: Tick) -> Option<Age> {
        self.memory.iter().nth(self.position(tick)?)?.known
    }

    /// Takes the age that was played in cycle `tick`, which is over. [`ModeFilter::filter`] makes it count.
    ///
    /// Returns whether the filter still remembers that cycle. Whether such a sequence was ever sent is for the caller to
    /// know.
    pub fn acknowledge(&mut self, tick: Tick, age: Age) -> bool {
        let Some(position) = self.position(tick).filter(|position| position + 1 < self.memory.len()) else {
            return false;
        };
        let Some(cycle) = self.memory.get_mut(position) else { return false };
        if cycle.known.replace(age) != Some(age) {
            // What was played acts on the next cycle.
            self.must_filter_from(position + 1);
        }
        true
    }

    /// Filters up to the current cycle, again from the first cycle for which something new is known.
    ///
    /// `around.in_flight` must hold what was sent in every cycle before the current one.
    pub fn filter(&mut self, around: &Surroundings<'_, T, NX, NU, NY, N, H>) {
        let Some(first) = self.changed.take() else { return };
        let count = self.memory.len();
        for position in first..count {
            let earlier = match position.checked_sub(1) {
                None => self.before.as_ref(),
                Some(place) => self.memory.get(place),
            };
            let output = self.memory.get(position).and_then(|cycle| cycle.measured.as_ref());
            let known = earlier.and_then(|cycle| cycle.known);
            let belief = match earlier.and_then(|cycle| cycle.belief.as_ref()) {
                Some(before) => around.step(before, self.tick - (count - position) as u32, known, output),
                // The first cycle of all: nothing was played before it.
                None => {
                    let modes = Modes::certain(Age::Empty, SVector::zeros());
                    Belief::of(modes, around.corrected(Estimate::initial(around.model), output))
                }
            };
            if let Some(cycle) = self.memory.get_mut(position) {
                cycle.belief = Some(belief);
            }
        }
        let last = self.memory.back().and_then(|cycle| cycle.belief.as_ref());
        match last.map(|belief| (belief.single(), belief)) {
            Some((Some(posterior), _)) => self.posterior = posterior.clone(),
            Some((None, belief)) => {
                if let Some(posterior) = belief.merged() {
                    self.posterior = posterior;
                }
            }
            None => {}
        }
    }

    /// Moves on to the next cycle.
    pub fn advance(&mut self, around: &Surroundings<'_, T, NX, NU, NY, N, H>) {
        self.filter(around);
        if self.memory.is_full() || self.memory.len() > self.remembered {
            self.before = self.memory.pop_front();
        }
        let _ = self.memory.push_back(Cycle { measured: None, known: None, belief: None });
        self.tick += 1;
        self.must_filter_from(self.memory.len() - 1);
    }

    /// Ages that may have been played in the cycle before the one that was filtered last.
    pub fn modes(&self) -> Option<&Modes<T, NU, N>> {
        let filtered = |cycle: &&Cycle<T, NX, NU, NY, N, E>| cycle.belief.is_some();
        self.memory.iter().rev().find(filtered)?.belief.as_ref().map(|belief| &belief.modes)
    }

    /// The expected input of cycle `tick` as far as is known; `None` if the cycle after it is not remembered or not filtered.
    pub fn expected_input(
        &self,
        around: &Surroundings<'_, T, NX, NU, NY, N, H>,
        tick: Tick,
    ) -> Option<SVector<T, NU>> {
        let belief = self.memory.get(self.position(tick + 1)?)?.belief.as_ref()?;
        Some(around.expected_input(tick, &belief.modes))
    }

    /// Estimate of the state in the last cycle that was filtered, given everything taken before that.
    pub fn posterior_mean(&self) -> &SVector<T, NX> {
        &self.posterior.mean
    }

    /// Covariance of the error of [`ModeFilter::posterior_mean`].
    pub fn posterior_covariance(&self) -> &SMatrix<T, NX, NX> {
        &self.posterior.covariance
    }
}
