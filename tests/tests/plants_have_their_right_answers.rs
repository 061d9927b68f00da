//! Every plant of the collection comes out right: gains, rate and cost as arithmetic of high precision has them, and where no
//! gains exist the design is refused.

use gain_gen::design::Design;
use rayon::prelude::*;
use slqg_tests::accuracy::{Plant, collection};

/// Of the largest gain.
const GAIN: f64 = 1e-8;
/// Of the mean-square rate.
const RATE: f64 = 1e-6;
/// Of the cost.
const COST: f64 = 1e-7;

/// Why the plant does not come out right.
fn fault(plant: &Plant) -> Option<String> {
    if plant.answer.refused {
        return Design::parse(&plant.design, &plant.name).is_ok().then(|| "not refused".into());
    }
    let errors = match plant.errors() {
        Ok(errors) => errors,
        Err(why) => return Some(why),
    };
    let tolerance = plant.answer.gain_tolerance.unwrap_or(0.0);
    let is_right =
        errors.gain <= GAIN.max(tolerance) && errors.rate <= RATE && errors.cost <= COST.max(tolerance);
    (!is_right).then(|| format!("{errors:?}"))
}

#[test]
fn plants_have_their_right_answers() {
    let faults: Vec<_> = collection()
        .par_iter()
        .filter_map(|plant| fault(plant).map(|fault| format!("{}: {fault}", plant.name)))
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
