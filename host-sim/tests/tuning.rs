//! A controller that tunes itself comes to cost what the design for the new link costs, and never misses a cycle.

use gain_gen::design::Design;
use host_sim::{
    adaptation::{Adaptation, WindowCost},
    contender::{Change, Contender, ContenderError, Kind},
    monte_carlo::{Plan, Simulate, Summary},
};

const GOOD: &str = include_str!("../../designs/pendulum.toml");
const BAD: &str = include_str!("../../designs/pendulum_bad.toml");
const PLAN: Plan = Plan { runs: 12, steps: 8_000, seed: 3 };
const AT: usize = 2_000;

fn design(text: &str, length: usize) -> Design {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    design
}

/// `kind` designed for `of`, on the link of `from`, which becomes that of `to`.
fn simulated(kind: Kind, of: &Design, from: &Design, to: &Design) -> (Summary, Adaptation) {
    let mut contender = Contender::new(kind, of, PLAN.steps).expect("a stabilised loop");
    contender.put_on(&from.network);
    let link = to.network.controller_to_actuator.clone();
    contender.meet(Change { link, cycle: AT }, of).expect("a stabilised loop");
    let simulate = Simulate { design: of, contender: &contender, plan: PLAN, done: &|| () };
    let summary = simulate.outcome().expect("it can be simulated").summary;
    let windows = summary.adaptation.expect("the link changes");
    (summary, windows)
}

fn cost(window: WindowCost) -> f64 {
    window.mean_cost.expect("a finite cost")
}

/// What tuning costs after the change, relative to the design for that link and to staying with the old law.
fn relative(from: &Design, to: &Design) -> (f64, f64) {
    let (summary, tuning) = simulated(Kind::SlqgTuning, from, from, to);
    assert_eq!((summary.diverged, summary.send_rate), (0, 1.0), "a cycle was missed");
    assert!(tuning.switches >= 1.0, "{tuning:?}");
    let (_, staying) = simulated(Kind::Slqg, from, from, to);
    assert_eq!(staying.before, tuning.before, "before the change both are one");
    let (_, told) = simulated(Kind::SlqgTold, from, from, to);
    let (_, designed) = simulated(Kind::Slqg, to, from, to);
    // The same law on the same packets: only the way there was another.
    assert!((cost(told.after) / cost(designed.after) - 1.0).abs() < 1e-3, "{told:?} {designed:?}");
    (cost(tuning.after) / cost(designed.after), cost(tuning.after) / cost(staying.after))
}

#[test]
fn after_a_link_has_turned_bad_tuning_costs_what_the_design_for_it_costs() {
    let (of_design, of_staying) = relative(&design(GOOD, 6), &design(BAD, 6));
    assert!(of_design < 1.05, "{of_design}");
    assert!(of_staying < 0.7, "{of_staying}");
}

#[test]
fn where_the_old_law_loses_the_rod_tuning_keeps_it() {
    let (of_design, of_staying) = relative(&design(GOOD, 4), &design(BAD, 4));
    assert!(of_design < 1.05, "{of_design}");
    assert!(of_staying < 1e-3, "{of_staying}");
}

#[test]
fn after_a_link_has_turned_good_tuning_costs_what_the_design_for_it_costs() {
    let (of_design, of_staying) = relative(&design(BAD, 6), &design(GOOD, 6));
    assert!(of_design < 1.05, "{of_design}");
    assert!(of_staying < 0.97, "{of_staying}");
}

#[test]
fn on_a_link_that_stays_as_it_is_nothing_is_solved() {
    let good = design(GOOD, 4);
    let (_, tuning) = simulated(Kind::SlqgTuning, &good, &good, &good);
    let (_, plain) = simulated(Kind::Slqg, &good, &good, &good);
    assert_eq!((tuning.solutions, tuning.after), (0.0, plain.after));
}

#[test]
fn late_and_lost_acknowledgements_tell_the_link_too() {
    let mut good = design(GOOD, 6);
    let lossy =
        GOOD.replace("acknowledgement = \"instant\"", "acknowledgement = { delays = [0.5, 0.2, 0.1] }");
    good.network.acknowledgement = design(&lossy, 6).network.acknowledgement;
    let (_, tuning) = simulated(Kind::SlqgTuning, &good, &good, &design(BAD, 6));
    let (_, told) = simulated(Kind::SlqgTold, &good, &good, &design(BAD, 6));
    assert!(cost(tuning.after) < 1.05 * cost(told.after), "{tuning:?} {told:?}");
}

#[test]
fn what_would_not_follow_the_link_is_refused() {
    for (name, text) in [
        ("[event]", include_str!("../../designs/pendulum_event.toml")),
        ("[tracking]", include_str!("../../designs/pendulum_tracking.toml")),
    ] {
        let design = Design::parse(text, "design.toml").expect("a design");
        let error = Contender::new(Kind::SlqgTuning, &design, 100).expect_err("refused");
        assert!(matches!(error, ContenderError::TunesAlone { with, .. } if with == name), "{error}");
    }
}
