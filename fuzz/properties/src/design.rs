//! Design files: what is wrong is told with its line; what is accepted is solved and judged, and what is emitted reads back as the same
//! gains.

mod emitted;
mod size;

use gain_gen::design::Design;
use gain_gen::report::{Report, Verdict};
use gain_gen::solve::{LoopProblem, Method, solve};
use gain_gen::stability::shortest_admissible_length;

/// Name under which errors report the text.
const ORIGIN: &str = "fuzzed.toml";

/// Takes the bytes for the text of a design file. Of one that is accepted everything is computed, if it is small.
pub fn check(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes)
        && size::is_small(text)
    {
        judged(text);
    }
}

/// Reads, solves, judges and emits the design; whether it is one.
pub(crate) fn judged(text: &str) -> bool {
    let design = match Design::parse(text, ORIGIN) {
        Ok(design) => design,
        Err(error) => {
            let lines = text.lines().count().max(1);
            assert!(
                error.line.is_some_and(|line| (1..=lines + 1).contains(&line)),
                "a line of the text: {error}"
            );
            assert!(!error.found.is_empty() && !error.allowed.is_empty(), "{error}");
            assert!(error.to_string().starts_with(ORIGIN) && !error.to_string().contains('\n'), "{error}");
            return false;
        }
    };
    if !is_quick(&design) {
        return true;
    }
    let mut report = Report::new(&design, Method::InFlight);
    told(&report);
    report.accept_undecided_stability();
    match report.emission() {
        Ok(emission) => emitted::reads_back(&report, &emission),
        Err(error) => {
            assert!(!error.to_string().is_empty());
            assert_ne!(report.verdict(), Verdict::Stable, "{error}: what is stable is emitted");
        }
    }
    true
}

/// Whether a report takes a fraction of a second. Where the loop is not stable it looks for a length that is among all of them; and where
/// nothing arrives at once, at shorter ones that may be on the limit of stability, which takes hundreds of thousands of steps to tell.
fn is_quick(design: &Design) -> bool {
    let problem = LoopProblem::of(design);
    let arrives_at_once = design.network.controller_to_actuator.delays.arrival(0) > 0.0;
    let is_stable = || solve(&problem, Method::InFlight).is_stabilising();
    shortest_admissible_length(&problem).is_none() || arrives_at_once && is_stable()
}

/// Figures are what they can be, and the verdict is what they say.
fn told(report: &Report) {
    assert!(!report.to_string().is_empty());
    let json: serde_json::Value = serde_json::from_str(&report.to_json()).expect("JSON");
    assert_eq!(json["verdict"], report.verdict().name());
    assert_eq!(report.failed_conditions.is_empty(), report.verdict() == Verdict::Stable);
    let (solution, chances) = (&report.solution, &report.transition_matrix);
    assert!(chances.iter().all(|chance| (0.0..=1.0 + 1e-12).contains(chance)));
    assert!(chances.row_iter().all(|row| (row.sum() - 1.0).abs() < 1e-9), "rows of probabilities");
    if report.verdict() == Verdict::Stable {
        assert!(solution.is_stabilising() && report.emitted_rate < 1.0, "{}", report.emitted_rate);
    }
    if solution.is_stabilising() {
        let law = &solution.law;
        assert!(law.lx.iter().chain(law.m.iter()).all(|gain| gain.is_finite()));
        assert!(law.arrival.iter().all(|chance| (0.0..=1.0).contains(chance)));
        assert!(solution.mean_square_rate < 1.0, "{}", solution.mean_square_rate);
        assert!(report.control_cost() >= 0.0, "{}", report.control_cost());
    }
}
