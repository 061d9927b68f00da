//! Results of all controllers: in a sentence, and in the table that the terminal shows too.

use super::page::{Page, escaped};
use crate::{
    monte_carlo::Summary,
    output::{Simulation, columns::figure, table},
};
use gain_gen::design::Design;

/// What came out, before anything else.
pub(super) fn headline(page: &mut Page, simulation: &Simulation<'_>, design: &Design) {
    let plan = simulation.plan;
    page.add(format_args!(
        "<p class=\"lead\">{} runs of {} steps ({} s) per controller, seed {}</p>",
        plan.runs,
        plan.steps,
        plan.steps as f64 * simulation.sample_time,
        plan.seed
    ));
    let results = || simulation.outcomes.iter().map(|outcome| &outcome.summary);
    let is_designed = |result: &&Summary| result.sequence_length == design.controller.sequence_length;
    let Some(first) = results().find(is_designed).or_else(|| results().next()) else { return };
    let called = format!("{} with N = {}", first.controller, first.sequence_length);
    let mut text = match (first.mean_cost, first.std_error) {
        (Some(mean), error) => {
            let error = error.map(|error| format!(" \u{b1} {}", figure(Some(error)))).unwrap_or_default();
            format!("{called} costs {}{error} (standard error) in the mean of all runs", figure(Some(mean)))
        }
        (None, _) => format!("{called} has no finite mean cost"),
    };
    let bound = results().find(|result| result.controller == "lqg" && first.controller != "lqg");
    if let Some((mean, bound)) = first.mean_cost.zip(bound.and_then(|bound| bound.mean_cost)) {
        text += &format!(", {:.2} times what lqg costs without a network", mean / bound);
    }
    let diverged: Vec<_> = results()
        .filter(|result| result.diverged > 0)
        .map(|result| {
            format!("{} (N = {}) in {}", result.controller, result.sequence_length, result.diverged)
        })
        .collect();
    text += &match diverged.is_empty() {
        true => "; no run diverged.".to_string(),
        false => format!("; of {} runs each, the state diverged with {}.", plan.runs, diverged.join(", ")),
    };
    page.add(format_args!("<p class=\"found\">{}</p>", escaped(&text)));
}

pub(super) fn add(page: &mut Page, simulation: &Simulation<'_>) {
    page.section("Results");
    page.add("<div class=\"scroll\" tabindex=\"0\"><table class=\"figures\">");
    for (row, cells) in table::rows(simulation).iter().enumerate() {
        let tag = if row == 0 { "th" } else { "td" };
        let cells: String = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect();
        page.add(format_args!("<tr>{cells}</tr>"));
    }
    page.add("</table></div>");
    page.paragraph(&format!(
        "Cost is the sum of {} over a run, terminal term included, in the unit of the weights. Standard error is that of the \
         mean; half of the runs cost less than the median, 95\u{a0}% less than p95. Diverged: runs whose state left 1e6 times its \
         initial or noise scale. Sent: control frames, in\u{a0}% of the cycles. Age is that of the applied input, in steps; an \
         empty buffer counts as N.",
        simulation.stage_cost().replace('\'', "\u{2019}")
    ));
}
