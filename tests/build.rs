//! Prepares the README's Rust snippets for the test that compiles and runs them: each as a file of its own, with the design that they
//! name.

use std::{env, fs, path::PathBuf};

/// Compiled as `motor`: a design that follows a reference, as the snippets show.
const DESIGN: &str = "../designs/drive_tracking.toml";
const README: &str = "../README.md";
/// How a snippet begins in the README.
const BEGINS: &str = "```rust\n";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={README}");
    gain_gen::build::Compile::new(DESIGN).name("motor").accept_undecided_stability().run();
    let text = fs::read_to_string(README).expect("the README");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let snippets: Vec<_> = text.split(BEGINS).skip(1).collect();
    for (number, rest) in (1..).zip(&snippets) {
        let (code, _) = rest.split_once("```").expect("a snippet ends");
        fs::write(out.join(format!("snippet_{number}.rs")), code).expect("OUT_DIR can be written");
    }
    // The test says how many it includes.
    println!("cargo:rustc-env=README_SNIPPETS={}", snippets.len());
}
