//! What no acknowledgement costs on other plants and for longer sequences. Minutes of work: run with `-- --ignored`.

use gain_gen::{
    design::{Acknowledgement, Design},
    solve::{LoopProblem, Method, solve},
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Outcome, Plan, Simulate},
};
use slqg::estimator::Merging;

const EVALUATION: &str = include_str!("../../docs/evaluation.md");
const PLAN: Plan = Plan { runs: 300, steps: 500, seed: 1 };
const LENGTHS: [usize; 8] = [1, 2, 3, 4, 5, 6, 8, 10];
const DESIGNS: [(&str, &str); 6] = [
    ("integrator", include_str!("../../designs/double_integrator.toml")),
    ("integrator bad", include_str!("../../designs/double_integrator_bad.toml")),
    ("pendulum", include_str!("../../designs/pendulum.toml")),
    ("pendulum bad", include_str!("../../designs/pendulum_bad.toml")),
    ("critical good", include_str!("../../designs/critical_good.toml")),
    ("critical bad", include_str!("../../designs/critical_bad.toml")),
];

/// Four digits, or a dash where a run diverged.
fn figure(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        Some(value) if value >= 1e6 => format!("{value:.1e}"),
        Some(value) => {
            let digits = (3.0 - value.log10().floor()).clamp(0.0, 4.0) as usize;
            format!("{value:.digits$}")
        }
    }
}

fn simulated(design: &Design, contender: &Contender) -> Outcome {
    Simulate { design, contender, plan: PLAN, done: &|| () }.outcome().expect("it can be simulated")
}

/// Mean with instant acknowledgements; without any, the loop of the linear law, and of the law for known ages.
fn row(text: &str, length: usize) -> String {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    let Ok(instant) = Contender::new(Kind::Slqg, &design, PLAN.steps) else { return "unstable".into() };
    let mean = figure(simulated(&design, &instant).summary.mean_cost);
    design.network.acknowledgement = Acknowledgement::None;
    let spelled = |outcome: Outcome| {
        let summary = outcome.summary;
        [summary.mean_cost, summary.median_cost, summary.p95_cost, summary.worst_cost].map(figure).join(" ")
    };
    let linear = match Contender::new(Kind::Slqg, &design, PLAN.steps) {
        Ok(contender) => spelled(simulated(&design, &contender)),
        Err(_) => "- - - -".into(),
    };
    design.controller.estimator = Some(Merging::Single);
    let mut known = Contender::new(Kind::Slqg, &design, PLAN.steps).expect("it runs with instant ones");
    known.laws = vec![solve(&LoopProblem::of(&design), Method::InFlight).law];
    format!("{mean} {linear} {}", spelled(simulated(&design, &known)))
}

#[test]
#[ignore = "minutes"]
fn loops_without_acknowledgements_cost_what_the_evaluation_says() {
    let rows: Vec<_> = DESIGNS
        .iter()
        .flat_map(|(name, text)| LENGTHS.map(|length| format!("{name} {length} {}", row(text, length))))
        .collect();
    rows.iter().for_each(|line| println!("{line}"));
    for line in rows {
        let shown = EVALUATION.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()));
        assert!(shown, "not in docs/evaluation.md: {line}");
    }
}
