//! The design that the nodes run, and the linker set-up for their board.
//!
//! | variable | what it says | without it |
//! |---|---|---|
//! | `SLQG_DESIGN` | the design file, from the root of the workspace | `designs/pendulum.toml` |
//! | `SLQG_SEQUENCE_LENGTH` | inputs per sequence | as in the design |
//! | `SLQG_DEFAULT_INPUT` | `zero` or `hold` | as in the design |
//! | `SLQG_ACCEPT_UNDECIDED_STABILITY` | 1: a loop whose stability is undecided is built, too | it is refused |
//! | `SLQG_SLICES` | slices of a solution that a controller that tunes itself does in a cycle | 4 |
//! | `DEFMT_LOG` | least level of messages that are kept | `info` |
//! | `SLQG_KEYS` | a key file, or `test` for keys that everybody knows; with feature `authentication`, and only then | no guard |
//! | `SLQG_BOARD` | a folder of `boards/`, or `other`: the program for the board is another crate's | by the target |

use gain_gen::{
    build::Compile,
    design::{Authentication, Design, DeviceScalar},
    emit::design_id,
    joining::joining_covariance,
    keys::KeyFile,
};
use slqg::{DefaultInput, estimator::Merging};
use std::{
    env, fs,
    path::{Path, PathBuf},
};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if variable("DEFMT_LOG").is_none() {
        // Without it defmt keeps errors only.
        println!("cargo:rustc-env=DEFMT_LOG=info");
    }
    compile_design();
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        link_for_board();
    }
}

/// A variable, which makes this script run again when it changes.
fn variable(name: &str) -> Option<String> {
    println!("cargo:rerun-if-env-changed={name}");
    env::var(name).ok().filter(|value| !value.is_empty())
}

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env::var_os(name).unwrap_or_else(|| panic!("cargo sets {name}")))
}

/// Writes `design.rs`, and `dimensions.rs` with what a node needs to know beside it.
fn compile_design() {
    let path = variable("SLQG_DESIGN").unwrap_or_else(|| "designs/pendulum.toml".to_owned());
    // An absolute path stays as it is.
    let path = folder("CARGO_MANIFEST_DIR").join("../..").join(path);
    let mut compile = Compile::new(&path).name("design");
    if let Some(length) = variable("SLQG_SEQUENCE_LENGTH") {
        compile = compile.sequence_length(length.parse().unwrap_or_else(|_| {
            panic!("SLQG_SEQUENCE_LENGTH: found {length:?}; give the number of inputs per sequence")
        }));
    }
    if let Some(name) = variable("SLQG_DEFAULT_INPUT") {
        compile = compile.default_input(match name.as_str() {
            "zero" => DefaultInput::Zero,
            "hold" => DefaultInput::Hold,
            _ => panic!("SLQG_DEFAULT_INPUT: found {name:?}; give zero or hold"),
        });
    }
    if let Some(answer) = variable("SLQG_ACCEPT_UNDECIDED_STABILITY") {
        assert!(answer == "1", "SLQG_ACCEPT_UNDECIDED_STABILITY: found {answer:?}; give 1, or leave it out");
        compile = compile.accept_undecided_stability();
    }
    let compiled = compile.run_for_more();
    let design = &compiled.design;
    let controller = &design.controller;
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        assert!(
            controller.input_limits.is_some() || controller.is_unlimited,
            "{}: controller.input_limits: missing, and a device would apply whatever is computed; give one pair [least, greatest] \
             per input, or controller.unlimited_inputs = true if that is meant",
            path.display()
        );
    }
    let dimensions = format!(
        "/// Which plant the gains are for.\n\
         pub const DESIGN_ID: slqg::blob::DesignId = slqg::blob::DesignId({:#010x});\n\
         /// Outputs that follow a reference.\n\
         pub const TRACKED_OUTPUTS: usize = {};\n\
         /// Samples of the reference that make a difference.\n\
         pub const PREVIEW_SAMPLES: usize = {};\n\
         /// Slices of a solution in a cycle, of a controller that tunes itself.\n\
         pub const SLICES: usize = {};\n",
        design_id(design).0,
        compiled.tracked_outputs,
        compiled.preview_samples,
        slices(),
    ) + &joining_model(design);
    fs::write(folder("OUT_DIR").join("dimensions.rs"), dimensions).expect("OUT_DIR can be written");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        write_keys(design, &path);
    }
}

/// Writes `keys.rs` for a guard, which the nodes have if and only if the design says so.
fn write_keys(design: &Design, path: &Path) {
    assert!(
        design.estimator() != Merging::Linear || env::var_os("CARGO_FEATURE_LINEAR").is_some(),
        "{}: the estimator is \"linear\", as there are no acknowledgements: build with the feature `linear`",
        path.display()
    );
    assert!(
        !design.event.is_some_and(|event| event.may_pause())
            || env::var_os("CARGO_FEATURE_SCHEDULE").is_some(),
        "{}: [event] takes packets to be sent more rarely than always: build with the feature `schedule`",
        path.display()
    );
    let is_sealed = design.authentication == Authentication::Cmac;
    let (found, is_built) = (variable("SLQG_KEYS"), env::var_os("CARGO_FEATURE_AUTHENTICATION").is_some());
    if is_built != is_sealed || found.is_some() != is_sealed {
        let name = design.authentication.name();
        let advice = if is_sealed {
            "build with the feature `authentication`, and SLQG_KEYS=FILE with the loop's keys"
        } else {
            "build without the feature `authentication` and without SLQG_KEYS, or give \"cmac\""
        };
        panic!("{}: wire.authentication is {name:?}: {advice}", path.display());
    }
    let Some(keys) = found else { return };
    let keys = if keys == "test" {
        KeyFile::of_tests()
    } else {
        println!("cargo:rerun-if-changed={keys}");
        KeyFile::read(Path::new(&keys)).unwrap_or_else(|error| panic!("SLQG_KEYS: {error}"))
    };
    fs::write(folder("OUT_DIR").join("keys.rs"), keys.source()).expect("OUT_DIR can be written");
}

fn slices() -> usize {
    let found = variable("SLQG_SLICES").unwrap_or_else(|| "4".to_owned());
    match found.parse() {
        Ok(slices @ 1..) => slices,
        _ => panic!(
            "SLQG_SLICES: found {found:?}; give how many slices there is time for in a cycle, at least 1"
        ),
    }
}

/// The plant as it is for a controller that joins a loop that runs.
fn joining_model(design: &Design) -> String {
    let covariance = joining_covariance(&design.plant, design.controller.measurement_buffer);
    let number = |value: &f64| match design.controller.scalar {
        // The nearest one, as the simulator has it.
        DeviceScalar::F32 => format!("{:e}", *value as f32),
        DeviceScalar::F64 => format!("{value:e}"),
    };
    let columns: Vec<String> = covariance
        .column_iter()
        .map(|column| format!("[{}]", column.iter().map(number).collect::<Vec<_>>().join(", ")))
        .collect();
    format!(
        "/// The plant with what is known of its state by a controller that joins a loop that runs.\n\
         pub static JOINING: slqg::estimator::Model<\n\
             super::design::Scalar, {{ super::design::STATES }}, {{ super::design::INPUTS }}, \
             {{ super::design::OUTPUTS }},\n\
         > = slqg::estimator::Model {{\n\
             initial_mean: slqg::nalgebra::SMatrix::from_array_storage(slqg::nalgebra::ArrayStorage([\n\
                 [0.0; super::design::STATES],\n\
             ])),\n\
             initial_covariance: slqg::nalgebra::SMatrix::from_array_storage(slqg::nalgebra::ArrayStorage([\n\
                 {},\n\
             ])),\n\
             ..super::design::MODEL\n\
         }};\n\
         /// Checksums of the design as it is, and for a controller that joins.\n\
         #[allow(long_running_const_eval)]\n\
         pub const CHECKSUMS: [slqg::controller::Checksums; 2] = [\n\
             super::design::CHECKSUMS,\n\
             slqg::controller::Design {{ model: &JOINING, ..super::design::DESIGN }}.checksums(),\n\
         ];\n",
        columns.join(", ")
    )
}

/// Puts the board's memory map where the linker looks, and asks for cortex-m-rt's `link.x`, which includes it.
fn link_for_board() {
    let target = env::var("TARGET").expect("cargo sets TARGET");
    let board = variable("SLQG_BOARD").unwrap_or_else(|| match target.as_str() {
        "thumbv7em-none-eabihf" => "mps2_an386".to_owned(),
        "thumbv7m-none-eabi" => "lm3s6965evb".to_owned(),
        _ => panic!(
            "no board is known for {target}: set SLQG_BOARD to a folder of firmware/nodes/boards, or to other"
        ),
    });
    if board == "other" {
        return;
    }
    println!("cargo:rustc-cfg=board");
    println!("cargo:rustc-cfg=board=\"{board}\"");
    let memory = folder("CARGO_MANIFEST_DIR").join("boards").join(&board).join("memory.x");
    let out = folder("OUT_DIR");
    copy(&memory, &out.join("memory.x"));
    // The nodes have an interrupt table of their own, with one handler for all: nothing is to be named here.
    fs::write(out.join("device.x"), "").expect("OUT_DIR can be written");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    // Sections need not be page-aligned in flash.
    println!("cargo:rustc-link-arg-bins=--nmagic");
}

fn copy(from: &Path, to: &Path) {
    fs::copy(from, to).unwrap_or_else(|error| panic!("cannot copy {}: {error}", from.display()));
    println!("cargo:rerun-if-changed={}", from.display());
}
