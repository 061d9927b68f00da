//! What build scripts can ask for: a design as it is or changed, under a name of its own, or an error for who wrote it.

use gain_gen::build::{Compile, compile_into};
use gain_gen::design::Design;
use gain_gen::emit::{Format, emit};
use gain_gen::report::Report;
use gain_gen::solve::Method;
use slqg::DefaultInput;
use std::path::{Path, PathBuf};

fn design(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn pendulum() -> PathBuf {
    design("../designs/pendulum.toml")
}

#[test]
fn without_changes_the_source_is_that_of_the_file_and_bears_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = compile_into(&pendulum(), folder.path()).unwrap();
    assert_eq!(path, folder.path().join("pendulum.rs"));
    let report = Report::new(&Design::load(&pendulum()).unwrap(), Method::InFlight);
    let expected = emit(&report.emission().unwrap(), "pendulum.toml", Format::Rust).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), expected);
}

#[test]
fn a_changed_design_is_compiled_beside_the_one_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let plain = compile_into(&pendulum(), folder.path()).unwrap();
    let changed = Compile::new(pendulum())
        .default_input(DefaultInput::Hold)
        .sequence_length(6)
        .name("pendulum_hold")
        .run_into(folder.path())
        .unwrap();
    assert_eq!(changed, folder.path().join("pendulum_hold.rs"));
    let mut design = Design::load(&pendulum()).unwrap();
    design.set_default_input(DefaultInput::Hold);
    design.set_sequence_length(6);
    let report = Report::new(&design, Method::InFlight);
    let expected = emit(&report.emission().unwrap(), "pendulum.toml", Format::Rust).unwrap();
    assert_eq!(std::fs::read_to_string(&changed).unwrap(), expected);
    assert!(
        expected.contains("from pendulum.toml, design \"pendulum\", N = 6, default input hold."),
        "{expected}"
    );
    assert!(std::fs::read_to_string(&plain).unwrap().contains("N = 4, default input zero."));
}

#[test]
fn a_task_is_compiled_where_no_loop_could_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let task =
        Compile::new(design("../designs/critical.toml")).sequence_length(2).horizon(8).name("critical_task");
    let written = std::fs::read_to_string(task.run_into(folder.path()).unwrap()).unwrap();
    assert_eq!(written, std::fs::read_to_string(design("tests/generated/critical_task.rs")).unwrap());
}

#[test]
fn what_is_compiled_tells_the_sizes_that_the_source_has() {
    let folder = tempfile::tempdir().unwrap();
    for (file, is_tracking) in [("tests/data/hoist.toml", true), ("../designs/pendulum.toml", false)] {
        let compile = Compile::new(design(file)).accept_undecided_stability();
        let compiled = compile.compiled_into(folder.path()).unwrap();
        let source = std::fs::read_to_string(&compiled.path).unwrap();
        for (name, size) in
            [("TRACKED_OUTPUTS", compiled.tracked_outputs), ("PREVIEW_SAMPLES", compiled.preview_samples)]
        {
            assert_eq!(source.contains(&format!("pub const {name}: usize = {size};")), is_tracking, "{file}");
            assert_eq!(size > 0, is_tracking, "{file}: {name}");
        }
        assert_eq!(compiled.design, Design::load(&design(file)).unwrap());
    }
}

#[test]
fn what_is_not_possible_is_refused_with_what_is() {
    let folder = tempfile::tempdir().unwrap();
    let of_pendulum = || Compile::new(pendulum());
    let lift = || Compile::new(design("tests/data/lift.toml"));
    for (compile, part) in [
        (
            of_pendulum().sequence_length(0),
            "pendulum.toml: sequence_length: found 0; give a number of inputs from 1 to 128",
        ),
        (of_pendulum().sequence_length(129), "found 129"),
        (
            of_pendulum().horizon(0),
            "pendulum.toml: horizon: found 0; give a number of cycles from 1 to 10000",
        ),
        (
            of_pendulum().name("a/b"),
            "pendulum.toml: name: found \"a/b\"; give the name of a file without folders",
        ),
        (of_pendulum().name(""), "name: found \"\""),
        (lift().horizon(3), "lift.toml: --horizon: found [event]"),
        (Compile::new(folder.path().join("none.toml")), "none.toml: cannot be read"),
        (
            Compile::new(design("../designs/critical.toml")).sequence_length(2),
            "critical.toml: \"critical\" with N = 2 and default input zero cannot be stabilised: Theorem 3.4 b)",
        ),
    ] {
        let error = compile.run_into(folder.path()).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
}

#[test]
fn what_makes_no_sense_in_a_design_is_told_to_the_build_script() {
    let folder = tempfile::tempdir().unwrap();
    let plain = Compile::new(pendulum()).compiled_into(folder.path()).unwrap();
    assert_eq!(plain.warnings, []);
    let text = std::fs::read_to_string(pendulum()).unwrap();
    let slow = folder.path().join("slow.toml");
    std::fs::write(&slow, text.replace("sample_time = 0.02", "sample_time = 1e-7")).unwrap();
    let compile = Compile::new(&slow).accept_undecided_stability();
    let told = compile.compiled_into(folder.path()).unwrap().warnings;
    assert!(!told.is_empty() && told.iter().all(|warning| warning.origin.ends_with("slow.toml")), "{told:?}");
}
