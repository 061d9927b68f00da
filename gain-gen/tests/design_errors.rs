//! Wrong designs, each one change away from `data/motor.toml`, `data/axis.toml` or `data/gantry.toml`: every rejection names
//! file, line and key, what was found and what is allowed. That correct designs are read correctly is in `designs.rs`.
//!
//! The cases are in `data/design_errors.txt`; here are those that treat all keys alike, and the runner.

use gain_gen::design::{Design, DesignError};
use std::path::Path;

const CASES: &str = include_str!("data/design_errors.txt");

/// A correct design.
struct Base {
    name: &'static str,
    text: &'static str,
    required: &'static [&'static str],
    optional: &'static [&'static str],
}

/// Three states, two inputs and one output, so that no two dimensions can be mistaken for each other.
const MOTOR: Base = Base {
    name: "motor.toml",
    text: include_str!("data/motor.toml"),
    required: &[
        "name",
        "plant.sample_time",
        "plant.discrete",
        "plant.c",
        "plant.process_noise",
        "plant.measurement_noise",
        "plant.initial_mean",
        "plant.initial_covariance",
        "cost.q",
        "cost.r",
        "network.controller_to_actuator",
        "network.sensor_to_controller",
        "controller.sequence_length",
    ],
    optional: &[
        "network.acknowledgement",
        "network.acknowledged_cycles",
        "controller.default_input",
        "controller.measurement_buffer",
        "controller.estimator",
        "controller.scalar",
        "controller.input_limits",
    ],
};
/// Tracks two of three states, with one input.
const AXIS: Base = Base {
    name: "axis.toml",
    text: include_str!("data/axis.toml"),
    required: &["cost.q", "tracking.z", "event.send_cost"],
    optional: &["cost.terminal", "tracking.preview", "tracking.preview_tolerance", "tracking.reference"],
};
/// Travels on classic CAN.
const GANTRY: Base = Base {
    name: "gantry.toml",
    text: include_str!("data/gantry.toml"),
    required: &["wire.format", "wire.output_limits"],
    optional: &["network.acknowledgement"],
};
const BASES: [Base; 3] = [MOTOR, AXIS, GANTRY];

impl Base {
    fn rejection(&self, claim: &str, text: &str) -> DesignError {
        match Design::parse(text, self.name) {
            Err(error) => error,
            Ok(_) => panic!("{claim}: accepted"),
        }
    }

    /// Asserts that `text` is rejected on `line` for `key`, with `says` in the message.
    fn assert_rejected(&self, text: &str, line: usize, key: &str, says: &str) {
        let error = self.rejection(key, text);
        let message = error.to_string();
        assert_eq!((error.line, error.key.as_str()), (Some(line), key), "{message}");
        assert!(message.starts_with(&format!("{}:{line}: {key}: ", self.name)), "{message}");
        assert!(message.contains(says), "{message:?} does not say {says:?}");
    }

    /// Lines, counted from 1: where `key` begins, where its value ends, where its table begins.
    fn lines_of(&self, key: &str) -> (usize, usize, usize) {
        let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
        let find = |start: String| 1 + self.text.lines().position(|line| line.starts_with(&start)).unwrap();
        let first = find(format!("{name} ="));
        let inside = |line: &&str| line.starts_with(' ') || line.starts_with(']');
        let last = first + self.text.lines().skip(first).take_while(inside).count();
        (first, last, if table.is_empty() { 1 } else { find(format!("[{table}]")) })
    }

    /// The design with `replacement` in place of the lines `first..=last`; the others keep their numbers.
    fn with_line(&self, replacement: &str, first: usize, last: usize) -> String {
        let mut lines: Vec<_> = self.text.lines().collect();
        lines[first - 1..last].fill("");
        lines[first - 1] = replacement;
        lines.join("\n")
    }
}

#[test]
fn the_designs_that_all_cases_change_are_correct() {
    for base in BASES {
        Design::parse(base.text, base.name).unwrap();
    }
}

#[test]
fn each_wrong_design_is_rejected_with_its_message() {
    let mut ran = 0;
    for case in CASES.split("\n# ").skip(1) {
        let case = case.split("\n==").next().unwrap().trim_end();
        let claim = case.lines().next().unwrap();
        let part = |mark| case.lines().filter_map(|line| line.strip_prefix(mark)).collect::<Vec<_>>();
        let base = match part("@ ")[..] {
            [] => MOTOR,
            [name] => BASES.into_iter().find(|base| base.name == name).unwrap(),
            _ => panic!("{claim}: must change one design"),
        };
        let (old, new) = (part("- ").join("\n"), part("+ ").join("\n"));
        assert_eq!(base.text.matches(&old).count(), 1, "{claim}: its lines must occur once");
        let message = base.rejection(claim, &base.text.replacen(&old, &new, 1)).to_string();
        let [expected] = part("! ")[..] else { panic!("{claim}: must have one message") };
        let expected = format!("{}:{expected}", base.name);
        match expected.strip_suffix("..") {
            Some(beginning) => assert!(message.starts_with(beginning), "{claim}: {message}"),
            None => assert_eq!(message, expected, "{claim}"),
        }
        assert_eq!(message.lines().count(), 1, "{claim}: {message}");
        ran += 1;
    }
    assert_eq!(ran, CASES.lines().filter(|line| line.starts_with("! ")).count());
}

#[test]
fn a_missing_key_is_reported_on_the_line_of_its_table() {
    for base in BASES {
        // Without `discrete` one of two keys is missing, so the table itself is at fault: a case of its own.
        for key in base.required.iter().filter(|key| **key != "plant.discrete") {
            let (first, last, table) = base.lines_of(key);
            base.assert_rejected(&base.with_line("", first, last), table, key, "missing; give ");
        }
    }
}

#[test]
fn a_missing_table_is_reported_on_the_first_line() {
    for table in ["plant", "cost", "network", "controller"] {
        let header = 1 + MOTOR.text.lines().position(|line| line == format!("[{table}]")).unwrap();
        let length = MOTOR.text.lines().skip(header).take_while(|line| !line.is_empty()).count();
        let text = MOTOR.with_line("", header, header + length);
        MOTOR.assert_rejected(&text, 1, table, "missing; give a table");
    }
}

#[test]
fn an_optional_key_may_be_missing() {
    for base in BASES {
        for key in base.optional {
            let (first, last, _) = base.lines_of(key);
            Design::parse(&base.with_line("", first, last), base.name).unwrap();
        }
    }
}

#[test]
fn a_misspelt_key_is_answered_with_the_nearest_one() {
    for base in BASES {
        for key in base.required.iter().chain(base.optional) {
            let (first, ..) = base.lines_of(key);
            let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
            let wrong = if name.len() == 1 { format!("{name}x") } else { name.replacen(&name[1..2], "", 1) };
            let line = base.text.lines().nth(first - 1).unwrap().replacen(name, &wrong, 1);
            let dotted = if table.is_empty() { wrong } else { format!("{table}.{wrong}") };
            let says = format!("did you mean `{name}`?");
            base.assert_rejected(&base.with_line(&line, first, first), first, &dotted, &says);
        }
    }
}

#[test]
fn a_value_of_a_wrong_type_is_named() {
    for base in BASES {
        for key in base.required.iter().chain(base.optional) {
            let (first, last, _) = base.lines_of(key);
            let name = key.rsplit('.').next().unwrap();
            let text = base.with_line(&format!("{name} = true"), first, last);
            base.assert_rejected(&text, first, key, "found the truth value true; give ");
        }
    }
}

#[test]
fn a_file_that_cannot_be_read_is_named_with_the_reason() {
    let error = Design::load(Path::new("no/such/design.toml")).unwrap_err();
    assert_eq!((error.line, error.key.as_str()), (None, ""));
    let message = error.to_string();
    assert!(message.starts_with("no/such/design.toml: cannot be read: "), "{message}");
    assert!(message.len() > "no/such/design.toml: cannot be read: ; give the path of a design file".len());
}

#[test]
fn a_rejected_file_is_reported_by_its_path() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/design_errors.txt");
    let error = Design::load(&path).unwrap_err();
    assert!(error.to_string().starts_with(&format!("{}:1: not TOML: ", path.display())), "{error}");
}
