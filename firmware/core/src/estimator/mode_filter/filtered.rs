//! What the filter has come to: estimate, ages, inputs, and how measurements have fitted.

use super::ModeFilter;
use crate::{
    Scalar, Tick,
    estimator::{Estimate, Standing, Surroundings},
    played::Modes,
};
use nalgebra::{SMatrix, SVector};

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> ModeFilter<'_, T, NX, NU, NY> {
    /// Ages that may have been played in the cycle before the one that was filtered last.
    pub fn modes(&self) -> Option<Modes<'_, T, NU>> {
        // Only the current cycle may not be filtered yet.
        let belief = |position: usize| self.remembered.belief(self.place(position));
        let current = belief(self.count - 1);
        current.or_else(|| belief(self.count.checked_sub(2)?)).map(|belief| belief.modes)
    }

    /// The expected input of cycle `tick` as far as is known; `None` if the cycle after it is not remembered or not filtered.
    pub fn expected_input(
        &self,
        around: &Surroundings<'_, T, NX, NU, NY>,
        tick: Tick,
    ) -> Option<SVector<T, NU>> {
        let belief = self.remembered.belief(self.place(self.position(tick + 1)?))?;
        Some(around.expected_input(tick, &belief.modes))
    }

    /// Estimate of the state in the last cycle that was filtered, given everything taken before that.
    pub fn posterior(&self) -> &Estimate<T, NX> {
        self.remembered.estimate(self.posterior)
    }

    /// Mean of [`ModeFilter::posterior`].
    pub fn posterior_mean(&self) -> &SVector<T, NX> {
        &self.posterior().mean
    }

    /// Covariance of the error of [`ModeFilter::posterior_mean`], `nx x nx`; computed from its factors on every call.
    /// What is kept are the factors: after long without measurements entries may be beyond the scalar's range where these are not.
    pub fn posterior_covariance(&self) -> SMatrix<T, NX, NX> {
        self.posterior().covariance()
    }

    /// Cycles so far in which an estimate had become of no use, after too long without measurements, and began anew with
    /// what a controller that joins the loop knows. Saturates.
    pub fn begun_anew(&self) -> u32 {
        self.begun_anew
    }

    /// How measurements have fitted the estimate, up to the cycle that was filtered last.
    pub fn standing(&self) -> &Standing<NY> {
        // Only the current cycle may not be filtered yet.
        let unfiltered = usize::from(self.changed.is_some() && self.count > 1);
        self.cycle(self.count - 1 - unfiltered).map_or(&Standing::START, |cycle| &cycle.standing)
    }
}
