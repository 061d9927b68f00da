//! The source generated for a loop on classic CAN is compiled, and a loop with it loses nothing of its inputs on the bus.

use embedded_can::{Frame, Id, StandardId};
use gain_gen::design::Design;
use gain_gen::emit::{Format, emit};
use gain_gen::report::Report;
use gain_gen::solve::Method;
use slqg::wire::can::{Compact, Identifiers};
use slqg::wire::{Measurement, encode_acknowledgement, encode_measurement};
use slqg::{Tick, nalgebra::SVector};
use std::path::{Path, PathBuf};

#[allow(dead_code)]
mod command;

use command::{altered, gain_gen, object, text};

/// One input, two outputs, hold, late acknowledgements.
#[allow(dead_code, unreachable_pub)]
mod gantry {
    include!("generated/gantry.rs");
}

fn here(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(name)
}

/// A classic CAN frame.
#[derive(Debug, Clone)]
struct BusFrame {
    id: Id,
    data: Vec<u8>,
}

impl Frame for BusFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        (data.len() <= 8).then(|| Self { id: id.into(), data: data.into() })
    }
    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }
    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }
    fn is_remote_frame(&self) -> bool {
        false
    }
    fn id(&self) -> Id {
        self.id
    }
    fn dlc(&self) -> usize {
        self.data.len()
    }
    fn data(&self) -> &[u8] {
        &self.data
    }
}

#[test]
fn generated_source_is_the_committed_one() {
    let mut report = Report::new(&Design::load(&here("data/gantry.toml")).unwrap(), Method::InFlight);
    report.accept_undecided_stability();
    let written = emit(&report.emission().unwrap(), "gantry.toml", Format::Rust).unwrap();
    assert_eq!(written, std::fs::read_to_string(here("generated/gantry.rs")).unwrap());
}

#[test]
fn generated_nodes_close_the_loop_on_classic_can() {
    let id = |raw| Id::Standard(StandardId::new(raw).unwrap());
    let identifiers = Identifiers { measurement: id(0x80), control: id(0x81), acknowledgement: id(0x82) };
    let compact =
        Compact::new(gantry::DESIGN_ID, identifiers, gantry::INPUT_GRID, gantry::OUTPUT_GRID).unwrap();
    let (mut memory, mut of_actuator) = (gantry::Memory::new(), gantry::ACTUATOR_MEMORY);
    let mut controller = gantry::Controller::new(gantry::DESIGN, Tick(0), memory.lend()).unwrap();
    let mut actuator = gantry::Actuator::new(gantry::ACTUATOR, Tick(0), &mut of_actuator);
    let mut state = gantry::MODEL.initial_mean;
    let (mut full, mut restored) = ([0; 64], [0; 64]);
    for tick in (0..600).map(Tick) {
        let measurement = Measurement { tick, output: gantry::MODEL.c * state };
        let frame: BusFrame = compact.pack(encode_measurement(&measurement, &mut full).unwrap()).unwrap();
        controller.receive(compact.unpack(&frame, tick, &mut restored).unwrap()).unwrap();
        let sent = controller.cycle(&mut full).unwrap().expect("finite");
        let frame: BusFrame = compact.pack(sent).unwrap();
        let received = compact.unpack(&frame, actuator.tick(), &mut restored).unwrap();
        assert_eq!(received, sent, "to the bit");
        actuator.receive(received).unwrap();
        let applied = actuator.step();
        let told = actuator.acknowledgement(gantry::ACKNOWLEDGED_CYCLES).unwrap();
        let frame: BusFrame =
            compact.pack(encode_acknowledgement::<gantry::Scalar>(&told, &mut full).unwrap()).unwrap();
        controller.receive(compact.unpack(&frame, controller.tick(), &mut restored).unwrap()).unwrap();
        state = gantry::MODEL.a * state + gantry::MODEL.b * applied.input;
    }
    assert!(state.amax() < 1e-3, "{state}");
    assert_eq!(gantry::DESIGN.grid, Some(gantry::INPUT_GRID));
    assert_eq!(gantry::INPUT_GRID.round(&SVector::from([1e9]))[0], 4095.0 * (24.0 / 4095.0));
    assert_eq!(gantry::OUTPUT_GRID.largest_count, 32767);
}

#[test]
fn formats_that_cannot_round_refuse_a_loop_on_classic_can() {
    let folder = tempfile::tempdir().unwrap();
    for format in ["c", "blob"] {
        let target = folder.path().join("law.h");
        let output = gain_gen(
            "emit",
            &here("data/gantry.toml"),
            &["--accept-undecided-stability", "--to", format, "--output", target.to_str().unwrap()],
        );
        let sentence = format!(
            "error: wire: {format} carries the law alone: the rounding of the inputs would be missing; write rust or json\n"
        );
        assert_eq!((output.status.code(), text(&output.stderr)), (Some(2), sentence.as_str()));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written");
}

#[test]
fn frames_on_can_fd_do_not_change_what_is_generated() {
    let folder = tempfile::tempdir().unwrap();
    let design = here("data/winch.toml");
    let fd =
        altered(folder.path(), &design, &[("[controller]", "[wire]\nformat = \"can-fd\"\n\n[controller]")]);
    let written = |design: &Path| {
        let mut report = Report::new(&Design::load(design).unwrap(), Method::InFlight);
        report.accept_undecided_stability();
        emit(&report.emission().unwrap(), "winch.toml", Format::Rust).unwrap()
    };
    assert_eq!(written(&fd), written(&design));
}

#[test]
fn a_length_that_does_not_fit_is_reported_and_not_emitted() {
    let design = here("data/gantry.toml");
    let shown = gain_gen("report", &design, &["--sequence-length", "4"]);
    let misfit = "controller.sequence_length: found sequences of 4 inputs: 4 values, but a classic CAN frame carries 3";
    assert!(
        text(&shown.stdout).contains(&format!("does not fit        {misfit}")),
        "{}",
        text(&shown.stdout)
    );
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("gantry.rs");
    let options = ["--sequence-length", "4", "--to", "rust", "--output", target.to_str().unwrap()];
    let output = gain_gen("emit", &design, &options);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).starts_with(&format!("error: {misfit}; give at most 3")));
    assert!(!target.exists());
}

#[test]
fn reports_tell_bytes_steps_and_the_cost_of_rounding() {
    let design = here("data/gantry.toml");
    let wire = &object(&gain_gen("report", &design, &["--json"]))["wire"];
    let bytes =
        ["measurement_bytes", "control_bytes", "acknowledgement_bytes"].map(|field| wire[field].as_u64());
    assert_eq!((wire["format"].as_str(), bytes), (Some("can-classic"), [7, 8, 8].map(Some)));
    assert_eq!(wire["input_steps"][0].as_f64(), Some(f64::from(24.0_f32 / 4095.0)));
    assert!(wire["rounding_cost"].as_f64().is_some_and(|cost| cost > 0.0) && wire["misfit"].is_null());
    let report = gain_gen("report", &design, &[]);
    for line in [
        "Wire: can-classic",
        "  control             8           bytes in a CAN frame, for a frame of 25",
        "  input u1            step 0.00586081, standard deviation of its error 0.00169187",
    ] {
        assert!(text(&report.stdout).lines().any(|found| found == line), "{line}");
    }
    let plain = gain_gen("report", &here("data/winch.toml"), &["--json"]);
    assert_eq!(object(&plain).get("wire"), None);
}
