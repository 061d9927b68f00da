//! A loop that the report calls stable within its input limits stays bounded in simulation, though its inputs lie at a limit most of
//! the time: the mean square of the second half of a long run is like that of the first.

use gain_gen::{
    design::Design,
    report::{LimitsShown, Report, Verdict},
    solve::Method,
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
};

const RUNS: usize = 100;
const STEPS: usize = 40_000;

fn design(hold: bool) -> Design {
    let default = if hold { "hold" } else { "zero" };
    let text = format!(
        "name = \"axis\"
        plant = {{ sample_time = 0.1, discrete = {{ a = [[1, 0.1], [0, 0.8]], b = [[0], [1]] }}, c = [[1, 0]], process_noise = \
         [[0.01, 0], [0, 0.01]], measurement_noise = [[0.01]], initial_mean = [20, 0], initial_covariance = [[0, 0], [0, 0]] }}
        cost = {{ q = [[1, 0], [0, 1]], r = [[0.1]] }}
        network = {{ controller_to_actuator.delays = [0.5, 0.2], sensor_to_controller.delays = [0.5, 0.2] }}
        controller = {{ sequence_length = 3, default_input = \"{default}\", input_limits = [[-0.05, 0.06]] }}"
    );
    Design::parse(&text, "axis.toml").expect("a design")
}

#[test]
fn an_integrator_with_limits_stays_bounded() {
    for hold in [false, true] {
        let design = design(hold);
        let report = Report::new(&design, Method::InFlight);
        assert_eq!(report.verdict(), Verdict::Stable, "{:?}", report.failed_conditions);
        assert_eq!(report.limits_shown_by(), Some(LimitsShown::Drift));
        let applied = report.applied.as_ref().expect("limits")[0];
        assert!(applied.limit_distance_estimated < Some(0.6), "{applied:?}");
        let cost = |steps: usize| {
            let contender = Contender::new(Kind::Slqg, &design, steps).expect("a stabilised loop");
            let plan = Plan { runs: RUNS, steps, seed: 3 };
            let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
            let summary = simulate.outcome().expect("it can be simulated").summary;
            assert_eq!(summary.diverged, 0);
            summary.mean_cost.expect("no run diverged")
        };
        let (first, both) = (cost(STEPS / 2), cost(STEPS));
        assert!(both - first < 1.2 * first, "{hold}: {first}, {} in the second half", both - first);
    }
}
