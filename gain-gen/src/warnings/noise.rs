//! Noise that an estimator cannot do without, and measurements that differ beyond measure.

use super::{Warning, spread::Units};
use crate::design::{Design, modes};
use crate::figure::figure;

const PROCESS: &str = "plant.process_noise";
const MEASUREMENT: &str = "plant.measurement_noise";

pub(super) fn of(design: &Design) -> Vec<Warning> {
    process(design).into_iter().chain(measurement(design)).collect()
}

/// A mode that no noise reaches is known for ever once it is known: the filter's gain for it goes to zero, and what the
/// model does not know of stays in the estimate. Where the mode decays, so does that.
fn process(design: &Design) -> Option<Warning> {
    let plant = &design.plant;
    let advice = "give the states of this mode the variance by which the model may be wrong in a cycle";
    if plant.process_noise.amax() == 0.0 {
        let found = "found no noise at all: the estimator ends up believing the model alone, and stops listening to measurements";
        let advice = "give each state that is driven the variance by which the model may be wrong in a cycle";
        return Some(Warning::new(design, PROCESS, found.into(), advice.into()));
    }
    let persistent = modes::unstable_eigenvalues(&plant.a)?;
    let silent = modes::unreached(&plant.a, &plant.process_noise, &persistent)?;
    let found = format!(
        "found no noise on the mode {}, which does not decay: the estimator ends up believing the model alone there, and \
         stops listening to measurements",
        modes::spoken(silent)
    );
    Some(Warning::new(design, PROCESS, found, advice.into()))
}

fn measurement(design: &Design) -> Option<Warning> {
    let (most, least) = Units::of(&design.plant).outputs_apart(&design.plant.measurement_noise)?;
    let found = format!(
        "found variances from {} to {}: beside the most precise output the others are not listened to",
        figure(least),
        figure(most)
    );
    Some(Warning::new(
        design,
        MEASUREMENT,
        found,
        "check their units, or leave out the output that tells nothing".into(),
    ))
}
