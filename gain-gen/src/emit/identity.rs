//! Which design gains belong to: a checksum of a canonical text, so that layout and comments of the file do not count.
//!
//! The text is documented in `docs/blob-format.md`. Numbers are rounded to nine digits: two machines may discretise
//! a plant with a difference in the last bits, which makes it no other design.

use crate::design::Design;
use nalgebra::DMatrix;
use slqg::blob::DesignId;

/// The id of `design`: of its plant, which a device's estimator is made for.
///
/// Cost and network do not count: gains are computed anew when they change, and replaced on a device that runs. Nor does the
/// design's name, which may tell networks apart. Nor do
/// settings of the controller: how long sequences are, the default input and the scalar stand beside the id in whatever
/// carries it.
pub fn design_id(design: &Design) -> DesignId {
    DesignId::of(canonical(design).as_bytes())
}

fn canonical(design: &Design) -> String {
    let plant = &design.plant;
    let mean = DMatrix::from_column_slice(1, plant.states(), plant.initial_mean.as_slice());
    let mut text = format!("slqg design 3\nsample_time {}\n", number(plant.sample_time));
    for (key, matrix) in [
        ("a", &plant.a),
        ("b", &plant.b),
        ("c", &plant.c),
        ("process_noise", &plant.process_noise),
        ("measurement_noise", &plant.measurement_noise),
        ("initial_mean", &mean),
        ("initial_covariance", &plant.initial_covariance),
    ] {
        let (rows, columns) = matrix.shape();
        text.push_str(&format!("{key} {rows} {columns}"));
        line(&mut text, matrix.transpose().iter());
    }
    text
}

fn line<'v>(text: &mut String, values: impl Iterator<Item = &'v f64>) {
    for &value in values {
        text.push(' ');
        text.push_str(&number(value));
    }
    text.push('\n');
}

fn number(value: f64) -> String {
    // Zero has no sign here.
    format!("{:.8e}", if value == 0.0 { 0.0 } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    const DESIGN: &str = "
        name = 'lift'
        [plant]
        sample_time = 0.1
        discrete = { a = [[1.25]], b = [[-2]] }
        c = [[1]]
        process_noise = [[0.5]]
        measurement_noise = [[3]]
        initial_mean = [-0.0]
        initial_covariance = [[0]]
        [cost]
        q = [[1]]
        r = [[0.3333333333333333]]
        [network]
        controller_to_actuator.delays = [0.5, 0.25, 0]
        sensor_to_controller.delays = [1]
        [controller]
        sequence_length = 2
    ";

    fn parsed(text: &str) -> Design {
        Design::parse(text, "lift.toml").unwrap()
    }

    #[test]
    fn the_canonical_text_is_as_documented() {
        let expected = "slqg design 3\n\
            sample_time 1.00000000e-1\n\
            a 1 1 1.25000000e0\n\
            b 1 1 -2.00000000e0\n\
            c 1 1 1.00000000e0\n\
            process_noise 1 1 5.00000000e-1\n\
            measurement_noise 1 1 3.00000000e0\n\
            initial_mean 1 1 0.00000000e0\n\
            initial_covariance 1 1 0.00000000e0\n";
        assert_eq!(canonical(&parsed(DESIGN)), expected);
        assert_eq!(design_id(&parsed(DESIGN)), DesignId::of(expected.as_bytes()));
    }

    #[test]
    fn every_figure_of_the_plant_makes_another_design() {
        let id = design_id(&parsed(DESIGN));
        for (from, to) in [
            ("sample_time = 0.1", "sample_time = 0.2"),
            ("1.25", "1.26"),
            ("-2", "2"),
            ("c = [[1]]", "c = [[2]]"),
            ("0.5]]", "0.6]]"),
            ("[[3]]", "[[4]]"),
            ("-0.0", "0.1"),
            ("[[0]]", "[[1]]"),
        ] {
            assert!(DESIGN.contains(from));
            assert_ne!(design_id(&parsed(&DESIGN.replacen(from, to, 1))), id, "{from} -> {to}");
        }
    }

    #[test]
    fn name_layout_last_bits_cost_network_and_settings_do_not_make_another_design() {
        let id = design_id(&parsed(DESIGN));
        for (from, to) in [
            ("'lift'", "'lift, by radio'"),
            ("[cost]", "# weights\n[cost]"),
            ("1.25", "1.2500000000000002"),
            ("0.3333333333333333", "0.34"),
            ("0.25, 0]", "0.26]"),
            ("[controller]", "acknowledgement = 'none'\n[controller]"),
            (
                "sequence_length = 2",
                "sequence_length = 3\ndefault_input = 'hold'\nscalar = 'f64'\nestimator = 'gpb2'",
            ),
            ("[controller]", "acknowledged_cycles = 2\n[controller]"),
        ] {
            assert_eq!(design_id(&parsed(&DESIGN.replacen(from, to, 1))), id, "{from} -> {to}");
        }
    }
}
