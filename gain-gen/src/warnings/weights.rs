//! Weights that have no say beside others, and oscillations that no weight sees.

use super::{
    Warning, eigenvalues,
    spread::{FAR, Units},
};
use crate::design::{Design, modes};
use crate::figure::figure;
use nalgebra::{Cholesky, Complex, DMatrix};
use std::f64::consts::PI;

const STATES: &str = "cost.q";
const INPUTS: &str = "cost.r";
/// Times the inputs' weight that an input costs by its effect, from where on its weight has no say.
const FREE: f64 = 1e4;
/// Part of the inputs' weight below which the effect of an input is worth nothing.
const WORTHLESS: f64 = 1e-9;
/// Times a state's weight that the state costs in all, from where on its weight has no say.
const DROWNED: f64 = 1e9;
/// Damping below which an oscillation should be seen, if it goes on for `LONG` cycles.
const LIGHT: f64 = 0.1;
const LONG: f64 = 20.0;

pub(super) fn of_design(design: &Design) -> Vec<Warning> {
    let units = Units::of(&design.plant);
    let spread = |key, apart: Option<(f64, f64)>, what: &str| {
        let (most, least) = apart?;
        let found = format!("found weights from {} to {}: {what}", figure(least), figure(most));
        Some(Warning::new(
            design,
            key,
            found,
            "give what matters a weight of like cost, and what does not a weight of 0".into(),
        ))
    };
    let inputs =
        spread(INPUTS, units.inputs_apart(&design.cost.r), "the dearest input is as good as not there").map(
            |warning| Warning {
                advice: "leave out the input that is not to be used, or check the units".into(),
                ..warning
            },
        );
    let states =
        spread(STATES, units.states_apart(&design.cost.q), "beside the largest the smallest has no say");
    states.into_iter().chain(inputs).chain(unseen(design)).collect()
}

/// States against inputs. As written they must be far apart, and in the loop one of them must have no say, in any units.
pub(super) fn of_loop(design: &Design, cost_to_go: &DMatrix<f64>) -> Option<Warning> {
    let (q, r) = (design.cost.q.diagonal(), design.cost.r.diagonal());
    let b = &design.plant.b;
    // What an input costs by what it does to the state, over its own weight.
    let effect = (b.tr_mul(cost_to_go) * b).diagonal().component_div(&r);
    let (largest, cheapest) = (q.max(), r.min());
    if largest / cheapest >= FAR && effect.max() >= FREE {
        let found = format!(
            "found weights down to {}, beside weights of states up to {}: they have no say, and inputs are as large as the \
             sample time makes them",
            figure(cheapest),
            figure(largest)
        );
        return Some(Warning::new(design, INPUTS, found, "weigh the inputs by what they may be".into()));
    }
    let costs = cost_to_go.diagonal();
    let weighed = q.iter().zip(costs.iter()).filter(|(weight, _)| **weight > 0.0);
    let largest_share = weighed.map(|(weight, cost)| cost / weight).fold(0.0, f64::max);
    let has_no_say = effect.max() <= WORTHLESS || largest_share >= DROWNED;
    (r.max() / largest >= FAR && has_no_say).then(|| {
        let found = format!(
            "found weights up to {}, beside weights of states up to {}: the loop does no more than keep itself from diverging",
            figure(r.max()),
            figure(largest)
        );
        Warning::new(design, INPUTS, found, "weigh the inputs by what they may be".into())
    })
}

/// A lightly damped oscillation that the cost ignores. One that does not decay is refused when the design is read.
fn unseen(design: &Design) -> Option<Warning> {
    let (plant, q) = (&design.plant, &design.cost.q);
    if Cholesky::new(q.clone()).is_some() {
        return None;
    }
    let rings = |value: &Complex<f64>| {
        let exponent = value.ln();
        let is_light = exponent.im > 0.0 && -exponent.re < LIGHT * exponent.norm();
        is_light && value.norm() < 1.0 && -exponent.re * LONG < 1.0
    };
    let ringing: Vec<_> = eigenvalues(&plant.a)?.into_iter().filter(rings).collect();
    let ignored = modes::unreached(&plant.a.transpose(), q, &ringing)?;
    let frequency = ignored.arg().abs() / (2.0 * PI * plant.sample_time);
    let found = format!(
        "found a weight that ignores an oscillation at {} Hz (eigenvalue {}): nothing damps it",
        figure(frequency),
        modes::spoken(ignored)
    );
    Some(Warning::new(
        design,
        STATES,
        found,
        "give the states that show it a weight, or leave it out of the model".into(),
    ))
}
