//! Which estimator a design gets, and what does not go with the linear one.

use super::document::Section;
use super::{Acknowledgement, Design, DesignError};
use slqg::estimator::{MOST_STATES, Merging};

/// Why a design cannot have the linear estimator, and the law that goes with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("found \"linear\" beside {beside}; {advice}")]
pub struct NotLinear {
    /// What does not go with it.
    pub beside: &'static str,
    /// Why not, and what to do.
    pub advice: &'static str,
}

impl Design {
    /// What the estimator keeps apart while no acknowledgement decides: what the design says, and otherwise what suits its
    /// acknowledgements best.
    ///
    /// Where a linear one does not go with the rest ([`Design::check_linear`]) that is [`Merging::Single`].
    pub fn estimator(&self) -> Merging {
        match self.controller.estimator {
            Some(given) if given != Merging::Linear => given,
            // The least cost, no heavy tail, and the cheapest: docs/evaluation.md.
            _ if self.check_linear().is_ok() => Merging::Linear,
            // The cheapest of those that go with late acknowledgements.
            _ => Merging::Single,
        }
    }

    /// Nothing if the linear estimator goes with the design, otherwise what does not.
    ///
    /// # Errors
    /// Acknowledgements come, or as [`Design::check_uncertain`].
    pub fn check_linear(&self) -> Result<(), NotLinear> {
        if self.network.acknowledgement != Acknowledgement::None {
            let beside = "acknowledgements";
            let advice =
                "it takes no notice of them: give network.acknowledgement = \"none\", or choose \"single\"";
            return Err(NotLinear { beside, advice });
        }
        self.check_uncertain()
    }

    /// Nothing if the gains may know that inputs are uncertain, otherwise what needs those for known ages.
    ///
    /// # Errors
    /// A reference is followed, packets have a price, inputs have rates, or no device runs the filter.
    pub fn check_uncertain(&self) -> Result<(), NotLinear> {
        let not = |beside, advice| Err(NotLinear { beside, advice });
        if self.tracking.is_some() {
            return not("[tracking]", "its feedforward is for a law that knows the age: choose \"single\"");
        }
        if self.event.is_some() {
            return not("[event]", "its trigger weighs ages: choose \"single\"");
        }
        if self.controller.input_rates.is_some() {
            return not("controller.input_rates", "it knows the mean of an input only: choose \"single\"");
        }
        match self.plant.states() {
            ..=MOST_STATES => Ok(()),
            _ => not(
                "more than 32 states",
                "no device runs its filter: reduce the model, or choose \"single\"",
            ),
        }
    }

    /// Rejects a linear estimator that is asked for and does not go with the rest.
    pub(super) fn check_estimator(&self, root: &Section<'_>) -> Result<(), DesignError> {
        match self.check_linear() {
            Err(NotLinear { beside, advice }) if self.controller.estimator == Some(Merging::Linear) => {
                let found = format!("found \"linear\" beside {beside}");
                Err(root.reject("controller.estimator", found, advice.into()))
            }
            _ => Ok(()),
        }
    }
}
