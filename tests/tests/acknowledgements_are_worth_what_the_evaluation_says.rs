//! What acknowledgements are worth: the double integrator on both networks, from instant ones to none.

use gain_gen::design::{Acknowledgement, DelayDistribution, Design, Link};
use gain_gen::solve::{LoopProblem, Method, solve};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Outcome, Plan, Simulate},
    sample::{mean, standard_error},
};
use slqg::estimator::Merging;

const EVALUATION: &str = include_str!("../../docs/evaluation.md");
const README: &str = include_str!("../../README.md");
const GOOD: &str = include_str!("../../designs/double_integrator.toml");
const BAD: &str = include_str!("../../designs/double_integrator_bad.toml");
const PLAN: Plan = Plan { runs: 1000, steps: 200, seed: 1 };
const LENGTHS: std::ops::RangeInclusive<usize> = 1..=6;

fn over(probabilities: &[f64]) -> Acknowledgement {
    Acknowledgement::Over(Link::independent(
        DelayDistribution::new(probabilities.to_vec()).expect("a distribution"),
    ))
}

fn design(text: &str, length: usize) -> Design {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    design
}

/// The loop with these acknowledgements; each tells `cycles` cycles.
fn outcome(
    design: &Design,
    acknowledgement: &Acknowledgement,
    cycles: usize,
    merging: Option<Merging>,
) -> Outcome {
    let mut design = design.clone();
    design.network.acknowledgement = acknowledgement.clone();
    design.network.acknowledged_cycles = cycles;
    design.controller.estimator = merging.or(design.controller.estimator);
    let contender = Contender::new(Kind::Slqg, &design, PLAN.steps).expect("a stabilised loop");
    simulated(&design, &contender)
}

fn simulated(design: &Design, contender: &Contender) -> Outcome {
    let simulate = Simulate { design, contender, plan: PLAN, done: &|| () };
    simulate.outcome().expect("it can be simulated")
}

/// Digits for a table of estimators.
fn spelled_costs(outcome: &Outcome) -> String {
    let summary = &outcome.summary;
    let costs =
        [summary.mean_cost, summary.std_error, summary.median_cost, summary.p95_cost, summary.worst_cost];
    costs.map(figure).join(" ")
}

/// Digits for a table of costs.
fn figure(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        Some(value) if value < 1e6 => format!("{value:.0}"),
        Some(value) => format!("{value:.2e}"),
    }
}

/// Column widths depend on the other rows.
fn assert_shown(lines: &[String]) {
    lines.iter().for_each(|line| eprintln!("{line}"));
    for line in lines {
        let shown = EVALUATION.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()));
        assert!(shown, "not in docs/evaluation.md: {line}");
    }
}

fn qualities(design: &Design) -> [(&'static str, Acknowledgement); 6] {
    let data = Acknowledgement::Over(design.network.controller_to_actuator.clone());
    [
        ("instant", Acknowledgement::Instant),
        ("10 % lost", over(&[0.9])),
        ("30 % lost", over(&[0.7])),
        ("60 % lost", over(&[0.4])),
        ("as data", data),
        ("none", Acknowledgement::None),
    ]
}

fn fewer_cost_more(name: &str, text: &str) {
    let mut rows = Vec::new();
    for (spelled, _) in qualities(&design(text, 1)) {
        for of in ["mean", "std error", "median", "p95", "worst", "diverged"] {
            rows.push((spelled, of, format!("{name} {spelled} {of}")));
        }
    }
    for length in LENGTHS {
        let design = design(text, length);
        let outcomes =
            qualities(&design).map(|(spelled, quality)| (spelled, outcome(&design, &quality, 8, None)));
        for (spelled, of, row) in &mut rows {
            let (_, outcome) = outcomes.iter().find(|(other, _)| other == spelled).expect("a quality");
            let summary = &outcome.summary;
            *row += &match *of {
                "mean" => format!(" {}", figure(summary.mean_cost)),
                "std error" => format!(" {}", figure(summary.std_error)),
                "median" => format!(" {}", figure(summary.median_cost)),
                "p95" => format!(" {}", figure(summary.p95_cost)),
                "worst" => format!(" {}", figure(summary.worst_cost)),
                _ => format!(" {}", summary.diverged),
            };
        }
        // Those of the same delay: from all to none.
        let [instant, tenth, third, most, _, none] = outcomes.map(|(_, outcome)| outcome);
        for pair in [instant, tenth, third, most, none].windows(2) {
            // Both met the same noise: the difference tells more than either.
            let differences: Vec<f64> =
                pair[1].costs.iter().zip(&pair[0].costs).map(|(fewer, more)| fewer - more).collect();
            let (more, error) = (mean(&differences), standard_error(&differences));
            assert!(more > -2.0 * error, "{name}, N = {length}: {more} +- {error}");
        }
    }
    assert_shown(&rows.into_iter().map(|(_, _, row)| row).collect::<Vec<_>>());
}

#[test]
fn fewer_acknowledgements_cost_more_on_the_good_network() {
    fewer_cost_more("good", GOOD);
}

#[test]
fn fewer_acknowledgements_cost_more_on_the_bad_network() {
    fewer_cost_more("bad", BAD);
}

#[test]
fn the_readme_says_what_lost_acknowledgements_cost() {
    let design = design(GOOD, 4);
    let cost = |quality: &Acknowledgement| mean(&outcome(&design, quality, 8, None).costs);
    let all = cost(&Acknowledgement::Instant);
    let more = [over(&[0.9]), over(&[0.4]), Acknowledgement::None]
        .map(|quality| format!("{:.0} %", 100.0 * (cost(&quality) / all - 1.0)));
    let sentence =
        format!("a tenth lost costs {} more, 60 % lost {}, none at all {}", more[0], more[1], more[2]);
    let readme = README.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(readme.contains(&sentence), "{sentence}");
}

#[test]
fn acknowledgements_that_are_always_in_time_give_the_plain_controller_bit_for_bit() {
    for text in [GOOD, BAD] {
        let design = design(text, 4);
        let plain = outcome(&design, &Acknowledgement::Instant, 1, None);
        for merging in [Merging::Single, Merging::Imm, Merging::Gpb2] {
            let over_a_link = outcome(&design, &over(&[1.0]), 8, Some(merging));
            assert_eq!(over_a_link.costs, plain.costs, "{merging:?}");
        }
    }
}

#[test]
fn acknowledgements_that_repair_losses_are_worth_more_than_plain_ones() {
    let mut lines = Vec::new();
    for (name, text) in [("good", GOOD), ("bad", BAD)] {
        let design = design(text, 4);
        let [plain, repairing] = [1, 8].map(|cycles| outcome(&design, &over(&[0.7]), cycles, None));
        let differences: Vec<f64> =
            plain.costs.iter().zip(&repairing.costs).map(|(plain, repairing)| plain - repairing).collect();
        let (saved, error) = (mean(&differences), standard_error(&differences));
        assert!(saved > 3.0 * error, "{name}: {saved} +- {error}");
        for (spelled, outcome) in [("plain", plain), ("repairing", repairing)] {
            let summary = outcome.summary;
            let costs =
                [summary.mean_cost, summary.std_error, summary.median_cost, summary.p95_cost].map(figure);
            lines.push(format!("{name} {spelled} {}", costs.join(" ")));
        }
    }
    assert_shown(&lines);
}

/// The same loop with the gains that are optimal where every age is known.
fn with_gains_for_known_ages(design: &Design, contender: &Contender) -> Contender {
    let law = solve(&LoopProblem::of(design), Method::InFlight).law;
    Contender { laws: vec![law], ..contender.clone() }
}

#[test]
fn gains_that_know_of_lost_acknowledgements_cost_less_and_have_lighter_tails() {
    let mut lines = Vec::new();
    for (name, text) in [("good", GOOD), ("bad", BAD)] {
        let [_, lost @ .., _] = qualities(&design(text, 4));
        for (spelled, quality) in lost {
            let mut design = design(text, 4);
            design.network.acknowledgement = quality;
            let contender = Contender::new(Kind::Slqg, &design, PLAN.steps).expect("a stabilised loop");
            let before = simulated(&design, &with_gains_for_known_ages(&design, &contender));
            let now = simulated(&design, &contender);
            for (gains, outcome) in [("known ages", &before), ("the mixture", &now)] {
                lines.push(format!("{name} {spelled}, {gains} {}", spelled_costs(outcome)));
            }
            assert!(now.summary.mean_cost < before.summary.mean_cost, "{name} {spelled}");
            assert!(now.summary.p95_cost < before.summary.p95_cost, "{name} {spelled}");
        }
    }
    assert_shown(&lines);
}

#[test]
fn estimators_side_by_side_without_acknowledgements() {
    let mut lines = Vec::new();
    for (name, text) in [("good", GOOD), ("bad", BAD)] {
        let design = design(text, 4);
        let mut tails = Vec::new();
        for merging in [Merging::Linear, Merging::Single, Merging::Imm, Merging::Gpb2] {
            let mut design = design.clone();
            design.network.acknowledgement = Acknowledgement::None;
            design.controller.estimator = Some(merging);
            let mut contender = Contender::new(Kind::Slqg, &design, PLAN.steps).expect("a stabilised loop");
            if merging != Merging::Linear {
                contender = with_gains_for_known_ages(&design, &contender);
            }
            let outcome = simulated(&design, &contender);
            lines.push(format!("{name} {} {}", merging.name(), spelled_costs(&outcome)));
            tails.push(outcome.summary.p95_cost.expect("finite"));
        }
        let lightest = tails.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(tails[0] <= lightest, "the default has the lightest tail: {tails:?}");
    }
    assert_shown(&lines);
}

#[test]
fn weighing_ages_by_the_measurements_gains_little_on_top_of_the_linear_law() {
    let mut lines = Vec::new();
    for (name, text) in [("good", GOOD), ("bad", BAD)] {
        let mut design = design(text, 4);
        design.network.acknowledgement = Acknowledgement::None;
        let linear = Contender::new(Kind::Slqg, &design, PLAN.steps).expect("a stabilised loop");
        let alone = simulated(&design, &linear);
        for merging in [Merging::Single, Merging::Imm, Merging::Gpb2] {
            // These know the spread of the input by themselves.
            let contender = Contender { merging, filter_noise: None, ..linear.clone() };
            let outcome = simulated(&design, &contender);
            lines.push(format!("{name} {}, linear gains {}", merging.name(), spelled_costs(&outcome)));
            let (weighed, without) = (outcome.summary.mean_cost.unwrap(), alone.summary.mean_cost.unwrap());
            assert!((0.96..1.01).contains(&(weighed / without)), "{name} {}: {weighed}", merging.name());
        }
    }
    assert_shown(&lines);
}

/// Within how much of instant acknowledgements the default stays, and how far its worst run goes.
#[test]
fn without_acknowledgements_there_is_no_heavy_tail() {
    for (text, most) in [(GOOD, 1.2), (BAD, 1.5)] {
        let design = design(text, 4);
        let instant = outcome(&design, &Acknowledgement::Instant, 8, None);
        let none = outcome(&design, &Acknowledgement::None, 8, None).summary;
        let ratio = none.mean_cost.unwrap() / instant.summary.mean_cost.unwrap();
        let worst = none.worst_cost.unwrap() / none.median_cost.unwrap();
        println!("{} times the cost of instant ones, worst {worst} times the median", ratio);
        assert!(ratio < most && worst < 10.0, "{ratio} {worst}");
    }
}
