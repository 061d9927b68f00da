//! How much worse link and plant may be than the design says before the loop is unstable in mean square.
//!
//! The controller stays as designed: its gains, its table of arrival probabilities and its filter. Each margin changes one
//! thing. A margin is the distance to the *nearest* change that destabilises. The search walks outwards in steps and then
//! narrows the step in which the rate passes 1; an unstable interval narrower than a step could be walked over.
//!
//! | file | what lives there |
//! |---|---|
//! | `state_known` | margins of the loop whose state is known |
//! | `flashed` | margins of the loop with its estimator |
//! | `loop_rate` | the mean-square rate around another plant |
//! | `certain` | that rate where all packets of a link meet one delay |
//! | `filter` | the estimator within that loop |
//! | `arrivals` | which of the last measurements have arrived |
//! | `change` | what may be another plant |
//! | `logarithm` | the continuous plant behind a discrete one |
//! | `units` | coordinates in which the units of the design do not matter |
//! | `search` | where the rate passes 1 |

mod arrivals;
mod certain;
mod change;
mod filter;
mod flashed;
mod logarithm;
mod loop_rate;
mod search;
mod state_known;

use crate::design::{DelayDistribution, Design};
use crate::solve::Solution;

pub use change::{Change, Matrix};
pub use flashed::{
    Bounds, Flashed, LARGEST_FACTOR, LARGEST_SAMPLE_TIME, LinkMargins, NotGiven, PlantMargin, flashed,
    plant_margin,
};
pub use state_known::{LARGEST_INPUT_GAIN, StateKnown, state_known};

/// Distances to instability, one change at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Margins {
    /// With the state known.
    pub state_known: StateKnown,
    /// With the estimator as flashed, or why that is not told.
    pub flashed: Result<Flashed, NotGiven>,
}

/// The margins of a design with the gains of `solution`; `None` if its loop is not mean-square stable as it is.
pub fn margins(design: &Design, solution: &Solution) -> Option<Margins> {
    let state_known = state_known(design, solution)?;
    let flashed = flashed(design, solution, &state_known);
    Some(Margins { state_known, flashed })
}

/// The link on which every packet comes `steps` later than on `link`.
pub fn delayed(link: &DelayDistribution, steps: usize) -> DelayDistribution {
    let mut probabilities = vec![0.0; steps];
    probabilities.extend_from_slice(link.probabilities());
    DelayDistribution::new(probabilities).expect("a distribution that starts later is a distribution")
}

/// The link on which, of the packets that arrive on `link`, a `fraction` below 1 is lost in addition.
///
/// # Panics
/// If the fraction is not within 0 and 1, or nothing is left.
pub fn thinned(link: &DelayDistribution, fraction: f64) -> DelayDistribution {
    let probabilities =
        link.probabilities().iter().map(|probability| probability * (1.0 - fraction)).collect();
    DelayDistribution::new(probabilities).expect("something still arrives")
}
