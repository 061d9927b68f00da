//! Which design gains belong to: a checksum of a canonical text, so that layout and comments of the file do not count.
//!
//! The text is documented in `docs/blob-format.md`. Numbers are rounded to nine digits: two machines may discretise
//! a plant with a difference in the last bits, which makes it no other design.

use crate::design::{Acknowledgement, DelayDistribution, Design};
use nalgebra::DMatrix;
use slqg::blob::DesignId;

/// The id of `design`: of its name, plant, cost and network, which its law follows from.
///
/// What `[tracking]` and `[event]` add to the law does not count: what carries the law alone is not written for them.
/// Settings of the controller do not count; how long sequences are, the default input and the scalar stand beside the
/// id in whatever carries it.
pub fn design_id(design: &Design) -> DesignId {
    DesignId::of(canonical(design).as_bytes())
}

fn canonical(design: &Design) -> String {
    let (plant, cost, network) = (&design.plant, &design.cost, &design.network);
    let mean = DMatrix::from_column_slice(1, plant.states(), plant.initial_mean.as_slice());
    let mut text = format!("slqg design 1\nsample_time {}\n", number(plant.sample_time));
    for (key, matrix) in [
        ("a", &plant.a),
        ("b", &plant.b),
        ("c", &plant.c),
        ("process_noise", &plant.process_noise),
        ("measurement_noise", &plant.measurement_noise),
        ("initial_mean", &mean),
        ("initial_covariance", &plant.initial_covariance),
        ("q", &cost.q),
        ("r", &cost.r),
    ] {
        let (rows, columns) = matrix.shape();
        text.push_str(&format!("{key} {rows} {columns}"));
        line(&mut text, matrix.transpose().iter());
    }
    link(&mut text, "controller_to_actuator", &network.controller_to_actuator.delays);
    link(&mut text, "sensor_to_controller", &network.sensor_to_controller.delays);
    match &network.acknowledgement {
        Acknowledgement::Instant => text.push_str("acknowledgement instant\n"),
        Acknowledgement::None => text.push_str("acknowledgement none\n"),
        Acknowledgement::Over(over) => link(&mut text, "acknowledgement", &over.delays),
    }
    // Last, as it may hold anything.
    text + &format!("name {}\n", design.name)
}

fn link(text: &mut String, key: &str, link: &DelayDistribution) {
    text.push_str(key);
    line(text, link.probabilities().iter());
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
        let expected = "slqg design 1\n\
            sample_time 1.00000000e-1\n\
            a 1 1 1.25000000e0\n\
            b 1 1 -2.00000000e0\n\
            c 1 1 1.00000000e0\n\
            process_noise 1 1 5.00000000e-1\n\
            measurement_noise 1 1 3.00000000e0\n\
            initial_mean 1 1 0.00000000e0\n\
            initial_covariance 1 1 0.00000000e0\n\
            q 1 1 1.00000000e0\n\
            r 1 1 3.33333333e-1\n\
            controller_to_actuator 5.00000000e-1 2.50000000e-1\n\
            sensor_to_controller 1.00000000e0\n\
            acknowledgement instant\n\
            name lift\n";
        assert_eq!(canonical(&parsed(DESIGN)), expected);
        assert_eq!(design_id(&parsed(DESIGN)), DesignId::of(expected.as_bytes()));
    }

    #[test]
    fn every_figure_of_plant_cost_and_network_makes_another_design() {
        let id = design_id(&parsed(DESIGN));
        for (from, to) in [
            ("'lift'", "'hoist'"),
            ("sample_time = 0.1", "sample_time = 0.2"),
            ("1.25", "1.26"),
            ("-2", "2"),
            ("c = [[1]]", "c = [[2]]"),
            ("0.5]]", "0.6]]"),
            ("[[3]]", "[[4]]"),
            ("-0.0", "0.1"),
            ("[[0]]", "[[1]]"),
            ("q = [[1]]", "q = [[2]]"),
            ("0.3333333333333333", "0.34"),
            ("0.25, 0]", "0.26]"),
            ("delays = [1]", "delays = [0.9]"),
            ("[controller]", "acknowledgement = 'none'\n[controller]"),
            ("[controller]", "acknowledgement.delays = [1]\n[controller]"),
        ] {
            assert!(DESIGN.contains(from));
            assert_ne!(design_id(&parsed(&DESIGN.replacen(from, to, 1))), id, "{from} -> {to}");
        }
    }

    #[test]
    fn layout_last_bits_and_controller_settings_do_not_make_another_design() {
        let id = design_id(&parsed(DESIGN));
        for (from, to) in [
            ("[cost]", "# weights\n[cost]"),
            ("0.3333333333333333", "0.33333333333333326"),
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
