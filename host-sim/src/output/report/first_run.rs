//! The first run of each controller over time: tracked outputs, states with their estimates, inputs.

use super::page::Page;
use crate::{
    closed_loop::CycleRecord,
    output::{
        Simulation,
        charts::{Axis, Trajectory, trajectory},
    },
};

/// Most cycles drawn.
const CYCLES: usize = 500;
/// Ratio of two controllers' ranges above which one axis would hide the narrower.
const INCOMPARABLE: f64 = 20.0;

pub(super) fn add(page: &mut Page, simulation: &Simulation<'_>) {
    let Some(first) = simulation.outcomes.first().and_then(|outcome| outcome.first_run.first()) else {
        return;
    };
    page.section("The first run");
    page.paragraph(
        "All controllers meet the same noise. Their charts of one quantity have one axis, unless the range of one is more \
         than 20 times that of another.",
    );
    if simulation.plan.steps > CYCLES {
        page.paragraph(&format!("Drawn are the first {CYCLES} of {} steps.", simulation.plan.steps));
    }
    if !first.tracked.is_empty() {
        page.heading("Tracked outputs");
    }
    for output in 0..first.tracked.len() {
        let label = format!("z{} (unit of the output)", output + 1);
        quantity(page, simulation, &format!("tracked-output-{}", output + 1), &label, |run| Trajectory {
            values: run.iter().map(|cycle| cycle.tracked[output].0).collect(),
            reference: run.iter().map(|cycle| cycle.tracked[output].1).collect(),
            ..of("output", false)
        });
    }
    for output in 0..first.tracked.len() {
        let label = format!("z{} error (its unit)", output + 1);
        quantity(page, simulation, &format!("tracking-error-{}", output + 1), &label, |run| Trajectory {
            values: run.iter().map(|cycle| cycle.tracked[output].0 - cycle.tracked[output].1).collect(),
            ..of("output less reference", false)
        });
    }
    page.heading("States and estimates");
    for state in 0..first.state.len() {
        let label = format!("x{} (unit of the state)", state + 1);
        quantity(page, simulation, &format!("state-{}", state + 1), &label, |run| Trajectory {
            values: run.iter().map(|cycle| cycle.state[state]).collect(),
            estimates: run.iter().map(|cycle| (cycle.estimate[state], cycle.deviation[state])).collect(),
            ..of("true state", false)
        });
    }
    page.folded("Errors of the estimates", |page| {
        page.paragraph(
            "The true state less its estimate, with the deviation that the estimator computes: 95 % of an error as large as \
             that are within the band.",
        );
        for state in 0..first.state.len() {
            let label = format!("x{} error (its unit)", state + 1);
            quantity(page, simulation, &format!("error-{}", state + 1), &label, |run| Trajectory {
                values: run.iter().map(|cycle| cycle.state[state] - cycle.estimate[state]).collect(),
                estimates: run.iter().map(|cycle| (0.0, cycle.deviation[state])).collect(),
                expected: "zero",
                ..of("error", false)
            });
        }
    });
    page.heading("Inputs");
    for input in 0..first.input.len() {
        let label = format!("u{} (unit of the input)", input + 1);
        quantity(page, simulation, &format!("input-{}", input + 1), &label, |run| Trajectory {
            values: run.iter().map(|cycle| cycle.input[input]).collect(),
            ..of("applied input", true)
        });
    }
}

/// Nothing yet of what is called `name`.
fn of(name: &'static str, is_held: bool) -> Trajectory {
    Trajectory {
        title: String::new(),
        number: 0,
        name,
        values: Vec::new(),
        estimates: Vec::new(),
        expected: "estimate",
        reference: Vec::new(),
        is_held,
    }
}

/// Charts of one quantity beside each other, one per controller.
fn quantity(
    page: &mut Page,
    simulation: &Simulation<'_>,
    name: &str,
    label: &str,
    taken: impl Fn(&[CycleRecord]) -> Trajectory,
) {
    let all: Vec<Trajectory> = simulation
        .outcomes
        .iter()
        .enumerate()
        .map(|(number, outcome)| {
            let run = &outcome.first_run;
            let title = outcome.summary.controller.to_string();
            Trajectory { title, number, ..taken(&run[..run.len().min(CYCLES)]) }
        })
        .collect();
    let axes: Vec<Axis> = all.iter().map(|one| Axis::linear(label, one.extent())).collect();
    let shared = Axis::linear(label, all.iter().flat_map(Trajectory::extent));
    let is_shared = axes.iter().all(|axis| shared.length() < INCOMPARABLE * axis.length());
    page.grid(|page| {
        for (one, own) in all.iter().zip(&axes) {
            let axis = if is_shared { &shared } else { own };
            let svg = trajectory(one, axis, simulation.sample_time);
            page.figure(&format!("{name}-{}", one.title), svg, "");
        }
    });
}
