//! What was designed: plant, controller, links, and whether it is stable by which conditions.

use super::page::{Page, escaped};
use crate::output::{
    charts::{Bars, bars},
    columns::figure,
};
use gain_gen::{
    design::{Acknowledgement, Behaviour, DelayDistribution, Design, DeviceScalar, Goal, Link, Rule},
    report::{Report, Verdict},
    solve::Method,
};
use slqg::{DefaultInput, estimator::Merging};

pub(super) fn add(page: &mut Page, design: &Design) {
    let report = Report::new(design, Method::InFlight);
    page.section("What was designed");
    page.grid(|page| {
        page.cell(|page| {
            page.add("<table class=\"facts\">");
            for (what, text) in facts(design, &report) {
                page.add(format_args!("<tr><th scope=\"row\">{what}</th><td>{}</td></tr>", escaped(&text)));
            }
            page.add("</table>");
        });
        page.cell(|page| delays(page, design));
    });
    page.paragraph(
        "The design file gives no units of states, inputs and outputs: axes are in those that its matrices are in. Of time it \
         does: seconds. A step is one cycle of the loop, as long as the sample time.",
    );
    verdict(page, &report);
}

fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn facts(design: &Design, report: &Report) -> Vec<(&'static str, String)> {
    let (plant, settings, network) = (&design.plant, &design.controller, &design.network);
    let length = settings.sequence_length;
    let chosen = design.length_choice().map(|choice| format!(" ({choice})")).unwrap_or_default();
    let mut facts = vec![
        (
            "Plant",
            format!(
                "{}, {}, {}; largest |eigenvalue| {} per step",
                counted(plant.states(), "state"),
                counted(plant.inputs(), "input"),
                counted(plant.outputs(), "output"),
                rate(report.open_loop_modulus)
            ),
        ),
        ("Sample time", format!("{} s", plant.sample_time)),
        ("Sequence", format!("N = {}{chosen}", counted(length, "input"))),
        (
            "Default input",
            match settings.default_input {
                DefaultInput::Zero => "zero: when its sequence has run out, the actuator applies 0".into(),
                DefaultInput::Hold => {
                    "hold: when its sequence has run out, the actuator keeps its last input".into()
                }
            },
        ),
        ("Controller to actuator", link(&network.controller_to_actuator, length - 1, "the sequence")),
        (
            "Sensor to controller",
            link(&network.sensor_to_controller, settings.measurement_buffer, "the measurement buffer"),
        ),
        ("Acknowledgement", acknowledgement(design)),
        (
            "Estimator",
            match design.estimator() {
                Merging::Single => "single: one filter, told mean and covariance of the input",
                Merging::Imm => "imm: keeps the age in the last cycle apart",
                Merging::Gpb2 => "gpb2: keeps the ages in the last two cycles apart",
                Merging::Linear => {
                    "linear: one filter, told the mean of the input; gains that know it is uncertain"
                }
            }
            .into(),
        ),
        (
            "Device",
            format!(
                "wire format {}, arithmetic in {}",
                design.wire.name(),
                match settings.scalar {
                    DeviceScalar::F32 => "f32",
                    DeviceScalar::F64 => "f64",
                }
            ),
        ),
    ];
    if let Some(limits) = &settings.input_limits {
        let text: Vec<_> = limits.iter().map(|(least, greatest)| format!("[{least}, {greatest}]")).collect();
        facts.push(("Input limits", format!("{} (unit of the input)", text.join(", "))));
    }
    if let Some(tracking) = &design.tracking {
        let goal = match &tracking.goal {
            Goal::SetPoint(_) => "stays at a set point",
            Goal::Trajectory(_) => "follows a reference that moves",
        };
        facts.push(("Tracking", format!("{}: {goal}", counted(tracking.outputs(), "tracked output"))));
    }
    if let Some(event) = &design.event {
        let when = match event.rule {
            Rule::Worth => "where it is worth that",
            Rule::Schedule => "at fixed times",
        };
        facts.push((
            "Event trigger",
            format!("a control packet costs {}, and is sent {when}", event.send_cost),
        ));
    }
    facts
}

fn link(link: &Link, last: usize, room: &str) -> String {
    let delays = &link.delays;
    let kind = match &link.behaviour {
        Behaviour::Independent => String::new(),
        Behaviour::Markov(channel) => {
            format!("; a channel of {} that come and go", counted(channel.states(), "state"))
        }
        Behaviour::Recorded(recording) => format!("; recorded in {}", counted(recording.cycles(), "cycle")),
        Behaviour::Bus => "; over a CAN bus, delays as found by running the loop's frames on it".into(),
    };
    format!(
        "loss {}, mean delay {} steps, {} arrive within {room} (at most {} late){kind}",
        percent(delays.loss()),
        figure(Some(delays.mean_delay())),
        percent(delays.arrival(last)),
        counted(last, "step"),
    )
}

fn acknowledgement(design: &Design) -> String {
    let cycles = design.network.acknowledged_cycles;
    match &design.network.acknowledgement {
        Acknowledgement::Instant => "instant: the controller learns one step later what is applied".into(),
        Acknowledgement::None => "none: the controller never learns what is applied".into(),
        Acknowledgement::Over(link) => format!(
            "over a link: loss {}, mean delay {} steps; each tells of {}",
            percent(link.delays.loss()),
            figure(Some(link.delays.mean_delay())),
            counted(cycles, "cycle"),
        ),
    }
}

fn delays(page: &mut Page, design: &Design) {
    let bars_of = |name: &str, delays: &DelayDistribution| Bars {
        name: name.into(),
        shares: delays.probabilities().to_vec(),
        rest: delays.loss(),
    };
    let network = &design.network;
    let mut series = vec![
        bars_of("controller to actuator", &network.controller_to_actuator.delays),
        bars_of("sensor to controller", &network.sensor_to_controller.delays),
    ];
    if let Acknowledgement::Over(link) = &network.acknowledgement {
        series.push(bars_of("acknowledgement", &link.delays));
    }
    let svg = bars("delay d in steps", "P(delay = d) in %", "lost", &series);
    let losses: Vec<_> = series.iter().map(|bars| format!("{} {}", bars.name, percent(bars.rest))).collect();
    page.figure("delays", svg, &format!("Long-run share of packets by delay. Lost: {}.", losses.join("; ")));
}

fn verdict(page: &mut Page, report: &Report) {
    let verdict = report.verdict();
    page.heading("Verdict");
    let name = verdict.name();
    page.add(format_args!(
        "<p><span class=\"verdict {name}\">{name}</span> with N = {}</p>",
        report.solution.law.length
    ));
    if verdict != Verdict::Stable {
        for failed in &report.failed_conditions {
            page.paragraph(&failed.to_string());
        }
    }
    let rows = [
        (
            "Theorem 3.3 b)",
            "mean-square rate of the closed loop",
            report.solution.mean_square_rate,
            "< 1",
            report.solution.mean_square_rate < 1.0,
        ),
        (
            "Theorem 3.4 b)",
            "(1 \u{2212} Q(N\u{2212}1)) |\u{3bb}max(A)|\u{b2}: how often the buffer runs dry",
            report.dry_growth,
            "\u{2264} 1",
            report.dry_growth <= 1.0,
        ),
        (
            "Theorem 3.4 a)",
            "(1 \u{2212} q_arr) |\u{3bb}max(A)|\u{b2}: how often measurements fail to come",
            report.sight_growth,
            "< 1",
            report.sight_growth < 1.0,
        ),
    ];
    page.add("<div class=\"scroll\" tabindex=\"0\"><table class=\"figures\"><tr><th>condition</th><th>per step</th><th>allowed</th><th></th><th class=\"text\">figure</th></tr>");
    for (theorem, of, value, allowed, holds) in rows {
        let holds = if holds { "\u{2713} holds" } else { "\u{2717} fails" };
        page.add(format_args!(
            "<tr><td>{theorem}</td><td>{}</td><td>{}</td><td>{holds}</td><td class=\"text\">{of}</td></tr>",
            rate(value),
            escaped(allowed)
        ));
    }
    page.add("</table></div>");
    let length = |length: Option<usize>| length.map_or("none found".into(), |length| length.to_string());
    page.paragraph(&format!(
        "Shortest length that Theorem 3.4 b) does not rule out: {}. Shortest length that stabilises: {}.",
        length(report.n_min),
        length(report.n_crit)
    ));
    page.folded("All figures of the design, as gain-gen reports them", |page| {
        page.add(format_args!("<pre>{}</pre>", escaped(&report.to_string())));
    });
}

/// A figure that is compared with 1, and does not read 1 unless it is.
fn rate(value: f64) -> String {
    let text = figure(value.is_finite().then_some(value));
    if value != 1.0 && text == figure(Some(1.0)) { format!("{value:.12}") } else { text }
}

fn percent(share: f64) -> String {
    let share = 100.0 * share;
    if share == 0.0 || share >= 0.01 { format!("{share:.2}\u{a0}%") } else { format!("{share:.1e}\u{a0}%") }
}
