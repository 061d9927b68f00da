//! Over a channel that comes and goes, gains that know its state cost least, by as much as closed form and simulation say,
//! and the device computes them in the same form as any others.

use gain_gen::{
    design::{Design, Link, MarkovLink},
    solve::{Knowledge, LoopProblem, Method, correlated, solve, solve_channel},
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    sample::{mean, standard_error},
};
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slqg::DefaultInput;

fn bursty() -> Design {
    let text = include_str!("../../designs/double_integrator_bursty.toml");
    Design::parse(text, "double_integrator_bursty.toml").expect("a design")
}

fn channel(design: &Design) -> &MarkovLink {
    design.network.controller_to_actuator.channel().expect("a channel")
}

/// Delay probabilities over up to four cycles, some of them without an arrival in the first.
fn delays(random: &mut ChaCha8Rng) -> Vec<f64> {
    let weights: Vec<f64> = (0..4).map(|_| random.random_range(0.0..1.0)).collect();
    let whole: f64 = weights.iter().sum::<f64>() + random.random_range(0.0..1.0);
    let starts_late = random.random_bool(0.2);
    weights.iter().enumerate().map(|(at, w)| if at == 0 && starts_late { 0.0 } else { w / whole }).collect()
}

#[test]
fn the_in_flight_recursion_over_a_channel_finds_the_gains_of_all_modes() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let (mut agreed, mut worst) = (0, 0.0_f64);
    for case in 0..40 {
        let (nx, nu) = (random.random_range(1..=3), random.random_range(1..=2));
        let states = random.random_range(1..=3);
        let length = random.random_range(1..=if states == 3 { 3 } else { 4 });
        let mut entry = |_, _| random.random_range(-1.0..1.0);
        let (a, b) = (DMatrix::from_fn(nx, nx, &mut entry) * 0.9, DMatrix::from_fn(nx, nu, &mut entry));
        let transitions: Vec<Vec<f64>> = (0..states)
            .map(|_| {
                let row: Vec<f64> = (0..states).map(|_| random.random_range(0.05..1.0)).collect();
                row.iter().map(|p| p / row.iter().sum::<f64>()).collect()
            })
            .collect();
        let all = (0..states).map(|_| delays(&mut random)).collect();
        let channel = MarkovLink::new(transitions, all).expect("a channel");
        let problem = LoopProblem {
            q: DMatrix::identity(nx, nx),
            r: DMatrix::identity(nu, nu),
            link: channel.average().clone(),
            length,
            default_input: if case % 2 == 0 { DefaultInput::Zero } else { DefaultInput::Hold },
            a,
            b,
        };
        let designs = correlated(&problem, &channel, &DMatrix::identity(nx, nx)).expect("few modes");
        let Some(known) = designs.with(Knowledge::Channel) else { continue };
        let in_flight = solve_channel(&problem, &channel);
        let spelled = in_flight.law.mode_gains(&designs.chain);
        let difference = spelled.iter().zip(&known.gains).map(|(found, gain)| (found - gain).amax());
        let largest = known.gains.iter().map(|gain| gain.amax()).fold(0.0, f64::max);
        let difference = difference.fold(0.0, f64::max) / largest;
        worst = worst.max(difference);
        let noise = DMatrix::identity(nx, nx);
        let costs = (in_flight.control_cost(&noise), known.control_cost);
        assert!((costs.0 / costs.1 - 1.0).abs() < 1e-9, "case {case}: costs {costs:?}");
        let rates = (in_flight.mean_square_rate, known.mean_square_rate);
        assert!((rates.0 - rates.1).abs() < 1e-6, "case {case}: rates {rates:?}");
        agreed += 1;
        assert!(difference < 1e-9, "case {case}: {difference:e} for {states} states, N = {length}");
        let cost = |knowledge| designs.with(knowledge).map_or(f64::INFINITY, |design| design.control_cost);
        let least = cost(Knowledge::Channel) * (1.0 - 1e-9);
        assert!(cost(Knowledge::Ages) >= least && cost(Knowledge::Average) >= least, "case {case}");
    }
    eprintln!("{agreed} designs agree, largest relative difference {worst:e}");
    assert!(agreed >= 30, "{agreed}");
}

#[test]
fn a_channel_whose_states_are_alike_has_the_gains_of_independent_packets() {
    let mut design = bursty();
    let delays = vec![0.6, 0.2, 0.1];
    let alike = MarkovLink::gilbert_elliott(0.1, 0.3, delays.clone(), delays).expect("a channel");
    design.network.controller_to_actuator = Link::markov(alike.clone());
    let problem = LoopProblem::of(&design);
    let designs = correlated(&problem, &alike, &design.plant.process_noise).expect("few modes");
    let known = designs.with(Knowledge::Channel).expect("a stabilised loop");
    let law = solve_channel(&problem, &alike).law;
    let independent = solve(&problem, Method::InFlight);
    for state in 0..2 {
        let difference = (law.at(&[state]).lx - &independent.law.lx).amax();
        assert!(difference < 1e-10, "state {state}: {difference:e}");
    }
    let cost = independent.control_cost(&design.plant.process_noise);
    assert!((known.control_cost / cost - 1.0).abs() < 1e-9, "{} against {cost}", known.control_cost);
}

#[test]
fn the_simulated_loop_costs_what_the_chain_of_modes_says() {
    // With the state measured nothing but the channel and the noise is random.
    let mut design = bursty();
    design.network.sensor_to_controller = Link::perfect();
    design.plant.c = DMatrix::identity(2, 2);
    design.plant.measurement_noise = DMatrix::identity(2, 2) * 1e-9;
    design.controller.scalar = gain_gen::design::DeviceScalar::F64;
    design.set_sequence_length(2);
    // Not so bad that single runs outweigh the others.
    let mild = MarkovLink::gilbert_elliott(0.1, 0.4, vec![0.9, 0.1], vec![0.2, 0.2, 0.2]).expect("a channel");
    design.network.controller_to_actuator = Link::markov(mild);
    let designs = correlated(&LoopProblem::of(&design), channel(&design), &design.plant.process_noise);
    let designs = designs.expect("few modes");
    for (kind, knowledge) in [(Kind::Slqg, Knowledge::Average), (Kind::SlqgChannel, Knowledge::Channel)] {
        let expected = designs.with(knowledge).expect("a stabilised loop").control_cost;
        let contender = Contender::new(kind, &design, 0).expect("a stabilised loop");
        let costs = |steps| {
            let plan = Plan { runs: 2000, steps, seed: 7 };
            let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
            simulate.outcome().expect("it can be simulated").costs
        };
        // The same seed gives long runs the short ones' beginning: their difference is the cost in steady state.
        let (early, late) = (costs(100), costs(500));
        let found: Vec<f64> = early.iter().zip(&late).map(|(early, late)| (late - early) / 400.0).collect();
        let (mean, error) = (mean(&found), standard_error(&found));
        eprintln!("{}: {mean:.4} +- {error:.4} simulated, {expected:.4} in closed form", kind.name());
        assert!((mean - expected).abs() <= 4.0 * error, "{}: {mean} +- {error}, {expected}", kind.name());
        assert!(error < 0.05 * expected, "too few runs to tell: {error}");
    }
}
