//! Comparison controllers are what they are said to be, and none that knows as much does better than `slqg`.

use assert_cmd::Command;
use gain_gen::{
    design::{DelayDistribution, Design, Link},
    solve::{LoopProblem, mean_square_rate},
};
use host_sim::{
    closed_loop::{RunPlan, run},
    contender::{Contender, DEFAULT_DEADBAND, Kind},
    fitted::Fitted,
    monte_carlo::{Outcome, Plan, Simulate},
    sample::{mean, standard_error},
};
use serde_json::Value;
use slqg::DefaultInput;
use std::path::Path;

/// Standard errors that one value in 200 lies above the mean: a 99 % interval has as many on either side.
const NINETY_NINE: f64 = 2.576;

fn design(name: &str) -> Design {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name);
    Design::load(&path.with_extension("toml")).expect("a design")
}

fn of_length(name: &str, length: usize) -> Design {
    let mut design = design(name);
    design.set_sequence_length(length);
    design
}

fn contender(design: &Design, kind: Kind) -> Contender {
    Contender::new(kind, design, PLAN.steps).expect("a controller")
}

fn outcome_of(design: &Design, contender: &Contender, plan: Plan) -> Outcome {
    let simulate = Simulate { design, contender, plan, done: &|| () };
    simulate.outcome().expect("it can be simulated")
}

fn outcome(design: &Design, kind: Kind) -> Outcome {
    outcome_of(design, &contender(design, kind), PLAN)
}

const PLAN: Plan = Plan { runs: 300, steps: 200, seed: 1 };

/// A loop that may grow without bound costs more, whatever some runs of it say.
fn is_unstable(design: &Design, kind: Kind) -> bool {
    let law = &contender(design, kind).laws[0];
    mean_square_rate(&LoopProblem::of(design), &law.mode_gains()) >= 1.0
}

/// Of what `kind` costs more than `slqg` on the same random numbers: mean and standard error.
fn costs_more(design: &Design, kind: Kind, own: &Outcome) -> (f64, f64) {
    assert_eq!(own.summary.diverged, 0, "{}", design.name);
    let other = outcome(design, kind);
    let more: Vec<f64> = other.costs.iter().zip(&own.costs).map(|(other, own)| other - own).collect();
    (mean(&more), standard_error(&more))
}

fn is_no_better(design: &Design, kind: Kind, own: &Outcome) {
    let (mean, error) = costs_more(design, kind, own);
    let length = design.controller.sequence_length;
    assert!(
        is_unstable(design, kind) || mean >= -NINETY_NINE * error,
        "{} on {}, N = {length}, costs {mean} +- {error} more",
        kind.name(),
        design.name
    );
}

const SEQUENCES: [Kind; 5] = [Kind::Nominal, Kind::ExpectedInput, Kind::LqgLoss, Kind::Mpc, Kind::Deadband];

#[test]
fn no_controller_with_the_same_information_costs_less_than_slqg() {
    let loops = [
        ("double_integrator", 2),
        ("double_integrator_bad", 4),
        ("pendulum", 4),
        ("pendulum_bad", 5),
        ("critical_good", 4),
    ];
    for (name, length) in loops {
        let design = of_length(name, length);
        let own = outcome(&design, Kind::Slqg);
        for kind in SEQUENCES {
            is_no_better(&design, kind, &own);
        }
    }
}

#[test]
fn where_packets_fail_often_slqg_costs_less_beyond_doubt() {
    for (name, length) in [("pendulum", 1), ("pendulum_bad", 6)] {
        let design = of_length(name, length);
        let own = outcome(&design, Kind::Slqg);
        for kind in [Kind::Nominal, Kind::ExpectedInput, Kind::Mpc] {
            let (mean, error) = costs_more(&design, kind, &own);
            assert!(mean > NINETY_NINE * error, "{} on {name}: {mean} +- {error} more", kind.name());
        }
    }
}

#[test]
fn holding_what_came_last_costs_more_than_slqg_that_holds_with_as_many_inputs() {
    for name in ["double_integrator", "pendulum"] {
        let mut design = of_length(name, 1);
        design.controller.default_input = DefaultInput::Hold;
        is_no_better(&design, Kind::HoldLast, &outcome(&design, Kind::Slqg));
    }
}

/// The pendulum with nothing lost and nothing late.
fn wired(length: usize) -> Design {
    let mut design = of_length("pendulum", length);
    design.network.controller_to_actuator = Link::perfect();
    design.network.sensor_to_controller = Link::perfect();
    design
}

#[test]
fn without_a_network_to_speak_of_every_controller_is_lqg() {
    let design = wired(4);
    let lqg = outcome(&design, Kind::Lqg).costs;
    for kind in
        SEQUENCES.into_iter().chain([Kind::HoldLast, Kind::Slqg]).filter(|&kind| kind != Kind::Deadband)
    {
        for (cost, lqg) in outcome(&design, kind).costs.iter().zip(&lqg) {
            // In single precision the gains differ by their last bits.
            assert!((cost - lqg).abs() <= 1e-4 * lqg, "{}: {cost}, LQG {lqg}", kind.name());
        }
    }
}

#[test]
fn a_nominal_controller_that_is_told_the_reference_ahead_follows_it_as_well_as_slqg_without_a_network() {
    let mut design = of_length("pendulum_tracking", 5);
    design.network.controller_to_actuator = Link::perfect();
    design.network.sensor_to_controller = Link::perfect();
    let plan = Plan { runs: 5, ..PLAN };
    let [slqg, nominal, expected] = [Kind::Slqg, Kind::Nominal, Kind::ExpectedInput]
        .map(|kind| mean(&outcome_of(&design, &contender(&design, kind), plan).costs));
    assert!((nominal - slqg).abs() <= 1e-3 * slqg, "{nominal} {slqg}");
    assert!((expected - slqg).abs() <= 1e-3 * slqg, "{expected} {slqg}");
    // On a network its predicted inputs are played, with the feedforward of their own cycles.
    let late = of_length("pendulum_tracking", 5);
    let cost = |kind| mean(&outcome_of(&late, &contender(&late, kind), plan).costs);
    let (slqg, nominal) = (cost(Kind::Slqg), cost(Kind::Nominal));
    assert!(nominal < 1.02 * slqg, "{nominal} {slqg}");
}

#[test]
fn a_plan_follows_no_reference_and_says_so() {
    let error = Contender::new(Kind::Mpc, &design("pendulum_tracking"), 10).expect_err("a refusal");
    let text = error.to_string();
    assert!(text.contains("`mpc`") && text.contains("[tracking]") && text.contains("`nominal`"), "{text}");
}

#[test]
fn a_plan_without_limits_is_the_nominal_controllers_where_no_delays_occur() {
    let (design, sequence) = (wired(6), |kind, design: &Design| contender(design, kind).laws[0].clone());
    let (mpc, nominal) = (sequence(Kind::Mpc, &design), sequence(Kind::Nominal, &design));
    assert!((&mpc.lx - &nominal.lx).amax() <= 1e-9 * nominal.lx.amax(), "{} {}", mpc.lx, nominal.lx);
    assert_eq!(mpc.m.amax(), 0.0);
    assert_eq!(nominal.m.amax(), 0.0);
    // Where they do, the plan begins with what is in flight.
    let late = sequence(Kind::Mpc, &of_length("pendulum_bad", 6));
    assert_eq!((late.m[(0, 0)], late.m[(3, 3)], late.lx[(3, 0)]), (1.0, 1.0, 0.0));
}

#[test]
fn a_controller_that_counts_late_packets_as_lost_is_slqg_with_one_input_per_packet() {
    let design = of_length("pendulum", 1);
    assert_eq!(outcome(&design, Kind::LqgLoss).costs, outcome(&design, Kind::Slqg).costs);
}

/// The pendulum with control packets that arrive a cycle late, or not at all.
fn a_cycle_late(length: usize) -> Design {
    let mut design = of_length("pendulum", length);
    let delays = DelayDistribution::new(vec![0.0, 0.9]).expect("a distribution");
    design.network.controller_to_actuator = Link::independent(delays);
    design
}

#[test]
fn a_deadband_keeps_silent_while_inputs_last_and_a_wide_one_keeps_longer() {
    let design = a_cycle_late(8);
    let rate = |delta| {
        let mut contender = contender(&design, Kind::Deadband);
        contender.deadband.as_mut().expect("a rule").delta = delta;
        outcome_of(&design, &contender, PLAN).summary.send_rate
    };
    let (always, narrow, wide) = (rate(0.0), rate(DEFAULT_DEADBAND), rate(1e9));
    assert_eq!(always, 1.0, "noise changes every input");
    assert!(narrow < 0.9 && wide < narrow, "{narrow} {wide}");
    // Of eight inputs one must be left when the next packet arrives.
    assert!((wide - 1.0 / 7.0).abs() < 0.01, "{wide}");
}

#[test]
fn a_deadband_sends_always_where_packets_may_be_later_than_inputs_last() {
    let outcome = outcome(&of_length("pendulum_bad", 6), Kind::Deadband);
    assert_eq!(outcome.summary.send_rate, 1.0);
}

/// Inputs of up to 12 N push the mass that is 100 m off; LQG would take more than four times as much.
fn limited(length: usize) -> Design {
    let mut design = of_length("double_integrator", length);
    design.controller.input_limits = Some(vec![(-12.0, 7.0)]);
    design
}

#[test]
fn a_plan_within_limits_never_asks_for_more_than_the_actuator_can_do() {
    let plan = RunPlan { steps: 100, seed: 3, run: 0 };
    let extremes = |planned: &Design, built: &Design| {
        let contender = contender(planned, Kind::Mpc);
        // The actuator is built without limits, so that it applies whatever it is asked for.
        let mut fitted = Fitted::<f32, 2, 1, 2>::new(built, &contender);
        fitted.plant = Fitted::<f32, 2, 1, 2>::new(planned, &contender).plant;
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        run(&fitted, &contender, plan, |snapshot| {
            least = least.min(snapshot.input[0]);
            greatest = greatest.max(snapshot.input[0]);
        });
        (least, greatest)
    };
    let unlimited = of_length("double_integrator", 4);
    let (least, greatest) = extremes(&limited(4), &unlimited);
    assert!(least >= -12.0 && greatest <= 7.0, "{least} {greatest}");
    assert!(least == -12.0 && greatest > 6.9, "limits that do not bind prove nothing: {least} {greatest}");
    let (least, _) = extremes(&unlimited, &unlimited);
    assert!(least < -12.0, "{least}");
}

#[test]
fn a_plan_within_limits_that_do_not_bind_is_the_plan_without() {
    let mut wide = of_length("double_integrator_bad", 5);
    let plan = Plan { runs: 20, ..PLAN };
    let free = outcome_of(&wide, &contender(&wide, Kind::Mpc), plan).costs;
    wide.controller.input_limits = Some(vec![(-1e9, 1e9)]);
    let wide = outcome_of(&wide, &contender(&wide, Kind::Mpc), plan).costs;
    for (wide, free) in wide.iter().zip(&free) {
        assert!((wide - free).abs() <= 1e-3 * free, "{wide} {free}");
    }
}

#[test]
fn a_plan_that_knows_the_limits_costs_less_than_saturated_slqg_far_from_the_goal() {
    let (design, plan) = (limited(4), Plan { runs: 40, ..PLAN });
    let cost = |kind| mean(&outcome_of(&design, &contender(&design, kind), plan).costs);
    let (planned, saturated) = (cost(Kind::Mpc), cost(Kind::Slqg));
    assert!(planned < saturated, "{planned} {saturated}");
}

#[test]
fn the_deadband_is_an_option_of_the_command_line() {
    let sent = |delta: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs/critical.toml");
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        command.arg("run").arg(path).args(["--runs", "5", "--sequence-length", "8", "--json"]);
        command.args(["--controllers", "deadband", "--deadband", delta]);
        let output = command.assert().success().get_output().stdout.clone();
        let json: Value = serde_json::from_slice(&output).expect("one JSON object");
        json["results"][0]["send_rate"].as_f64().expect("a number")
    };
    let [always, seldom] = ["0", "1e9"].map(sent);
    assert!(always > 0.99 && seldom < 0.5, "{always} {seldom}");
}
