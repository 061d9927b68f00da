//! Which estimator a design gets, and which do not go with it.

use super::document::Section;
use super::{Acknowledgement, Design, DesignError};
use slqg::estimator::Merging;

impl Design {
    /// What the estimator keeps apart while no acknowledgement decides: what the design says, and otherwise what suits its
    /// acknowledgements best.
    pub fn estimator(&self) -> Merging {
        match self.controller.estimator {
            // As the command line may have changed the acknowledgements since.
            Some(Merging::Linear) if self.against_linear().is_some() => Merging::Single,
            Some(given) => given,
            // The least cost, no heavy tail, and the cheapest: docs/evaluation.md.
            None if self.against_linear().is_none() => Merging::Linear,
            // The cheapest of those that go with late acknowledgements.
            None => Merging::Single,
        }
    }

    /// What of the design does not go with the linear estimator and its law, if anything.
    fn against_linear(&self) -> Option<&'static str> {
        if self.network.acknowledgement != Acknowledgement::None {
            return Some(
                "acknowledgements, of which it takes no notice: give network.acknowledgement = \"none\"",
            );
        }
        if self.tracking.is_some() {
            return Some("[tracking]: its feedforward is for a law that knows the age; choose \"single\"");
        }
        if self.event.is_some() {
            return Some("[event]: the trigger weighs ages; choose \"single\"");
        }
        if self.plant.states() > slqg::estimator::MOST_STATES {
            return Some("a plant of more than 32 states: no device runs its filter; choose \"single\"");
        }
        let rates = "controller.input_rates: it knows the mean of an input only; choose \"single\"";
        self.controller.input_rates.is_some().then_some(rates)
    }

    /// Rejects a linear estimator that does not go with the rest.
    pub(super) fn check_estimator(&self, root: &Section<'_>) -> Result<(), DesignError> {
        match self.against_linear() {
            Some(against) if self.controller.estimator == Some(Merging::Linear) => Err(root.reject(
                "controller.estimator",
                format!("found \"linear\" beside {}", against.split(": ").next().unwrap_or(against)),
                against.split(": ").last().unwrap_or(against).into(),
            )),
            _ => Ok(()),
        }
    }
}
