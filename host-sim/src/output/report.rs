//! The report: one HTML file with everything in it, for a browser without a network.

use super::{
    Simulation,
    charts::{Series, distribution, points, trajectory},
    columns::figure,
};
use std::fmt::Write;

const STYLE: &str = "\
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { margin-bottom: 0; } h2 { margin-top: 2.5rem; }
table { border-collapse: collapse; } th, td { padding: .25rem .7rem; text-align: right; border-bottom: 1px solid #8884; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
figure { margin: 1rem 0; } figure svg { width: 100%; height: auto; border-radius: 6px; }
figcaption { font-size: .9rem; opacity: .8; }
.scroll { overflow-x: auto; }
";

/// The simulation as a self-contained HTML page.
pub fn report(simulation: &Simulation<'_>) -> String {
    let plan = simulation.plan;
    let name = escaped(simulation.name);
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{name}: closed loop over a lossy link</title>\n<style>\n{STYLE}</style></head><body>\n\
         <h1>{name}</h1>\n<p>{} runs of {} steps ({} s), seed {}.</p>\n",
        plan.runs,
        plan.steps,
        plan.steps as f64 * simulation.sample_time,
        plan.seed
    );
    results(&mut html, simulation);
    html.push_str("<h2>Cost of a run</h2>\n");
    let costs: Vec<_> = simulation
        .outcomes
        .iter()
        .map(|outcome| (outcome.summary.controller, outcome.costs.as_slice()))
        .collect();
    let caption = "Share of runs by cost. The most expensive hundredth is not shown; the table has it.";
    picture(&mut html, &distribution(&costs), caption);
    html.push_str("<h2>The first run</h2>\n");
    trajectories(&mut html, simulation);
    html.push_str("</body></html>\n");
    html
}

fn results(html: &mut String, simulation: &Simulation<'_>) {
    let is_priced = simulation.is_priced();
    let priced = if is_priced { "<th>with sending</th><th>standard error</th>" } else { "" };
    let _ = writeln!(
        html,
        "<h2>Results</h2>\n<div class=\"scroll\"><table><tr><th>controller</th><th>N</th><th>mean cost</th>\
         <th>standard error</th><th>median</th><th>95 % below</th><th>diverged</th><th>sent</th><th>mean age</th>{priced}</tr>"
    );
    for outcome in &simulation.outcomes {
        let result = &outcome.summary;
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.1} %</td><td>{:.2}</td>{}</tr>",
            result.controller,
            result.sequence_length,
            figure(result.mean_cost),
            figure(result.std_error),
            figure(result.median_cost),
            figure(result.p95_cost),
            result.diverged,
            100.0 * result.send_rate,
            result.mean_input_age,
            if is_priced {
                format!(
                    "<td>{}</td><td>{}</td>",
                    figure(result.mean_total_cost),
                    figure(result.total_std_error)
                )
            } else {
                String::new()
            }
        );
    }
    let _ = write!(
        html,
        "</table></div>\n<p>Cost is the sum of {} over a run, terminal term included. Age is that of the applied input, in \
         steps; an empty buffer counts as N.</p>\n",
        simulation.stage_cost().replace('\'', "&#8217;")
    );
}

fn trajectories(html: &mut String, simulation: &Simulation<'_>) {
    let first = simulation.outcomes.first().and_then(|outcome| outcome.first_run.first());
    let Some(first) = first else { return };
    let series = |value: &dyn Fn(&crate::closed_loop::CycleRecord) -> f64| -> Vec<Series<'_>> {
        simulation
            .outcomes
            .iter()
            .map(|outcome| Series {
                name: outcome.summary.controller,
                points: points(&outcome.first_run, simulation.sample_time, value),
            })
            .collect()
    };
    for output in 0..first.tracked.len() {
        let mut lines = series(&|cycle| cycle.tracked[output].0);
        // The reference is the same for all.
        let reference = points(&simulation.outcomes[0].first_run, simulation.sample_time, |cycle| {
            cycle.tracked[output].1
        });
        lines.push(Series { name: "reference", points: reference });
        picture(html, &trajectory(&format!("tracked output {}", output + 1), &lines), "");
    }
    for state in 0..first.state.len() {
        let lines = series(&|cycle| cycle.state[state]);
        picture(html, &trajectory(&format!("state {}", state + 1), &lines), "");
    }
    for input in 0..first.input.len() {
        let lines = series(&|cycle| cycle.input[input]);
        picture(html, &trajectory(&format!("input {}", input + 1), &lines), "");
    }
    for outcome in &simulation.outcomes {
        if outcome.first_run.iter().all(|cycle| cycle.age == Some(0)) {
            // Nothing was late: a flat line would only take room.
            continue;
        }
        let length = outcome.summary.sequence_length;
        let ages =
            points(&outcome.first_run, simulation.sample_time, |cycle| cycle.age.unwrap_or(length) as f64);
        let lines = [Series { name: outcome.summary.controller, points: ages }];
        let caption = format!("Age of the applied input in steps; {length} is an empty buffer.");
        picture(html, &trajectory("age in steps", &lines), &caption);
    }
}

fn picture(html: &mut String, svg: &str, caption: &str) {
    let _ = write!(html, "<figure>{}", responsive(svg));
    if !caption.is_empty() {
        let _ = write!(html, "<figcaption>{caption}</figcaption>");
    }
    html.push_str("</figure>\n");
}

/// The picture without its fixed size, so that the page decides; its view box keeps the proportions.
fn responsive(svg: &str) -> String {
    match (svg.find(" width="), svg.find(" viewBox=")) {
        (Some(size), Some(view)) if size < view => format!("{}{}", &svg[..size], &svg[view..]),
        _ => svg.to_string(),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
