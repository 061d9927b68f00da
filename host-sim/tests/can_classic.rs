//! On classic CAN the simulated controller rounds its inputs, at the cost that the report estimates; without a network nothing
//! is rounded.

use gain_gen::design::{Design, ValueLimits, WireSettings};
use gain_gen::report::Report;
use gain_gen::solve::Method;
use host_sim::contender::{Contender, Kind};
use host_sim::monte_carlo::{Plan, Simulate};
use host_sim::sample::{mean, standard_error};
use host_sim::size_class::{TooLarge, check};
use slqg::wire::can::{LARGEST_COUNT, LARGEST_OF_FULL_FRAME};

const PLAN: Plan = Plan { runs: 100, steps: 200, seed: 1 };
/// In the unit of the input, N: coarse enough for its cost to be seen.
const STEP: f64 = 1.5;

/// The double integrator, with sequences of three inputs.
fn integrator() -> Design {
    let text = include_str!("../../designs/double_integrator.toml");
    Design::parse(&text.replace("sequence_length = 4", "sequence_length = 3"), "double_integrator.toml")
        .unwrap()
}

fn coarse() -> Design {
    let inputs = vec![STEP * f64::from(LARGEST_OF_FULL_FRAME)];
    let limits = ValueLimits { inputs, outputs: vec![f64::from(LARGEST_COUNT)] };
    let mut design = Design { wire: WireSettings::CanClassic(limits), ..integrator() };
    design.network.acknowledged_cycles = 5;
    design
}

fn costs(design: &Design, kind: Kind) -> Vec<f64> {
    let contender = Contender::new(kind, design, PLAN.steps).unwrap();
    let simulate = Simulate { design, contender: &contender, plan: PLAN, done: &|| () };
    simulate.outcome().unwrap().costs
}

#[test]
fn rounding_costs_what_the_report_estimates() {
    let (plain, rounded) = (costs(&integrator(), Kind::Slqg), costs(&coarse(), Kind::Slqg));
    let differences: Vec<_> = plain.iter().zip(&rounded).map(|(plain, rounded)| rounded - plain).collect();
    let (found, error) = (mean(&differences), standard_error(&differences));
    let estimate =
        PLAN.steps as f64 * Report::new(&coarse(), Method::InFlight).rounding_cost().expect("it converges");
    assert!(found > 10.0 * error, "{found} +- {error}");
    assert!((found / estimate - 1.0).abs() < 0.15, "{found} +- {error}, estimated {estimate}");
}

#[test]
fn at_the_plant_nothing_is_rounded() {
    assert_eq!(costs(&integrator(), Kind::Lqg), costs(&coarse(), Kind::Lqg));
}

#[test]
fn sequences_that_do_not_fit_a_classic_frame_are_refused() {
    let mut design = coarse();
    assert_eq!(check(&design), Ok(()));
    design.set_sequence_length(4);
    let Err(TooLarge::Frames(misfit)) = check(&design) else { panic!("accepted") };
    assert_eq!(misfit.key, "controller.sequence_length");
}
