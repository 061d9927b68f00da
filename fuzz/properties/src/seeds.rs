//! The bytes that fuzzing begins with, made on purpose: `fuzz/corpus` holds them as files.
//!
//! `cargo run -p slqg-properties --example seeds` writes them; a test compares. What a run has found is kept beside them, under
//! a name that says what was wrong.

mod actuator;
mod bus;
mod controller;
mod designs;
mod frames;
mod law;
mod logs;
mod node;

use std::path::{Path, PathBuf};

/// The bytes and what they are.
pub type Seed = (&'static str, Vec<u8>);

/// The seeds of every property.
pub fn all() -> Vec<(&'static str, Vec<Seed>)> {
    vec![
        ("actuator", actuator::seeds()),
        ("blob", law::blobs()),
        ("can", bus::seeds()),
        ("controller", controller::seeds()),
        ("design", designs::texts()),
        ("gains", law::over_the_link()),
        ("logs", logs::seeds()),
        ("node", node::seeds()),
        ("sealed", controller::sealed()),
        ("serial", frames::on_a_line()),
        ("service", frames::of_a_host()),
        ("solved", designs::made_up()),
        ("wire", frames::of_the_loop()),
    ]
}

/// Where they are kept: a folder for each property.
pub fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../corpus")
}

/// The file of a seed.
pub fn file(property: &str, seed: &str) -> PathBuf {
    corpus().join(property).join(seed).with_extension("seed")
}
