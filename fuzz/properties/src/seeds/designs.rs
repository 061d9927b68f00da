//! Texts of design files, and bytes that designs are made of, as [`crate::solved`] reads them.

use super::Seed;

/// An unstable plant of two states over a link that loses packets.
const BASE: &str = r#"name = "seed"

[plant]
sample_time = 0.1  # s
discrete = { a = [[1.0, 0.1], [0.0, 1.05]], b = [[0.0], [0.1]] }
c = [[1, 0]]
process_noise = [[1e-4, 0], [0, 1e-4]]
measurement_noise = [[1e-4]]
initial_mean = [0, 1]
initial_covariance = [[1, 0], [0, 1]]

[cost]
q = [[1, 0], [0, 0.1]]
r = [[0.1]]

[network]
controller_to_actuator.delays = [0.6, 0.2, 0.1]
sensor_to_controller.delays = [0.8, 0.1]
acknowledgement = "instant"

[controller]
sequence_length = 3
unlimited_inputs = true
"#;

pub(super) fn texts() -> Vec<Seed> {
    let changed = |changes: &[(&str, &str)]| {
        changes.iter().fold(BASE.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "no {from}");
            text.replace(from, to)
        })
    };
    let with = |more: &str| format!("{BASE}{more}");
    let channel =
        "controller_to_actuator.gilbert_elliott = { to_bad = 0.1, to_good = 0.5, good = [0.9], bad = [] }";
    let markov = "controller_to_actuator = { markov = { transitions = [[0.9, 0.1], [0.4, 0.6]], \
                  delays = [[0.8, 0.1], [0.2]] }, duplicates = 0.01 }";
    let delays = "controller_to_actuator.delays = [0.6, 0.2, 0.1]";
    let instant = "acknowledgement = \"instant\"";
    let wary = "\n[safety]\ngate = 1e-6\ndoubt_after = 5\nrange = [[-5, 5]]\nstuck_after = 4\nreject_stuck = true\n\
                stale_after = 3\nlost_after = 9\nsafe_input = [0.5]\nsafe_after = 7\n";
    let tracking =
        "\n[tracking]\nz = [[1, 0]]\npreview = 5\nreference = [[0, 0], [1, 2]]\ninterpolation = \"linear\"\n";
    vec![
        ("plain", BASE.into()),
        (
            "continuous_f64_hold",
            changed(&[
                ("discrete", "continuous"),
                ("sequence_length = 3", "sequence_length = 2\nscalar = \"f64\"\ndefault_input = \"hold\""),
            ]),
        ),
        (
            "limits_and_rates",
            changed(&[("unlimited_inputs = true", "input_limits = [[-2, 1]]\ninput_rates = [10]")]),
        ),
        (
            "late_acknowledgements",
            changed(&[
                (instant, "acknowledgement.delays = [0.5, 0.3]\nacknowledged_cycles = 3"),
                ("unlimited_inputs = true", "estimator = \"imm\"\nmeasurement_buffer = 2"),
            ]),
        ),
        ("no_acknowledgements", changed(&[(instant, "acknowledgement = \"none\"")])),
        ("comes_and_goes", changed(&[(delays, channel)])),
        ("markov_with_copies", changed(&[(delays, markov)])),
        ("event", with("\n[event]\nsend_cost = 0.01\n")),
        ("tracking", changed(&[("q = [[1, 0], [0, 0.1]]", "q = [[1]]")]) + tracking),
        (
            "set_point",
            changed(&[("q = [[1, 0], [0, 0.1]]", "q = [[1]]"), ("1.05", "1.0")])
                + "\n[tracking]\nz = [[1, 0]]\nset_point = [2]\n",
        ),
        ("wary", with(wary)),
        (
            "counted_values",
            changed(&[("unlimited_inputs = true", "input_limits = [[-2, 1]]")])
                + "\n[wire]\nformat = \"can-classic\"\noutput_limits = [5]\n",
        ),
        ("sealed", with("\n[wire]\nformat = \"can-fd\"\nauthentication = \"cmac\"\n")),
        ("not_stabilised", changed(&[("1.05", "3.0"), ("[0.6, 0.2, 0.1]", "[0.1]")])),
        ("an_unknown_key", changed(&[("sample_time", "sampletime")])),
        ("no_toml", "name = \"\u{e9}\n[plant".into()),
        ("a_name_that_ends_comments", changed(&[("\"seed\"", "\"a */ b // c \\n d \\u2028 e\"")])),
    ]
    .into_iter()
    .map(|(name, text)| (name, text.into_bytes()))
    .collect()
}

pub(super) fn made_up() -> Vec<Seed> {
    // Numbers of states, inputs and outputs, less one; discrete; then matrices by rows, delays and choices.
    let scalar = [0, 0, 0, 0, 155, 150, 150, 10, 10, 10, 100, 30];
    let two = [1, 0, 0, 0, 150, 105, 100, 153, 100, 105, 150, 100, 1, 1, 1, 100, 100, 100, 30, 30];
    let links = [2, 150, 50, 25, 30, 0, 200, 20];
    let end = |choices: &[u8]| [&links[..], choices].concat();
    vec![
        ("one_state", [&scalar[..], &end(&[2, 2, 0])].concat()),
        ("two_states_hold_f64", [&two[..], &end(&[2, 3, 0b11])].concat()),
        ("two_states_none_acknowledged", [&two[..], &end(&[0, 1, 0b1_0100])].concat()),
        ("one_state_event", [&scalar[..], &end(&[1, 1, 90, 90, 60, 1, 0b10_0001, 1])].concat()),
    ]
}
