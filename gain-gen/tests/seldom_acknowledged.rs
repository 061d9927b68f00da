//! The law where acknowledgements come late or are lost: between the optimum for known ages and the law that knows none.

use gain_gen::design::{Acknowledgement, DelayDistribution, Design, Link};
use gain_gen::emit::{Format, emit};
use gain_gen::report::{Report, Verdict};
use gain_gen::solve::{LoopProblem, Method, Solution, solve};
use slqg::estimator::Merging;

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const TRACKING: &str = include_str!("../../designs/pendulum_tracking.toml");
const EVENT: &str = include_str!("../../designs/pendulum_event.toml");
const BAD: &str = include_str!("../../designs/double_integrator_bad.toml");

fn design(text: &str, arrives: &[f64]) -> Design {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    let delays = DelayDistribution::new(arrives.to_vec()).expect("a distribution");
    design.network.acknowledgement = Acknowledgement::Over(Link::independent(delays));
    design
}

/// The optimum for known ages, and what is made of it.
fn solved(design: &Design) -> [Solution; 2] {
    let problem = LoopProblem::of(design);
    let known = solve(&problem, Method::InFlight);
    [known.clone(), known.for_acknowledgements(design, &problem)]
}

/// How far the law is from the optimum for known ages, relative to its largest gain.
fn distance([known, made]: &[Solution; 2]) -> f64 {
    (&known.law.lx - &made.law.lx).amax() / known.law.lx.amax()
}

#[test]
fn with_acknowledgements_that_always_come_in_time_it_is_the_optimum_to_the_bit() {
    for text in [PENDULUM, BAD] {
        let [known, made] = solved(&design(text, &[1.0]));
        assert_eq!(known.law, made.law);
        assert_eq!(made.unknown_weight, 0.0);
    }
}

#[test]
fn the_fewer_come_the_further_it_is_from_the_optimum_for_known_ages() {
    for text in [PENDULUM, BAD] {
        let mut last = 0.0;
        for arrives in [0.999, 0.9, 0.6, 0.3, 0.01] {
            let solutions = solved(&design(text, &[arrives]));
            let (now, weight) = (distance(&solutions), solutions[1].unknown_weight);
            assert!(now > last && weight > 0.0 && weight < 1.0, "{arrives}: {now} after {last}, {weight}");
            assert!(solutions[1].mean_square_rate < 1.0, "with every age known it is stable, too");
            last = now;
        }
    }
}

#[test]
fn late_ones_are_worth_less_than_those_in_time() {
    let in_time = solved(&design(BAD, &[0.9]));
    let late = solved(&design(BAD, &[0.0, 0.0, 0.9]));
    assert!(late[1].unknown_weight > in_time[1].unknown_weight);
    assert!(distance(&late) > distance(&in_time));
}

#[test]
fn what_needs_the_law_for_known_ages_keeps_it() {
    for text in [TRACKING, EVENT] {
        let [known, made] = solved(&design(text, &[0.7]));
        assert_eq!(known.law, made.law);
    }
    // What the last inputs of long sequences are worth is close to nothing, and the law for none takes minutes.
    let mut long = design(BAD, &[0.7]);
    long.set_sequence_length(25);
    let [known, made] = solved(&long);
    assert_eq!(known.law, made.law);
    // The linear estimator has a law of its own.
    let mut without = design(BAD, &[0.7]);
    without.network.acknowledgement = Acknowledgement::None;
    let [known, made] = solved(&without);
    assert_eq!(known.law, made.law);
}

#[test]
fn another_estimator_without_acknowledgements_has_gains_that_know_no_age() {
    let mut design = design(BAD, &[0.7]);
    design.network.acknowledgement = Acknowledgement::None;
    design.controller.estimator = Some(Merging::Single);
    let [known, made] = solved(&design);
    assert_eq!(made.unknown_weight, 1.0);
    assert_ne!(known.law, made.law);
}

#[test]
fn units_change_gains_by_their_factors_only() {
    let given = design(PENDULUM, &[0.5]);
    let mut scaled = given.clone();
    let input = 1e6;
    scaled.plant.b /= input;
    scaled.cost.r /= input * input;
    let (given, scaled) = (&solved(&given)[1], &solved(&scaled)[1]);
    let off = (&given.law.lx * input - &scaled.law.lx).amax() / scaled.law.lx.amax();
    assert!(off < 1e-9, "{off}");
    assert!((given.mean_square_rate - scaled.mean_square_rate).abs() < 1e-9);
}

#[test]
fn the_report_and_what_is_emitted_tell_of_the_mixture() {
    let design = design(BAD, &[0.5]);
    let mut report = Report::new(&design, Method::InFlight);
    assert_eq!(report.verdict(), Verdict::Undecided);
    let text = report.to_string();
    assert!(text.contains("35.36 % those for no acknowledgement, 64.64 % those for instant ones"), "{text}");
    assert!(report.to_json().contains("\"unknown_weight\": 0.35355339"), "{}", report.to_json());
    report.accept_undecided_stability();
    let emission = report.emission().expect("it may be written");
    assert_eq!(emission.law, &solved(&design)[1].law);
    let rust = emit(&emission, "design.toml", Format::Rust).expect("it can be written");
    assert!(rust.contains("With the state and every age known, second moments"), "{rust}");
    assert!(rust.contains("with gains made for that."), "{rust}");
}
