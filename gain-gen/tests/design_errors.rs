//! Wrong designs, each one change away from `data/motor.toml`: every rejection names file, line and key, what was
//! found and what is allowed. That correct designs are read correctly is in `designs.rs`.
//!
//! The cases are in `data/design_errors.txt`; here are those that treat all keys alike, and the runner.

use gain_gen::design::{Design, DesignError};
use std::path::Path;

/// Three states, two inputs and one output, so that no two dimensions can be mistaken for each other.
const CORRECT: &str = include_str!("data/motor.toml");
const CASES: &str = include_str!("data/design_errors.txt");

const REQUIRED: [&str; 13] = [
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
];
const OPTIONAL: [&str; 5] = [
    "network.acknowledgement",
    "controller.default_input",
    "controller.measurement_buffer",
    "controller.scalar",
    "controller.input_limits",
];

fn rejection(claim: &str, text: &str) -> DesignError {
    match Design::parse(text, "motor.toml") {
        Err(error) => error,
        Ok(_) => panic!("{claim}: accepted"),
    }
}

/// Asserts that `text` is rejected on `line` for `key`, with `says` in the message.
fn assert_rejected(text: &str, line: usize, key: &str, says: &str) {
    let error = rejection(key, text);
    let message = error.to_string();
    assert_eq!((error.line, error.key.as_str()), (Some(line), key), "{message}");
    assert!(message.starts_with(&format!("motor.toml:{line}: {key}: ")), "{message}");
    assert!(message.contains(says), "{message:?} does not say {says:?}");
}

/// Lines, counted from 1, of the correct design: where `key` begins, where its value ends, where its table begins.
fn lines_of(key: &str) -> (usize, usize, usize) {
    let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
    let find = |start: String| 1 + CORRECT.lines().position(|line| line.starts_with(&start)).unwrap();
    let first = find(format!("{name} ="));
    let inside = |line: &&str| line.starts_with(' ') || line.starts_with(']');
    let last = first + CORRECT.lines().skip(first).take_while(inside).count();
    (first, last, if table.is_empty() { 1 } else { find(format!("[{table}]")) })
}

/// The correct design with `replacement` in place of the lines `first..=last`; the others keep their numbers.
fn with_line(replacement: &str, first: usize, last: usize) -> String {
    let mut lines: Vec<_> = CORRECT.lines().collect();
    lines[first - 1..last].fill("");
    lines[first - 1] = replacement;
    lines.join("\n")
}

#[test]
fn the_design_that_all_cases_change_is_correct() {
    Design::parse(CORRECT, "motor.toml").unwrap();
}

#[test]
fn each_wrong_design_is_rejected_with_its_message() {
    let mut ran = 0;
    for case in CASES.split("\n# ").skip(1) {
        let case = case.split("\n==").next().unwrap().trim_end();
        let claim = case.lines().next().unwrap();
        let part = |mark| case.lines().filter_map(|line| line.strip_prefix(mark)).collect::<Vec<_>>();
        let (old, new) = (part("- ").join("\n"), part("+ ").join("\n"));
        assert_eq!(CORRECT.matches(&old).count(), 1, "{claim}: its lines must occur once");
        let message = rejection(claim, &CORRECT.replacen(&old, &new, 1)).to_string();
        let [expected] = part("! ")[..] else { panic!("{claim}: must have one message") };
        match format!("motor.toml:{expected}").strip_suffix("..") {
            Some(beginning) => assert!(message.starts_with(beginning), "{claim}: {message}"),
            None => assert_eq!(message, format!("motor.toml:{expected}"), "{claim}"),
        }
        assert_eq!(message.lines().count(), 1, "{claim}: {message}");
        ran += 1;
    }
    assert_eq!(ran, CASES.lines().filter(|line| line.starts_with("! ")).count());
}

#[test]
fn a_missing_key_is_reported_on_the_line_of_its_table() {
    // Without `discrete` one of two keys is missing, so the table itself is at fault: a case of its own.
    for key in REQUIRED.iter().filter(|key| **key != "plant.discrete") {
        let (first, last, table) = lines_of(key);
        assert_rejected(&with_line("", first, last), table, key, "missing; give ");
    }
}

#[test]
fn a_missing_table_is_reported_on_the_first_line() {
    for table in ["plant", "cost", "network", "controller"] {
        let header = 1 + CORRECT.lines().position(|line| line == format!("[{table}]")).unwrap();
        let length = CORRECT.lines().skip(header).take_while(|line| !line.is_empty()).count();
        assert_rejected(&with_line("", header, header + length), 1, table, "missing; give a table");
    }
}

#[test]
fn an_optional_key_may_be_missing() {
    for key in OPTIONAL {
        let (first, last, _) = lines_of(key);
        Design::parse(&with_line("", first, last), "motor.toml").unwrap();
    }
}

#[test]
fn a_misspelt_key_is_answered_with_the_nearest_one() {
    for key in REQUIRED.iter().chain(&OPTIONAL) {
        let (first, ..) = lines_of(key);
        let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
        let wrong = if name.len() == 1 { format!("{name}x") } else { name.replacen(&name[1..2], "", 1) };
        let line = CORRECT.lines().nth(first - 1).unwrap().replacen(name, &wrong, 1);
        let dotted = if table.is_empty() { wrong } else { format!("{table}.{wrong}") };
        assert_rejected(&with_line(&line, first, first), first, &dotted, &format!("did you mean `{name}`?"));
    }
}

#[test]
fn a_value_of_a_wrong_type_is_named() {
    for key in REQUIRED.iter().chain(&OPTIONAL) {
        let (first, last, _) = lines_of(key);
        let name = key.rsplit('.').next().unwrap();
        let text = with_line(&format!("{name} = true"), first, last);
        assert_rejected(&text, first, key, "found the truth value true; give ");
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
