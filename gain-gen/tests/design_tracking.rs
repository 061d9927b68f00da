//! What the reader makes of `[tracking]`: weights, previews, references and set points that are correct. Wrong ones are in
//! `design_errors.rs`.

use gain_gen::design::{Design, Event, Goal, Preview, SetPoint, Tracking, Trajectory};
use nalgebra::{DMatrix, DVector};
use slqg::DefaultInput;

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");

fn parsed(text: &str) -> Design {
    Design::parse(text, "test").unwrap_or_else(|error| panic!("{error}"))
}
/// Two tanks in a row, each with an inflow of its own; what the second loses is gone.
const TANKS: &str = r#"
name = "tanks"
plant = { sample_time = 1, discrete = { a = [[0.9, 0], [0.1, 0.8]], b = [[1, 0], [0, 1]] }, c = [[1, 0], [0, 1]], process_noise = [[1, 0], [0, 1]], measurement_noise = [[1, 0], [0, 1]], initial_mean = [0, 0], initial_covariance = [[0, 0], [0, 0]] }
network.controller_to_actuator.delays = [1]
network.sensor_to_controller.delays = [1]
controller.sequence_length = 2
"#;

fn tanks(rest: &str) -> Design {
    parsed(&format!("{TANKS}{rest}"))
}

fn tracking(design: &Design) -> &Tracking {
    design.tracking.as_ref().expect("a design that tracks")
}

#[test]
fn with_tracking_the_cost_weighs_the_error_and_the_state_through_it() {
    let rest = "tracking.z = [[1, 1], [0, 3]]
        cost = { q = [[2, 0.5], [0.5, 1]], r = [[1, 0], [0, 1]] }";
    let design = tanks(rest);
    let weight = DMatrix::from_row_slice(2, 2, &[2.0, 0.5, 0.5, 1.0]);
    let of_state = DMatrix::from_row_slice(2, 2, &[2.0, 3.5, 3.5, 14.0]);
    assert_eq!((&tracking(&design).weight, &tracking(&design).terminal_weight), (&weight, &weight));
    assert_eq!((&design.cost.q, &design.cost.terminal), (&of_state, &of_state));

    let design = tanks(&rest.replace("r =", "terminal = [[1, 0], [0, 0]], r ="));
    assert_eq!(tracking(&design).weight, weight);
    assert_eq!(tracking(&design).terminal_weight, DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.0]));
    assert_eq!(design.cost.terminal, DMatrix::repeat(2, 2, 1.0));
}

#[test]
fn weights_through_awkward_outputs_are_exactly_symmetric() {
    let design = tanks(
        "tracking.z = [[0.1, 0.7], [0.3, 1e3]]
        cost = { q = [[0.2, 0.03], [0.03, 0.9]], r = [[1, 0], [0, 1]] }",
    );
    assert_eq!(design.cost.q, design.cost.q.transpose());
}

const LEVEL: &str = "cost = { q = [[1]], r = [[1, 0], [0, 4]] }\ntracking.z = [[0, 1]]\n";

#[test]
fn keys_of_tracking_left_out_take_their_defaults() {
    let design = tanks(LEVEL);
    let expected = Trajectory { preview: Preview::Auto { tolerance: 1e-3 }, reference: None };
    assert_eq!(tracking(&design).goal, Goal::Trajectory(expected));
    assert_eq!(tracking(&design).reference(7, 1.0), None);

    let design = tanks(&format!("{LEVEL}tracking.reference = [[0, 1], [5, 2]]"));
    let at = |cycle| tracking(&design).reference(cycle, 1.0).unwrap()[0];
    assert_eq!([0, 4, 5, 6].map(at), [1.0, 1.0, 2.0, 2.0]);
}

#[test]
fn keys_of_tracking_given_replace_the_defaults() {
    let preview = |keys: &str| match &tracking(&tanks(&format!("{LEVEL}{keys}"))).goal {
        Goal::Trajectory(trajectory) => trajectory.preview,
        Goal::SetPoint(_) => panic!("a trajectory"),
    };
    assert_eq!(preview("tracking.preview = 30"), Preview::Cycles(30));
    assert_eq!(preview("tracking.preview = \"auto\""), Preview::Auto { tolerance: 1e-3 });
    assert_eq!(preview("tracking.preview_tolerance = 0.05"), Preview::Auto { tolerance: 0.05 });
    let linear = "tracking.reference = [[0, 1], [5, 2]]\ntracking.interpolation = \"linear\"";
    let design = tanks(&format!("{LEVEL}{linear}"));
    assert!((tracking(&design).reference(2, 1.0).unwrap()[0] - 1.4).abs() < 1e-12);
}

#[test]
fn tracking_events_and_hold_go_together() {
    let design = tanks(&format!(
        "{LEVEL}tracking.set_point = [3]\nevent.send_cost = 2.5\ncontroller.default_input = \"hold\""
    ));
    assert_eq!((design.event, design.controller.default_input), (Some(Event::at(2.5)), DefaultInput::Hold));
    assert!(matches!(tracking(&design).goal, Goal::SetPoint(_)));
}

fn set_point(design: &Design) -> &SetPoint {
    match &tracking(design).goal {
        Goal::SetPoint(set_point) => set_point,
        Goal::Trajectory(_) => panic!("a set point"),
    }
}

#[test]
fn of_all_inputs_that_hold_a_set_point_the_cheapest_is_taken() {
    // Level 2 takes 0.2 z per cycle, from the inflows u1 + u2; the second costs four times as much.
    let design = tanks(&format!("{LEVEL}tracking.set_point = [10]"));
    let SetPoint { value, input } = set_point(&design);
    assert_eq!(*value, DVector::repeat(1, 10.0));
    assert_eq!(tracking(&design).reference(99, 1.0), Some(value.clone()));
    let u = input * value;
    assert!((u - DVector::from_vec(vec![1.6, 0.4])).amax() < 1e-12, "{input}");
}

#[test]
fn a_set_point_for_as_many_outputs_as_inputs_is_held_by_one_input() {
    let cost = "cost = { q = [[1, 0], [0, 1]], r = [[1, 0], [0, 4]] }";
    let design = tanks(&format!("{cost}\ntracking = {{ z = [[1, 0], [0, 1]], set_point = [2, 5] }}"));
    let SetPoint { value, input } = set_point(&design);
    let expected = DMatrix::from_row_slice(2, 2, &[0.1, 0.0, -0.1, 0.2]);
    assert!((input - expected).amax() < 1e-12, "{input}");
    let (a, b) = (&design.plant.a, &design.plant.b);
    assert!((a * value + b * input * value - value).amax() < 1e-12);
}

#[test]
fn a_pendulum_is_held_anywhere_by_no_input() {
    let q = PENDULUM.find("q = [").unwrap()..PENDULUM.find("r = [[1]]").unwrap();
    let text = PENDULUM.replace(&PENDULUM[q], "q = [[1]]\n");
    let design = parsed(&format!("{text}[tracking]\nz = [[1, 0, 0, 0]]\nset_point = [0.5]"));
    assert!(set_point(&design).input.amax() < 1e-12, "{}", set_point(&design).input);
}
