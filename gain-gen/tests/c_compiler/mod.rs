//! The system's C compiler, and laws for it. Tests that need one fail without it: nobody would notice that they did nothing.

use gain_gen::design::Design;
use gain_gen::emit::{self, write_all};
use gain_gen::report::Report;
use gain_gen::solve::Method;
use slqg::DefaultInput;
use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// What the law must compile under.
pub(crate) const STRICT: [&str; 13] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Werror",
    "-Wconversion",
    "-Wsign-conversion",
    "-Wdouble-promotion",
    "-Wshadow",
    "-Wundef",
    "-Wcast-qual",
    "-Wunused-macros",
    "-O2",
];

/// The compilers of C to test with: the system's own, and clang where there is one.
pub(crate) fn compilers() -> Vec<&'static str> {
    let has_clang = Command::new("clang").arg("--version").output().is_ok_and(|told| told.status.success());
    if has_clang { vec!["cc", "clang"] } else { vec!["cc"] }
}

/// Runs `compiler`, `cc` or `c++`, in `folder`.
///
/// # Panics
/// If there is none, with what to install.
pub(crate) fn run<A: AsRef<OsStr>>(compiler: &str, folder: &Path, arguments: &[A]) -> Output {
    Command::new(compiler).args(arguments).current_dir(folder).output().unwrap_or_else(|error| {
        panic!(
            "cannot run {compiler}: {error}.\nGenerated C is tested with the system's compiler; install one \
             (Debian: apt-get install gcc g++, Fedora: dnf install gcc gcc-c++, macOS: xcode-select --install)"
        )
    })
}

/// As [`run`], for what must compile.
pub(crate) fn compile<A: AsRef<OsStr>>(compiler: &str, folder: &Path, arguments: &[A]) {
    let output = run(compiler, folder, arguments);
    assert!(output.status.success(), "{compiler}: {}", String::from_utf8_lossy(&output.stderr));
}

/// What `program` prints, given `input`.
pub(crate) fn answer(program: &Path, input: &str) -> String {
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("cannot run {}: {error}", program.display()));
    let mut stdin = child.stdin.take().expect("piped");
    let input = input.to_string();
    // From a thread of its own: the program may wait for its answers to be read.
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().expect("it ends");
    writer.join().expect("no panic").expect("it reads all");
    assert!(output.status.success());
    String::from_utf8(output.stdout).expect("ASCII")
}

/// A file of this crate.
pub(crate) fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The report of a design, varied; the undecided stability of the crane, which has limits, is accepted.
pub(crate) fn solved(design: &str, length: Option<usize>, default_input: Option<DefaultInput>) -> Report {
    let mut design = Design::load(&here(design)).unwrap();
    design.controller.sequence_length = length.unwrap_or(design.controller.sequence_length);
    design.controller.default_input = default_input.unwrap_or(design.controller.default_input);
    let mut report = Report::new(&design, Method::InFlight);
    report.accept_undecided_stability();
    report
}

/// Writes the law of `report` as `law.h` and `law.c` into `folder`, with the files that all designs share.
pub(crate) fn emitted(report: &Report, folder: &Path) {
    let header = folder.join("law.h");
    write_all(&emit::Output::c(&header).unwrap().files(&report.emission().unwrap(), "test.toml").unwrap())
        .unwrap();
}
