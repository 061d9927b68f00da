//! The filter's memory: what becomes known late is put where it belongs, and everything after it is filtered again.
//!
//! Thesis 3.4.1 after Schenato (2008), and for ages that are not acknowledged an interacting-multiple-model filter
//! (thesis 3.6.2, THEORY 8). The estimate is the one that would have come out had all that is known been known at
//! once: the order of arrival within the memory does not matter, to the bit. What happens in one cycle is in `step`.

mod filtered;

use super::plausibility::MOST_OUTPUTS;
use super::prepared::Prepared;
use super::step::Step;
use super::{Cycle, MOST_STATES, Model, Remembered, Standing, Surroundings};
use crate::{Scalar, Tick, integrity::Part, played::Age};
use nalgebra::SVector;

/// Why a measurement did not enter the filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RejectedMeasurement {
    /// Older than the filter remembers.
    TooOld,
    /// From a cycle that has not begun: the two ends' ticks disagree.
    Future,
    /// There is already one for that cycle.
    Duplicate,
    /// It holds no number that is finite.
    NotFinite,
}

impl core::fmt::Display for RejectedMeasurement {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::TooOld => "a measurement older than the measurement buffer",
            Self::Future => {
                "a measurement of a cycle that has not begun: the clocks of the two ends disagree"
            }
            Self::Duplicate => "another measurement of a cycle that has one",
            Self::NotFinite => "a measurement without a number that is finite",
        })
    }
}

impl core::error::Error for RejectedMeasurement {}

/// State and ages given everything that has arrived.
///
/// How many cycles it remembers is told by the memory that it is lent; how late a measurement may be is data. What was applied
/// in a cycle is known only after it, so the filter runs as lazily as it can: where every age is acknowledged in time, a cycle
/// costs one prediction and one update.
///
/// ```
/// use slqg::actuator::Settings;
/// use slqg::estimator::{Cycle, Estimate, Merging, ModeFilter, Model, Plausibility, Remembered, Surroundings};
/// use slqg::in_flight::InFlight;
/// use slqg::nalgebra::{Matrix2, RowVector2, Vector1, Vector2};
/// use slqg::{DefaultInput, Tick};
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
/// // It remembers three cycles, and a measurement may be two late. `LAW` is as in the example of `Gains`.
/// let (mut cycles, mut ages, mut estimates) = ([Cycle::EMPTY; 4], [0.0; 4 * 3], [Estimate::EMPTY; 4]);
/// let remembered = Remembered::new(&mut cycles, &mut ages, &mut estimates, 2, 1).expect("memory enough");
/// let mut filter = ModeFilter::new(&model, 2, Tick(0), remembered);
///
/// let (mut sent, mut inputs) = ([false; 6], [Vector1::zeros(); 12]);
/// let mut in_flight = InFlight::new(2, Tick(0), &mut sent, &mut inputs);
/// let actuator = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
/// for _ in 0..2 {
///     in_flight.push(false);
///     let around = Surroundings {
///         model: &model,
///         in_flight: &in_flight,
///         actuator: &actuator,
///         gains: &LAW,
///         arrives_at_once: 0.5,
///         merging: Merging::Single,
///         plausibility: &Plausibility::NONE,
///     };
///     filter.advance(&around);
///     // That of cycle 0 is late: it counts once the filter runs again.
///     if filter.tick() == Tick(1) {
///         filter.measure(Tick(0), Vector1::new(3.0)).expect("not too old");
///     }
///     filter.filter(&around);
/// }
/// assert!((filter.posterior_mean()[0] - 3.0).abs() < 0.01);
/// ```
#[derive(Debug)]
pub struct ModeFilter<'m, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    prepared: Prepared<T, NX, NY>,
    /// The current cycle, the last one in memory.
    tick: Tick,
    /// Most cycles a measurement may be late, `N^B`.
    measurement_buffer: usize,
    /// A ring: the cycles in memory, oldest first and the current one last, and before them one that is not in memory any more.
    remembered: Remembered<'m, T, NX, NU, NY>,
    /// Place of the oldest in memory.
    oldest: usize,
    /// Cycles in memory, at least one, at most one less than there are places.
    count: usize,
    /// Whether there was a cycle before the oldest in memory.
    has_before: bool,
    /// Position of the first cycle that must be filtered, if any.
    changed: Option<usize>,
    /// Place of the cycle that was filtered last, if one estimate stands for all ages there; else they are merged.
    posterior: Option<usize>,
    /// Whether an estimate of the current cycle began anew.
    begins_anew: bool,
    begun_anew: u32,
}

impl<'m, T: Scalar, const NX: usize, const NU: usize, const NY: usize> ModeFilter<'m, T, NX, NU, NY> {
    /// A filter whose first cycle is `tick` and which takes measurements up to `measurement_buffer` cycles
    /// late (`N^B`, thesis 3.34), at most as many as it remembers.
    ///
    /// Does not compile for more than [`MOST_STATES`] states or 32 outputs.
    pub fn new(
        model: &Model<T, NX, NU, NY>,
        measurement_buffer: usize,
        tick: Tick,
        mut remembered: Remembered<'m, T, NX, NU, NY>,
    ) -> Self {
        const { assert!(NX <= MOST_STATES, "a controller runs with at most 32 states") };
        const { assert!(NY <= MOST_OUTPUTS, "a controller runs with at most 32 outputs") };
        remembered.begin(model);
        Self {
            prepared: Prepared::new(model, measurement_buffer),
            tick,
            measurement_buffer: measurement_buffer.min(remembered.cycles.len() - 2),
            remembered,
            oldest: 0,
            count: 1,
            has_before: false,
            changed: Some(0),
            // What is known before the first cycle is filtered stands where its estimate will.
            posterior: Some(0),
            begins_anew: false,
            begun_anew: 0,
        }
    }

    /// Begins anew with cycle `tick`, as a filter that has just been made.
    pub(crate) fn restart(&mut self, model: &Model<T, NX, NU, NY>, measurement_buffer: usize, tick: Tick) {
        self.prepared = Prepared::new(model, measurement_buffer);
        self.remembered.begin(model);
        self.tick = tick;
        self.measurement_buffer = measurement_buffer.min(self.remembered.cycles.len() - 2);
        (self.oldest, self.count, self.has_before, self.changed) = (0, 1, false, Some(0));
        self.posterior = Some(0);
        (self.begins_anew, self.begun_anew) = (false, 0);
    }

    /// What a checksum is taken of: what was computed of the model. It does not change before [`ModeFilter::restart`].
    pub(crate) fn part(&self, place: usize) -> Part<'_, T> {
        self.prepared.part(place)
    }

    /// Whether the ring's positions are within the ring.
    pub(crate) fn is_in_range(&self) -> bool {
        let places = self.remembered.cycles.len();
        self.oldest < places && (1..places).contains(&self.count)
    }

    /// With one of the numbers changed that were computed of the model, see [`Prepared::damage`].
    #[cfg(test)]
    pub(crate) fn damage(&mut self, place: usize, change: impl FnOnce(&mut T)) -> bool {
        self.prepared.damage(place, change)
    }

    /// Likewise where its memory is, and how it is divided.
    pub(crate) fn word(&self) -> u32 {
        self.remembered.word() ^ self.measurement_buffer as u32
    }

    /// The current cycle.
    pub fn tick(&self) -> Tick {
        self.tick
    }

    /// Place in the ring of the cycle at `position` in memory.
    fn place(&self, position: usize) -> usize {
        let place = self.oldest + position;
        let places = self.remembered.cycles.len();
        if place < places { place } else { place - places }
    }

    /// Place of the cycle before that at `position`; `None` if that is the first of all.
    fn place_before(&self, position: usize) -> Option<usize> {
        match position.checked_sub(1) {
            Some(before) => Some(self.place(before)),
            None => self.has_before.then(|| self.place(self.remembered.cycles.len() - 1)),
        }
    }

    /// Position of `tick` in memory.
    fn position(&self, tick: Tick) -> Option<usize> {
        let age = usize::try_from(self.tick.age_of(tick)?).ok()?;
        (self.count - 1).checked_sub(age)
    }

    /// Position of cycle `tick`, if that is over and remembered; a cycle earlier is one less.
    pub(crate) fn position_over(&self, tick: Tick) -> Option<usize> {
        self.position(tick).filter(|position| position + 1 < self.count)
    }

    fn cycle(&self, position: usize) -> Option<&Cycle<T, NU, NY>> {
        self.remembered.cycles.get(self.place(position))
    }

    /// The age that the cycle at `position` was acknowledged with.
    #[inline]
    pub(crate) fn known_at(&self, position: usize) -> Option<Age> {
        self.cycle(position)?.known
    }

    fn must_filter_from(&mut self, position: usize) {
        self.changed = Some(self.changed.map_or(position, |earlier| earlier.min(position)));
    }

    /// Takes the measurement of cycle `tick`, late or not. [`ModeFilter::filter`] makes it count. An output that is no finite
    /// number is not measured; nor is one whose noise goes with that of such a one.
    ///
    /// # Errors
    /// Says why the filter did not take it.
    pub fn measure(&mut self, tick: Tick, output: SVector<T, NY>) -> Result<(), RejectedMeasurement> {
        if !output.iter().any(|value| value.is_finite()) {
            return Err(RejectedMeasurement::NotFinite);
        }
        let age = self.tick.age_of(tick).ok_or(RejectedMeasurement::Future)?;
        let position = self.position(tick).ok_or(RejectedMeasurement::TooOld)?;
        if usize::try_from(age).map_or(true, |age| age > self.measurement_buffer) {
            return Err(RejectedMeasurement::TooOld);
        }
        let place = self.place(position);
        let cycle = self.remembered.cycles.get_mut(place).ok_or(RejectedMeasurement::TooOld)?;
        if cycle.measured.is_some() {
            return Err(RejectedMeasurement::Duplicate);
        }
        cycle.measured = Some(output);
        self.must_filter_from(position);
        Ok(())
    }

    /// Whether the age played in cycle `tick` was acknowledged; `None` if that cycle is not over or not remembered.
    pub fn is_acknowledged(&self, tick: Tick) -> Option<bool> {
        self.cycle(self.position_over(tick)?).map(|cycle| cycle.known.is_some())
    }

    /// The age that cycle `tick` was acknowledged with; `None` if it was not, is not over or is not remembered.
    pub fn acknowledged_age(&self, tick: Tick) -> Option<Age> {
        self.cycle(self.position(tick)?)?.known
    }

    /// Takes the age that was played in cycle `tick`, which is over. [`ModeFilter::filter`] makes it count.
    ///
    /// Returns whether the filter still remembers that cycle. Whether such a sequence was ever sent is for the caller to
    /// know.
    pub fn acknowledge(&mut self, tick: Tick, age: Age) -> bool {
        let Some(position) = self.position_over(tick) else { return false };
        let place = self.place(position);
        let Some(cycle) = self.remembered.cycles.get_mut(place) else { return false };
        if cycle.known.replace(age) != Some(age) {
            // What was played acts on the next cycle.
            self.must_filter_from(position + 1);
        }
        true
    }

    /// Filters up to the current cycle, again from the first cycle for which something new is known.
    ///
    /// `around.in_flight` must hold what was sent in every cycle before the current one.
    pub fn filter(&mut self, around: &Surroundings<'_, T, NX, NU, NY>) {
        let Some(first) = self.changed.take() else { return };
        for position in first..self.count {
            self.filter_cycle(position, around);
        }
        let last = self.place(self.count - 1);
        if self.remembered.belief(last).is_some_and(|belief| belief.single().is_some()) {
            self.posterior = Some(last);
        } else {
            self.merge(last);
        }
    }

    /// Merges the estimates of the cycle at `place` into the posterior.
    // Apart from the filter, which runs without its stack.
    #[inline(never)]
    fn merge(&mut self, place: usize) {
        let merged = self.remembered.belief(place).and_then(|belief| belief.merged());
        if let (Some(merged), Some(posterior)) = (merged, self.remembered.merged()) {
            *posterior = merged;
            self.posterior = None;
        }
    }

    fn filter_cycle(&mut self, position: usize, around: &Surroundings<'_, T, NX, NU, NY>) {
        let (place, before) = (self.place(position), self.place_before(position));
        let output = self.remembered.cycles.get(place).and_then(|cycle| cycle.measured);
        let known = before.and_then(|before| self.remembered.cycles.get(before));
        let (known, standing) = known.map_or((None, Standing::START), |cycle| (cycle.known, cycle.standing));
        let mut step = Step::new(around, &self.prepared, standing);
        match before.and_then(|before| self.remembered.belief_and_room(before, place)) {
            Some((Some(belief), mut room)) => {
                let tick = self.tick - (self.count - position) as u32;
                step.step(&belief, tick, known, output.as_ref(), &mut room);
            }
            _ => {
                let Some(mut room) = self.remembered.room(place) else { return };
                step.first(output.as_ref(), &mut room);
            }
        }
        self.begins_anew = step.begins_anew;
        let standing = step.standing_after();
        if let Some(cycle) = self.remembered.cycles.get_mut(place) {
            cycle.standing = standing;
        }
    }

    /// Tells the mean of what was applied in the cycle before the current one, where no acknowledgement ever comes.
    pub fn tell_mean(&mut self, input: &SVector<T, NU>) {
        let place = self.place(self.count - 1);
        if let Some(cycle) = self.remembered.cycles.get_mut(place) {
            cycle.held = *input;
        }
    }

    /// Moves on to the next cycle.
    pub fn advance(&mut self, around: &Surroundings<'_, T, NX, NU, NY>) {
        self.filter(around);
        if core::mem::take(&mut self.begins_anew) {
            self.begun_anew = self.begun_anew.saturating_add(1);
        }
        if self.count + 1 == self.remembered.cycles.len() {
            self.oldest = self.place(1);
            self.has_before = true;
        } else {
            self.count += 1;
        }
        let place = self.place(self.count - 1);
        if let Some(cycle) = self.remembered.cycles.get_mut(place) {
            *cycle = Cycle::EMPTY;
        }
        self.tick += 1;
        self.must_filter_from(self.count - 1);
    }
}
