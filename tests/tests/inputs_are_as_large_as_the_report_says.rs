//! The applied inputs are as large in the mean square as the report says, with the state estimated: within the bounds, and where
//! they agree at that figure, within four standard errors.

use gain_gen::{
    design::{DelayDistribution, Design, Link},
    report::Report,
    solve::Method,
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
};
use nalgebra::DMatrix;

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const RUNS: usize = 400;
/// Cycles until the start is forgotten, and cycles that count.
const STEPS: [usize; 2] = [1000, 3000];

/// Mean of the squared input per cycle and its standard error.
fn simulated(design: &Design) -> (f64, f64) {
    let costs = STEPS.map(|steps| {
        // The design's gains, and a cost that is the square of the input.
        let contender = Contender::new(Kind::Slqg, design, steps).expect("a stabilised loop");
        let mut weighed = design.clone();
        weighed.cost.q *= 0.0;
        weighed.cost.terminal *= 0.0;
        weighed.cost.r = DMatrix::identity(1, 1);
        let plan = Plan { runs: RUNS, steps, seed: 11 };
        let simulate = Simulate { design: &weighed, contender: &contender, plan, done: &|| () };
        simulate.outcome().expect("it can be simulated").costs
    });
    let [start, all] = costs;
    let cycles = (STEPS[1] - STEPS[0]) as f64;
    let squares: Vec<f64> = start.iter().zip(&all).map(|(start, all)| (all - start) / cycles).collect();
    let mean = squares.iter().sum::<f64>() / RUNS as f64;
    let variance = squares.iter().map(|square| (square - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64;
    (mean, (variance / RUNS as f64).sqrt())
}

#[test]
fn inputs_are_as_large_as_the_report_says() {
    // Limits that no input meets.
    let text = PENDULUM.replace("[controller]", "[controller]\ninput_limits = [[-1e6, 1e6]]");
    for (name, sensor) in [
        ("as designed", &[][..]),
        ("a sensor that is wired", &[1.0]),
        ("one that is always late", &[0.0, 0.0, 1.0]),
    ] {
        let mut design = Design::parse(&text, "pendulum.toml").expect("a design");
        if !sensor.is_empty() {
            let delays = DelayDistribution::new(sensor.to_vec()).expect("a distribution");
            design.network.sensor_to_controller = Link::independent(delays);
        }
        let report = Report::new(&design, Method::InFlight);
        let input = report.applied.as_ref().expect("limits")[0];
        let (lower, upper) = input.rms_estimated.expect("acknowledgements are instant");
        let (square, error) = simulated(&design);
        eprintln!(
            "{name}: {square:.6} +- {error:.6}, {:.6} to {:.6}, state known {:.6}",
            lower * lower,
            upper * upper,
            input.rms.powi(2)
        );
        assert!(square > lower * lower - 4.0 * error, "{name}: {square} {lower}");
        assert!(square < upper * upper + 4.0 * error, "{name}: {square} {upper}");
        assert!(error < 0.02 * square, "{name}: {error}");
        // The state known is far from it.
        assert!(square > input.rms.powi(2) + 10.0 * error, "{name}: {square} {}", input.rms);
    }
}
