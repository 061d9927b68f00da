//! Designs that are correct: the examples in `designs/`, and what the reader makes of keys that may be left out.
//! `[tracking]` is in `design_tracking.rs`.

use gain_gen::design::{
    Acknowledgement, DelayDistribution, Design, DeviceScalar, Event, Goal, Interpolation, Link, Preview,
    Trajectory,
};
use nalgebra::DMatrix;
use slqg::DefaultInput;
use slqg::estimator::Merging;
use std::path::{Path, PathBuf};

const GOOD: [f64; 11] = [
    0.7,
    0.140134919,
    0.0535446853,
    0.0303992054,
    0.0203321882,
    0.0148805662,
    0.0115298891,
    0.00929256176,
    0.007708502,
    0.00653690849,
    0.00564057433,
];
const BAD: [f64; 10] = [
    0.0164479102,
    0.106100205,
    0.155474601,
    0.152459958,
    0.129475394,
    0.103967037,
    0.0818026106,
    0.0640816745,
    0.0503561519,
    0.0398344581,
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs")
}

fn example(name: &str) -> Design {
    Design::load(&folder().join(name).with_extension("toml")).unwrap_or_else(|error| panic!("{error}"))
}

fn link(probabilities: &[f64]) -> Link {
    Link::independent(DelayDistribution::new(probabilities.to_vec()).unwrap())
}

#[test]
fn every_example_loads_and_bears_the_name_of_its_file() {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        assert_eq!(example(&name).name, name);
        names.push(name);
    }
    names.sort();
    let expected = [
        "critical",
        "critical_bad",
        "critical_good",
        "double_integrator",
        "double_integrator_bad",
        "double_integrator_bursty",
        "drive_event",
        "drive_event_bad",
        "drive_tracking",
        "drive_tracking_bad",
        "pendulum",
        "pendulum_bad",
        "pendulum_can",
        "pendulum_event",
        "pendulum_event_bad",
        "pendulum_tracking",
        "pendulum_tracking_bad",
    ];
    assert_eq!(names, expected);
}

#[test]
fn variants_of_a_plant_differ_only_in_name_network_and_sequence_length() {
    for (base, variants) in [
        ("double_integrator", &["double_integrator_bad"][..]),
        ("critical", &["critical_good", "critical_bad"]),
        ("pendulum", &["pendulum_bad"]),
        ("drive_event", &["drive_event_bad"]),
        ("drive_tracking", &["drive_tracking_bad"]),
        ("pendulum_event", &["pendulum_event_bad"]),
        ("pendulum_tracking", &["pendulum_tracking_bad"]),
    ] {
        let base = example(base);
        for variant in variants {
            let mut variant = example(variant);
            assert_ne!(variant.network, base.network);
            variant.name.clone_from(&base.name);
            variant.network = base.network.clone();
            variant.controller.sequence_length = base.controller.sequence_length;
            // How long silences are follows from the network.
            variant.safety.stale_after = base.safety.stale_after;
            variant.safety.lost_after = base.safety.lost_after;
            assert_eq!(variant, base);
        }
    }
}

#[test]
fn examples_use_the_good_and_the_bad_network_on_both_links() {
    let good = [
        "double_integrator",
        "critical_good",
        "pendulum",
        "drive_event",
        "drive_tracking",
        "pendulum_event",
        "pendulum_tracking",
    ];
    let bad = [
        "double_integrator_bad",
        "critical_bad",
        "pendulum_bad",
        "drive_event_bad",
        "drive_tracking_bad",
        "pendulum_event_bad",
        "pendulum_tracking_bad",
    ];
    for (names, figures) in [(good, &GOOD[..]), (bad, &BAD)] {
        for name in names {
            let network = example(name).network;
            assert_eq!(network.controller_to_actuator, link(figures), "{name}");
            assert_eq!(network.sensor_to_controller, link(figures), "{name}");
            assert_eq!(network.acknowledgement, Acknowledgement::Instant, "{name}");
        }
    }
    let critical = example("critical").network;
    assert_eq!(critical.controller_to_actuator, link(&[0.25; 4]));
    assert_eq!(critical.sensor_to_controller, link(&[1.0]));
}

#[test]
fn packets_too_late_for_the_sequence_are_rare_enough_to_stabilise_each_example() {
    // Thesis, theorem 3.4 b): necessary is (1 - Q(N-1)) |lambda|^2 < 1; stay well below.
    for (name, fastest) in
        [("critical", 1.5), ("critical_good", 1.5), ("critical_bad", 1.5), ("pendulum_bad", 1.16)]
    {
        let design = example(name);
        let arrival =
            design.network.controller_to_actuator.delays.arrival(design.controller.sequence_length - 1);
        assert!((1.0 - arrival) * fastest * fastest < 0.5, "{name}");
    }
}

#[test]
fn pendulum_from_physical_parameters_is_the_reference_model() {
    #[rustfmt::skip]
    let a = DMatrix::from_row_slice(4, 4, &[
        1.0, 0.019964226030016838, 0.0015497660597569751, 1.0327742423524654e-05,
        0.0, 0.9964220186354583, 0.15515091450707658, 0.0015497660597569751,
        0.0, -0.00010531879441093952, 1.0103386588933287, 0.020068886036273385,
        0.0, -0.010543725076933508, 1.0353726074203486, 1.0103386588933287,
    ]);
    let b = [0.0003577396998316436, 0.03577981364541711, 0.001053187944109395, 0.10543725076933508];
    let plant = example("pendulum").plant;
    assert!((plant.a - a).amax() < 1e-12);
    assert!((plant.b - DMatrix::from_column_slice(4, 1, &b)).amax() < 1e-12);
    let angle = (0.2 * std::f64::consts::PI / 360.0).powi(2);
    assert!((plant.process_noise[(2, 2)] - angle).abs() < 1e-20);
    assert!((plant.measurement_noise[(1, 1)] - angle).abs() < 1e-20);
}

#[test]
fn double_integrator_is_read_as_written() {
    let design = example("double_integrator");
    let plant = &design.plant;
    assert_eq!((plant.states(), plant.inputs(), plant.outputs()), (2, 1, 1));
    assert_eq!(plant.a, DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0]));
    assert_eq!(plant.b.as_slice(), [0.0, 1.0]);
    assert_eq!(plant.c.as_slice(), [1.0, 0.0]);
    assert_eq!(plant.initial_mean.as_slice(), [100.0, 0.0]);
    assert_eq!(plant.initial_covariance, DMatrix::identity(2, 2) * 0.25);
    assert_eq!(plant.process_noise, DMatrix::identity(2, 2) * 0.01);
    assert_eq!(plant.measurement_noise[0], 0.04);
    assert_eq!((design.cost.q, design.cost.r[0]), (DMatrix::identity(2, 2), 1.0));
    let settings = design.controller;
    assert_eq!((settings.sequence_length, settings.measurement_buffer), (4, 11));
    assert_eq!((settings.default_input, settings.scalar), (DefaultInput::Zero, DeviceScalar::F32));
    assert_eq!(settings.input_limits, None);
}

/// As short as a design can be; numbers without a point.
const SHORT: &str = r#"
name = "tank"
plant = { sample_time = 1, discrete = { a = [[1]], b = [[1]] }, c = [[1]], process_noise = [[1]], measurement_noise = [[1]], initial_mean = [0], initial_covariance = [[0]] }
cost = { q = [[1]], r = [[1]] }
network.controller_to_actuator.delays = [1]
network.sensor_to_controller.delays = [0.5, 0, 0.25, 0]
controller.sequence_length = 0x2
"#;

#[test]
fn keys_left_out_take_their_defaults() {
    let design = Design::parse(SHORT, "tank").unwrap();
    assert_eq!(design.network.acknowledgement, Acknowledgement::Instant);
    assert_eq!(design.network.acknowledged_cycles, 8);
    let settings = design.controller;
    assert_eq!(settings.default_input, DefaultInput::Zero);
    assert_eq!(settings.scalar, DeviceScalar::F32);
    assert_eq!(settings.input_limits, None);
    // Thesis (3.34): the largest delay that occurs on the way of the measurements.
    assert_eq!((settings.sequence_length, settings.measurement_buffer), (2, 2));
    assert_eq!(settings.estimator, None);
    assert_eq!((design.tracking, design.event), (None, None));
}

#[test]
fn keys_given_replace_the_defaults() {
    let text = SHORT.to_string()
        + r#"
controller.default_input = "hold"
controller.scalar = "f64"
controller.measurement_buffer = 0
controller.input_limits = [[-1, 2.5]]
controller.estimator = "gpb2"
network.acknowledgement.delays = [0.25, 0.5]
network.acknowledged_cycles = 1
"#;
    let design = Design::parse(&text, "tank").unwrap();
    assert_eq!(design.network.acknowledgement, Acknowledgement::Over(link(&[0.25, 0.5])));
    assert_eq!(design.network.acknowledged_cycles, 1);
    let settings = design.controller;
    assert_eq!(settings.estimator, Some(Merging::Gpb2));
    assert_eq!((settings.default_input, settings.scalar), (DefaultInput::Hold, DeviceScalar::F64));
    assert_eq!((settings.measurement_buffer, settings.input_limits), (0, Some(vec![(-1.0, 2.5)])));
    let never = format!("{SHORT}network.acknowledgement = \"none\"");
    assert_eq!(Design::parse(&never, "tank").unwrap().network.acknowledgement, Acknowledgement::None);
}

#[test]
fn ages_are_kept_apart_where_the_design_says_so() {
    for (acknowledgement, usual) in [
        ("\"instant\"", Merging::Single),
        ("{ delays = [1] }", Merging::Single),
        ("\"none\"", Merging::Linear),
    ] {
        let text = format!("{SHORT}network.acknowledgement = {acknowledgement}\n");
        let estimator = |text: &str| Design::parse(text, "tank").unwrap().estimator();
        assert_eq!(estimator(&text), usual);
        for (word, merging) in [("single", Merging::Single), ("imm", Merging::Imm), ("gpb2", Merging::Gpb2)] {
            let given = estimator(&format!("{text}controller.estimator = \"{word}\""));
            assert_eq!(given, merging, "{acknowledgement}");
        }
    }
}

#[test]
fn the_linear_estimator_goes_without_acknowledgements_only() {
    let linear = "controller.estimator = \"linear\"\n";
    for (more, found) in [
        ("", "found \"linear\" beside acknowledgements; it takes no notice of them"),
        ("network.acknowledgement = \"none\"\nevent.send_cost = 1\n", "found \"linear\" beside [event]"),
        (
            "network.acknowledgement = \"none\"\ntracking = { z = [[1]] }\n",
            "found \"linear\" beside [tracking]",
        ),
    ] {
        let error = Design::parse(&format!("{SHORT}{linear}{more}"), "tank").expect_err("it does not go");
        assert!(error.to_string().contains(found), "{error}");
    }
}

#[test]
fn the_history_reaches_back_to_the_latest_measurement_and_acknowledgement() {
    for (buffer, acknowledgement, history) in [
        (0, "\"instant\"", 2),
        (3, "\"instant\"", 4),
        (3, "\"none\"", 4),
        // Eight cycles are told, delay 0 being about the one before the current one.
        (0, "{ delays = [1] }", 9),
        (0, "{ delays = [0.5, 0, 0.25, 0] }", 11),
        (10, "{ delays = [0.5, 0, 0.25, 0] }", 11),
        (11, "{ delays = [0.5, 0, 0.25, 0] }", 12),
    ] {
        let text = format!(
            "{SHORT}controller.measurement_buffer = {buffer}\nnetwork.acknowledgement = {acknowledgement}"
        );
        let design = Design::parse(&text, "tank").unwrap();
        assert_eq!(design.history(), history, "{buffer} {acknowledgement}");
    }
}

#[test]
fn rounding_in_a_mirrored_entry_is_evened_out() {
    let text = SHORT
        .replace("a = [[1]], b = [[1]]", "a = [[1, 0], [0, 1]], b = [[1, 0], [0, 1]]")
        .replace("c = [[1]]", "c = [[1, 0], [0, 1]]")
        .replace("process_noise = [[1]]", "process_noise = [[1, 0.5], [0.5000000000001, 1]]")
        .replace("measurement_noise = [[1]]", "measurement_noise = [[1, 0], [0, 1e-12]]")
        .replace("initial_mean = [0]", "initial_mean = [0, 0]")
        .replace("initial_covariance = [[0]]", "initial_covariance = [[1, 1], [1, 1]]")
        .replace("q = [[1]], r = [[1]]", "q = [[1, 0], [0, 1]], r = [[1, 0], [0, 1]]");
    let plant = Design::parse(&text, "tank").unwrap().plant;
    assert_eq!(plant.process_noise, plant.process_noise.transpose());
    assert_eq!(plant.measurement_noise[(1, 1)], 1e-12);
}

#[test]
fn mirrored_entries_are_compared_in_the_units_of_their_diagonal() {
    let text = |noise: &str| {
        SHORT
            .replace("a = [[1]], b = [[1]]", "a = [[0.5, 0], [0, 0.25]], b = [[1], [1]]")
            .replace("c = [[1]]", "c = [[1, 0], [0, 1]]")
            .replace("process_noise = [[1]]", &format!("process_noise = {noise}"))
            .replace("measurement_noise = [[1]]", "measurement_noise = [[1, 0], [0, 1]]")
            .replace("initial_mean = [0]", "initial_mean = [0, 0]")
            .replace("initial_covariance = [[0]]", "initial_covariance = [[1, 0], [0, 1]]")
            .replace("q = [[1]]", "q = [[1, 0], [0, 1]]")
    };
    // Nanometres beside kilometres: a correlation of 0.3 in one place, of 0.5 in the other.
    for units in [[1.0, 1.0], [1e-9, 1e3], [1e9, 1e9], [1e-9, 1e-9]] {
        let [one, other] = units;
        let noise = |mirrored: f64| {
            let (above, below) = (0.5 * one * other, mirrored * one * other);
            format!("[[{:e}, {above:e}], [{below:e}, {:e}]]", one * one, other * other)
        };
        let refused = Design::parse(&text(&noise(0.3)), "tank").unwrap_err();
        assert!(refused.to_string().contains("in the mirrored place"), "{units:?}: {refused}");
        Design::parse(&text(&noise(0.5 + 1e-12)), "tank").unwrap();
    }
}

#[test]
fn an_event_triggered_pendulum_is_the_pendulum_with_a_price_of_packets() {
    let (mut event, pendulum) = (example("pendulum_event"), example("pendulum"));
    assert_eq!(event.event.take(), Some(Event::at(1000.0)));
    assert_eq!(event.controller.sequence_length, 8);
    event.name.clone_from(&pendulum.name);
    event.controller.sequence_length = pendulum.controller.sequence_length;
    assert_eq!(event, pendulum);
    assert_eq!(
        Design::parse(&format!("{SHORT}event.send_cost = 0"), "tank").unwrap().event,
        Some(Event::at(0.0))
    );
}

#[test]
fn the_drive_follows_from_its_physical_parameters() {
    let (torque_constant, efficiency, per_metre) = (0.0302, 0.9, 2.0 * std::f64::consts::PI / 0.01);
    let mass = 20.0 + (142.0 + 80.0) * 1e-7 * per_metre * per_metre;
    let force = efficiency * torque_constant * per_metre;
    let (friction, lag, cycle) = (20.0_f64, 0.002, 0.005_f64);
    let plant = example("drive_tracking").plant;
    assert_eq!((plant.states(), plant.inputs(), plant.outputs()), (3, 1, 1));
    assert!((plant.a[(1, 1)] - (-friction / mass * cycle).exp()).abs() < 1e-12);
    assert!((plant.a[(2, 2)] - (-cycle / lag).exp()).abs() < 1e-12);
    // With the current held for ever the velocity settles where friction balances the force; in mm/s.
    let velocity = (plant.a[(1, 2)] * 1.0 + plant.b[1]) / (1.0 - plant.a[(1, 1)]);
    assert!((velocity / (1000.0 * force / friction) - 1.0).abs() < 1e-9, "{velocity}");
    // The force that disturbs, held over a cycle.
    let disturbed = 4.6 / mass * 1000.0 * cycle;
    assert!((plant.process_noise[(1, 1)].sqrt() / disturbed - 1.0).abs() < 0.01);
}

#[test]
fn the_drive_goes_there_and_back() {
    let design = example("drive_tracking");
    let tracking = design.tracking.as_ref().unwrap();
    assert_eq!((tracking.outputs(), &tracking.z), (1, &DMatrix::from_row_slice(1, 3, &[1.0, 0.0, 0.0])));
    let Goal::Trajectory(Trajectory { preview, reference: Some(reference) }) = &tracking.goal else {
        panic!("{:?}", tracking.goal)
    };
    assert_eq!(*preview, Preview::Auto { tolerance: 1e-3 });
    assert_eq!((reference.points.len(), reference.interpolation), (5, Interpolation::Linear));
    for (cycle, position) in
        [(0, 0.0), (50, 0.0), (100, 50.0), (150, 100.0), (250, 100.0), (350, 0.0), (9999, 0.0)]
    {
        let wanted = tracking.reference(cycle, design.plant.sample_time).unwrap();
        assert!((wanted[0] - position).abs() < 1e-9, "{cycle}: {wanted}");
    }
    // The weight of the state is that of the position.
    let only = DMatrix::from_fn(3, 3, |i, j| if (i, j) == (0, 0) { 4.0 } else { 0.0 });
    assert_eq!((&design.cost.q, &design.cost.terminal), (&only, &only));
}
