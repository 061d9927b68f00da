//! Cost and age against the sequence length, where several were simulated.

use super::page::Page;
use crate::{
    monte_carlo::Summary,
    output::{
        Simulation,
        charts::{Curve, Start, against_length},
    },
};

pub(super) fn add(page: &mut Page, simulation: &Simulation<'_>) {
    page.section("Cost against sequence length");
    page.grid(|page| {
        let cost = |result: &Summary| Some((result.mean_cost?, 2.0 * result.std_error.unwrap_or(0.0)));
        let svg = against_length("mean cost (unit of the cost)", Start::AtLeast, &curves(simulation, cost));
        let caption = "Mean of the runs; bars are 2 standard errors of the mean to either side. A length without a mark was not simulated, as it does \
             not stabilise the loop, or has no finite mean. Dashed: the same for every length.";
        page.figure("cost-against-length", svg, caption);
        let age = |result: &Summary| Some((result.mean_input_age, 0.0));
        let svg = against_length("mean age of the input in steps", Start::AtZero, &curves(simulation, age));
        page.figure("age-against-length", svg, "An empty buffer counts as N.");
        if simulation.outcomes.iter().any(|outcome| outcome.summary.send_rate < 1.0) {
            let rate = |result: &Summary| Some((100.0 * result.send_rate, 0.0));
            let svg = against_length("frames sent in % of cycles", Start::AtZero, &curves(simulation, rate));
            page.figure("send-rate-against-length", svg, "");
        }
    });
}

/// One curve per controller: figure, and half the length of its error bar.
fn curves(simulation: &Simulation<'_>, figure: impl Fn(&Summary) -> Option<(f64, f64)>) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for outcome in &simulation.outcomes {
        let result = &outcome.summary;
        if curves.last().is_none_or(|curve| curve.name != result.controller) {
            let is_level = result.controller == crate::contender::Kind::Lqg.name();
            curves.push(Curve { name: result.controller.into(), points: Vec::new(), is_level });
        }
        if let (Some(curve), Some((value, half))) = (curves.last_mut(), figure(result)) {
            curve.points.push((result.sequence_length, value, half));
        }
    }
    curves
}
