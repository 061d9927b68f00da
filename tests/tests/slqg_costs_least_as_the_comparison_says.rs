//! No controller that knows as much costs less than `slqg`, and every row of `docs/comparison.md` is what is found today.

use gain_gen::{
    design::Design,
    report::Report,
    solve::{LoopProblem, Method, mean_square_rate},
};
use host_sim::{
    contender::{Contender, Kind},
    figures::paired::{Amount, Comparison, Finding, OTHERS, table},
};
use slqg::DefaultInput;
use slqg_tests::page::{Page, design};

const PAGE: Page = Page { name: "comparison.md", text: include_str!("../../docs/comparison.md") };
/// As the commands on the page say.
const AMOUNT: Amount = Amount { runs: 400, start: 0, steps: 200, seed: 1 };
const LENGTHS: &[usize] = &[1, 2, 3, 4, 5, 6];
const DESIGNS: [(&str, &[usize]); 6] = [
    ("double_integrator", LENGTHS),
    ("double_integrator_bad", LENGTHS),
    ("critical_good", LENGTHS),
    ("critical_bad", &[1, 2, 3, 4, 5, 6, 8, 10]),
    ("pendulum", LENGTHS),
    ("pendulum_bad", LENGTHS),
];

#[test]
fn slqg_is_beaten_nowhere_and_every_row_is_on_the_page() {
    let all: Vec<Comparison> = DESIGNS
        .iter()
        .flat_map(|(name, lengths)| {
            let design = design(name);
            assert_eq!(design.controller.input_limits, None, "{name}: limits are another comparison");
            let comparisons = Comparison::all(&design, lengths, AMOUNT);
            let expected: Vec<String> = table(&comparisons).lines().map(|line| line.trim().into()).collect();
            assert_eq!(PAGE.block(name), expected, "{name}");
            comparisons
        })
        .collect();
    let differences = || all.iter().flat_map(|one| one.others.iter().map(move |other| (one, other)));
    for finding in [Finding::Dearer, Finding::Same, Finding::Open, Finding::Unstable, Finding::Cheaper] {
        let count = differences().filter(|(_, other)| other.finding() == finding).count();
        let row = PAGE.text.lines().find(|line| line.starts_with(&format!("| `{}`", finding.name())));
        let row = row.unwrap_or_else(|| panic!("`{}` is not explained", finding.name()));
        assert!(row.ends_with(&format!("| {count} |")), "{count}: {row}");
    }
    let lawless = all.iter().filter(|one| one.own.is_none()).count();
    assert!(PAGE.text.contains(&format!("there is nothing to compare with | {lawless} |")), "{lawless}");
    assert!(differences().all(|(_, other)| other.finding() != Finding::Cheaper));

    // What the page says of single rows.
    for (one, other) in differences() {
        let is_same = other.kind == Kind::LqgLoss && one.length == 1;
        assert_eq!(other.finding() == Finding::Same, is_same, "{} {other:?}", one.design);
        if one.design.ends_with("_bad") && other.finding() == Finding::Open {
            assert_eq!((one.design.as_str(), one.length, other.kind), ("pendulum_bad", 5, Kind::Mpc));
            PAGE.says(&format!("(rate {:.3})", other.rate));
        }
        let is_stable = other.finding() != Finding::Unstable;
        match one.design.as_str() {
            "double_integrator_bad" => {
                assert_eq!(is_stable, is_same || other.kind == Kind::Mpc && one.length >= 5, "{other:?}");
            }
            "critical_bad" => assert!(!is_stable, "{other:?}"),
            _ => (),
        }
    }
    let (own, nominal) = differences()
        .find(|(one, other)| one.design == "pendulum" && one.length == 2 && other.kind == Kind::Nominal)
        .map(|(one, other)| (one.own.expect("a law").2, other))
        .expect("a row");
    assert!(nominal.rate < own && nominal.finding() == Finding::Dearer, "a lower rate is not a lower cost");
}

#[test]
fn where_there_is_no_steady_law_no_other_is_stable_either() {
    for (name, excluded, shortest) in [("critical_bad", 4, 8), ("pendulum_bad", 2, 4)] {
        let mut design: Design = design(name);
        let report = Report::new(&design, Method::InFlight);
        assert_eq!((report.n_min, report.n_crit), (Some(excluded + 1), Some(shortest)), "{name}");
        for length in 1..shortest {
            design.set_sequence_length(length);
            for kind in OTHERS {
                // One that has no law for its own picture of the network has none.
                let Ok(contender) = Contender::new(kind, &design, AMOUNT.steps) else { continue };
                let rate = mean_square_rate(&LoopProblem::of(&design), &contender.laws[0].mode_gains());
                assert!(rate >= 1.0, "{name}, {}, N = {length}: {rate}", kind.name());
            }
        }
        design.set_sequence_length(1);
        design.controller.default_input = DefaultInput::Hold;
        assert!(Contender::new(Kind::Slqg, &design, AMOUNT.steps).is_err());
    }
}
