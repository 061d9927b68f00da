//! Figures in `docs/controllers.md` are what is found today. What controllers are is asserted in host-sim's `comparison`.

use gain_gen::{
    design::Design,
    solve::{LoopProblem, mean_square_rate},
};
use host_sim::{
    contender::{Contender, DEFAULT_DEADBAND, Kind},
    monte_carlo::{Plan, Simulate},
    output::columns::figure,
};
use slqg_tests::page::{Page, design};

const PAGE: Page = Page { name: "controllers.md", text: include_str!("../../docs/controllers.md") };

fn of_length(name: &str, length: usize) -> Design {
    let mut design = design(name);
    design.set_sequence_length(length);
    design
}

/// Mean cost with sending, as `host-sim run` prints it.
fn total_cost(kind: Kind, length: usize) -> String {
    let design = of_length("pendulum_event", length);
    let plan = Plan { runs: 200, steps: 200, seed: 1 };
    let contender = Contender::new(kind, &design, plan.steps).expect("a stabilised loop");
    let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
    figure(simulate.outcome().expect("it can be simulated").summary.mean_total_cost)
}

#[test]
fn a_long_deadband_may_cost_less_than_slqg_where_packets_are_priced() {
    PAGE.says(&format!(
        "finds {} with sending for `deadband` and {} for `slqg`, whose best is {}, with N = 7",
        total_cost(Kind::Deadband, 20),
        total_cost(Kind::Slqg, 20),
        total_cost(Kind::Slqg, 7),
    ));
    PAGE.says(&format!(
        "`--deadband DELTA`, default {DEFAULT_DEADBAND} as the thesis' DB({DEFAULT_DEADBAND})"
    ));
}

/// The rate of the double integrator on `good` under `u_m = L x_m`, `x_{m+1} = A x_m + B vbar_m`: a prediction that does not
/// reckon with the sequence it makes.
fn rate_with_what_is_in_flight_alone(length: usize) -> f64 {
    let design = of_length("double_integrator", length);
    let problem = LoopProblem::of(&design);
    let nominal = Contender::new(Kind::Nominal, &design, 1).expect("it has a law for any length");
    let mut law = nominal.laws[0].clone();
    let gain = law.lx.rows(0, 1).into_owned();
    for m in 0..length {
        law.lx.row_mut(m).copy_from(&(&gain * problem.a.pow(m as u32)));
        for earlier in 0..m.min(law.m.ncols()) {
            law.m[(m, earlier)] = (&gain * problem.a.pow((m - 1 - earlier) as u32) * &problem.b)[(0, 0)];
        }
    }
    mean_square_rate(&problem, &law.mode_gains())
}

#[test]
fn a_prediction_with_what_is_in_flight_alone_is_unstable_even_on_a_good_network() {
    assert!(rate_with_what_is_in_flight_alone(1) < 1.0);
    let rates: Vec<f64> = (2..=6).map(rate_with_what_is_in_flight_alone).collect();
    assert!(rates.iter().all(|rate| *rate > 1.0), "{rates:?}");
    PAGE.says(&format!("from `N = 2` on (rate {:.3})", rates[0]));
}
