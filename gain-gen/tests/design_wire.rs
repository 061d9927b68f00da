//! `[wire]`: steps follow from limits, frames that fit are told by their length, and changes after reading are noticed.
//! Rejected files are in `design_errors.rs`.

use gain_gen::design::{
    Acknowledgement, Authentication, Counted, Design, DeviceScalar, FrameBytes, Steps, WireSettings,
};
use gain_gen::report::Report;
use gain_gen::solve::Method;

const GANTRY: &str = include_str!("data/gantry.toml");

fn parsed(changes: &[(&str, &str)]) -> Result<Design, String> {
    let text = changes.iter().fold(GANTRY.to_string(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text.replace(from, to)
    });
    Design::parse(&text, "gantry.toml").map_err(|error| error.to_string())
}

/// Changes to the gantry that let it travel as `format`, with acknowledgements of eight cycles.
fn carried(format: &'static str) -> [(&'static str, &'static str); 2] {
    [("format = \"can-classic\"", format), ("output_limits = [2.0, 5.0]", "")]
}

#[test]
fn steps_divide_the_larger_limit_into_the_counts_of_a_frame_in_the_scalar_of_the_device() {
    for (length, most) in [(1, 32767), (2, 32767), (3, 4095)] {
        for (scalar, is_single) in [("f32", true), ("f64", false)] {
            let scalar = format!("[controller]\nscalar = \"{scalar}\"");
            let length = format!("sequence_length = {length}");
            let design = parsed(&[("[controller]", &scalar), ("sequence_length = 3", &length)]).unwrap();
            let step = |limit: f64, most: i16| match is_single {
                true => f64::from(limit as f32 / f32::from(most)),
                false => limit / f64::from(most),
            };
            let expected = Steps {
                inputs: Counted { steps: vec![step(24.0, most)], largest_count: most },
                // Two of them, in frames of their own.
                outputs: Counted { steps: vec![step(2.0, 32767), step(5.0, 32767)], largest_count: 32767 },
            };
            assert_eq!(design.steps(), Some(expected));
        }
    }
    let mut design = parsed(&[]).unwrap();
    design.set_sequence_length(2);
    assert_eq!(design.steps().unwrap().inputs.largest_count, 32767, "a length that is changed later counts");
}

#[test]
fn without_the_table_frames_are_bytes() {
    let bytes = parsed(&carried("format = \"bytes\"")).unwrap();
    let (before, _) = GANTRY.split_once("[wire]").unwrap();
    let without = Design::parse(before, "gantry.toml").unwrap();
    assert_eq!((&without.wire, &without), (&WireSettings::Bytes, &bytes));
    assert_eq!(without.network.acknowledged_cycles, 8);
}

#[test]
fn acknowledgements_tell_as_many_cycles_as_fit_unless_the_design_says() {
    assert_eq!(parsed(&[]).unwrap().network.acknowledged_cycles, 5);
    let fewer = "acknowledged_cycles = 2\nacknowledgement =";
    assert_eq!(parsed(&[("acknowledgement =", fewer)]).unwrap().network.acknowledged_cycles, 2);
    let never = parsed(&[("{ delays = [0.8, 0.1] }", "\"none\"")]).unwrap();
    assert_eq!(never.carried_bytes().unwrap().acknowledgement, None);
}

#[test]
fn frames_are_as_long_as_the_wire_page_says() {
    let frames = |measurement, control, acknowledgement| FrameBytes {
        measurement,
        control,
        acknowledgement: Some(acknowledgement),
    };
    let classic = parsed(&[]).unwrap();
    assert_eq!(classic.frame_bytes(), frames(20, 25, 16));
    assert_eq!(classic.carried_bytes(), Some(frames(7, 8, 8)));
    let fd = parsed(&carried("format = \"can-fd\"")).unwrap();
    assert_eq!(fd.carried_bytes(), Some(frames(20, 32, 20)));
    let bytes = parsed(&carried("format = \"bytes\"")).unwrap();
    assert_eq!(bytes.carried_bytes(), Some(frames(20, 25, 19)));
}

#[test]
fn the_longest_sequence_that_an_error_names_fits() {
    let [format, limits] = carried("format = \"can-fd\"");
    for (scalar, most) in [("f32", 12), ("f64", 6)] {
        let scalar = format!("[controller]\nscalar = \"{scalar}\"");
        let of = |length: usize| {
            let length = format!("sequence_length = {length}");
            parsed(&[format, limits, ("[controller]", &scalar), ("sequence_length = 3", &length)])
        };
        assert!(of(most).is_ok());
        assert!(of(most + 1).unwrap_err().contains(&format!("give at most {most}, or ")));
    }
}

#[test]
fn plants_too_wide_for_a_frame_are_refused_with_a_carrier_that_has_room() {
    let rows = |count: usize| vec!["[1, 0]"; count].join(", ");
    let diagonal = |count: usize| {
        let row =
            |at| (0..count).map(|other| if other == at { "1" } else { "0" }).collect::<Vec<_>>().join(", ");
        (0..count).map(|at| format!("[{}]", row(at))).collect::<Vec<_>>().join(", ")
    };
    let wide = |outputs: usize, format: &str, limits: &str, scalar: &str| {
        parsed(&[
            ("c = [[1.0, 0.0], [0.0, 1.0]]", &format!("c = [{}, [0, 1]]", rows(outputs - 1))),
            (
                "measurement_noise = [[1e-4, 0.0], [0.0, 4e-4]]",
                &format!("measurement_noise = [{}]", diagonal(outputs)),
            ),
            ("\"can-classic\"", format),
            ("output_limits = [2.0, 5.0]", limits),
            ("[controller]", &format!("[controller]\nscalar = \"{scalar}\"")),
        ])
    };
    let refused = wide(4, "\"can-classic\"", "output_limits = [1, 1, 1, 1]", "f32").unwrap_err();
    assert_eq!(
        refused,
        "gantry.toml:28: wire.format: found \"can-classic\" for a plant with 4 outputs, but a classic CAN frame carries 3 \
         values; give \"can-fd\""
    );
    assert!(wide(13, "\"can-fd\"", "", "f32").is_ok());
    let refused = wide(14, "\"can-fd\"", "", "f32").unwrap_err();
    let measurement = "wire.format: found a measurement frame of 68 bytes, but a CAN FD frame carries 64";
    assert_eq!(refused, format!("gantry.toml:28: {measurement}; give format = \"bytes\""));
    let refused = wide(7, "\"can-fd\"", "", "f64").unwrap_err();
    let advice = "give controller.scalar = \"f32\", or format = \"bytes\"";
    assert_eq!(refused, format!("gantry.toml:28: {measurement}; {advice}"));
}

#[test]
fn what_is_changed_after_reading_is_noticed() {
    let design = parsed(&[]).unwrap();
    assert_eq!(design.misfit(), None);
    let mut longer = design.clone();
    longer.set_sequence_length(4);
    assert_eq!(longer.misfit().unwrap().key, "controller.sequence_length");
    assert_eq!(longer.carried_bytes(), None);
    let mut more = design.clone();
    more.network.acknowledged_cycles = 8;
    assert_eq!(more.misfit().unwrap().key, "network.acknowledged_cycles");
    more.network.acknowledgement = Acknowledgement::None;
    assert_eq!(more.misfit(), None);
}

#[test]
fn rounding_costs_what_the_quadratic_form_of_its_variance_says() {
    // One state, one input that always arrives: P solves the scalar Riccati equation.
    let design = Design::parse(
        "name = 'tank'
         plant = { sample_time = 1, discrete = { a = [[1]], b = [[2]] }, c = [[1]], process_noise = [[1]],
                   measurement_noise = [[1]], initial_mean = [0], initial_covariance = [[0]] }
         cost = { q = [[1]], r = [[3]] }
         network = { controller_to_actuator.delays = [1], sensor_to_controller.delays = [1] }
         controller = { sequence_length = 1, scalar = 'f64', input_limits = [[-32767, 0]] }
         wire = { format = 'can-classic', output_limits = [1] }",
        "tank.toml",
    )
    .unwrap();
    assert_eq!(design.controller.scalar, DeviceScalar::F64);
    // P = 1 + P - (2 P)^2 / (3 + 4 P), so 4 P^2 = 3 + 4 P.
    let p = 1.5;
    let found = Report::new(&design, Method::InFlight).rounding_cost().unwrap();
    assert!((found - (3.0 + 4.0 * p) / 12.0).abs() < 1e-9, "{found}");
}

#[test]
fn sealed_frames_are_nine_bytes_longer_and_must_fit_all_the_same() {
    let with = |format, length: &str| {
        let [format, limits] = carried(format);
        parsed(&[format, limits, ("sequence_length = 3", &format!("sequence_length = {length}"))])
    };
    let (plain, sealed) =
        (with("format = \"bytes\"", "3"), with("format = \"bytes\"\nauthentication = \"cmac\"", "3"));
    let (plain, sealed) = (plain.unwrap(), sealed.unwrap());
    assert_eq!((plain.authentication, sealed.authentication), (Authentication::None, Authentication::Cmac));
    let (plain, sealed) = (plain.carried_bytes().unwrap(), sealed.carried_bytes().unwrap());
    assert_eq!(sealed.measurement, plain.measurement + 9);
    assert_eq!(sealed.control, plain.control + 9);
    assert_eq!(sealed.acknowledgement, plain.acknowledgement.map(|bytes| bytes + 9));

    assert!(with("format = \"can-fd\"\nauthentication = \"cmac\"", "10").is_ok());
    let refused = with("format = \"can-fd\"\nauthentication = \"cmac\"", "11").unwrap_err();
    assert!(refused.contains("a control frame of 66 bytes"), "{refused}");
    assert!(refused.contains("give at most 10, or"), "{refused}");
    assert!(with("format = \"can-fd\"\nauthentication = \"none\"", "12").is_ok());
}

#[test]
fn an_authentication_that_cannot_be_is_refused_at_its_key() {
    let refused = |line: &str| parsed(&[("format = \"can-classic\"", line)]).unwrap_err();
    let classic = refused("format = \"can-classic\"\nauthentication = \"cmac\"");
    assert!(
        classic.contains("wire.authentication: found \"cmac\" with format = \"can-classic\""),
        "{classic}"
    );
    assert!(classic.contains("give format = \"can-fd\" or \"bytes\""), "{classic}");
    let unknown = refused("format = \"can-classic\"\nauthentication = \"hmac\"");
    assert!(unknown.contains("found the text \"hmac\"; give"), "{unknown}");
    assert!(unknown.contains("\"none\"") && unknown.contains("\"cmac\""), "{unknown}");
}
