//! What all runs say together: ages of inputs, costs, how often was sent.

use super::page::Page;
use crate::output::{
    Simulation,
    charts::{Bars, bars, distribution, rates},
};

pub(super) fn add(page: &mut Page, simulation: &Simulation<'_>) {
    page.section("All runs");
    let named = |name: &str| name.to_string();
    page.grid(|page| {
        let costs: Vec<_> = simulation
            .outcomes
            .iter()
            .map(|outcome| (named(outcome.summary.controller), outcome.costs.as_slice()))
            .collect();
        let unshown: usize =
            costs.iter().map(|(_, costs)| costs.iter().filter(|cost| cost.is_nan()).count()).sum();
        let caption = match unshown {
            0 => "Share of the runs by cost.".to_string(),
            count => format!("Share of the runs by cost. Not drawn: {count} whose cost is not a number."),
        };
        page.figure("cost-distribution", distribution("cost of a run (unit of the cost)", &costs), &caption);
        let ages: Vec<Bars> = simulation
            .outcomes
            .iter()
            .map(|outcome| {
                let cycles = outcome.ages.iter().sum::<u64>().max(1) as f64;
                let mut shares: Vec<f64> = outcome.ages.iter().map(|&count| count as f64 / cycles).collect();
                let rest = shares.pop().unwrap_or(0.0);
                Bars { name: named(outcome.summary.controller), shares, rest }
            })
            .collect();
        let svg = bars("age of the applied input in steps", "cycles in %", "default", &ages);
        page.figure("ages", svg, "Of all cycles of all runs. Default: the buffer was empty.");
        if simulation.outcomes.iter().any(|outcome| outcome.summary.send_rate < 1.0) {
            let sent: Vec<_> = simulation
                .outcomes
                .iter()
                .map(|outcome| (named(outcome.summary.controller), outcome.summary.send_rate))
                .collect();
            page.figure("send-rates", rates(&sent), "Control frames sent, of all cycles of all runs.");
        }
    });
}
