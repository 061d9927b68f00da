//! Gains for the loops, and the linker set-up for the board: where memory is, and that cortex-m-rt's script lays out
//! the image.
//!
//! The set-up lives here rather than in a cargo configuration, so that host commands in the workspace stay plain.

use gain_gen::build::{Compile, compile};
use slqg::DefaultInput;
use std::env;
use std::fs;
use std::path::PathBuf;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    for design in ["pendulum", "pendulum_event"] {
        compile(format!("../../designs/{design}.toml"));
    }
    // Nothing proves that an axis stays bounded under limits, which its moves do not come near.
    for design in ["drive_tracking", "drive_event"] {
        Compile::new(format!("../../designs/{design}.toml")).accept_undecided_stability().run();
    }
    Compile::new("../../designs/double_integrator_bad.toml").sequence_length(6).name("integrator").run();
    // For solving again: the same plant and length on either link.
    Compile::new("../../designs/pendulum_bad.toml").run();
    Compile::new("../../designs/pendulum_bad.toml").sequence_length(4).name("pendulum_bad_4").run();
    Compile::new("../../designs/pendulum.toml").sequence_length(8).name("pendulum_8").run();
    // The pendulum's force held where the design has it fall to zero.
    let pendulum_hold = Compile::new("../../designs/pendulum.toml").default_input(DefaultInput::Hold);
    pendulum_hold.name("pendulum_hold").run();
    // Each step is counted for a short sequence and for a long one.
    for design in ["double_integrator", "critical", "pendulum", "drive_tracking", "pendulum_event"] {
        for length in [4, 8] {
            let compile = Compile::new(format!("../../designs/{design}.toml"));
            let compile = compile.sequence_length(length).name(format!("{design}_{length}"));
            compile.accept_undecided_stability().run();
        }
    }
    compile_over_schedule();
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        link_for_board();
    }
}

/// The event-triggered pendulum whose trigger takes later packets to follow a schedule.
fn compile_over_schedule() {
    let design = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"))
        .join("../../designs/pendulum_event.toml");
    println!("cargo:rerun-if-changed={}", design.display());
    let out =
        PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR")).join("pendulum_schedule.toml");
    let text = fs::read_to_string(&design).unwrap_or_else(|error| panic!("{}: {error}", design.display()));
    fs::write(&out, text + "base = \"auto\"\n").expect("OUT_DIR can be written");
    for length in [4, 8] {
        Compile::new(&out).sequence_length(length).name(format!("pendulum_schedule_{length}")).run();
    }
}

/// Puts `memory.x` where the linker looks (its working folder, the root of the workspace, must have none), and asks for cortex-m-rt's `link.x`, which includes it.
fn link_for_board() {
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let memory = root.join("memory.x");
    fs::copy(&memory, out.join("memory.x"))
        .unwrap_or_else(|error| panic!("cannot copy {}: {error}", memory.display()));
    println!("cargo:rerun-if-changed={}", memory.display());
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    // Sections need not be page-aligned in flash.
    println!("cargo:rustc-link-arg-bins=--nmagic");
}
