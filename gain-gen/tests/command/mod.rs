//! The command line as tests call it, and what it answers.

use assert_cmd::cargo::cargo_bin_cmd;
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// Runs `gain-gen COMMAND DESIGN OPTIONS..`.
pub(crate) fn gain_gen(command: &str, design: &Path, options: &[&str]) -> Output {
    cargo_bin_cmd!("gain-gen").arg(command).arg(design).args(options).output().expect("gain-gen starts")
}

pub(crate) fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

/// The object on stdout, which holds nothing else; parsing fails on anything after it.
pub(crate) fn object(output: &Output) -> Value {
    let value: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert!(value.is_object());
    value
}

/// Rows and columns; every entry must be a number.
pub(crate) fn shape(matrix: &Value) -> (usize, usize) {
    let rows = matrix.as_array().expect("a list of rows");
    let lengths: Vec<_> = rows
        .iter()
        .map(|row| {
            let row = row.as_array().expect("a row");
            assert!(row.iter().all(Value::is_number), "{row:?}");
            row.len()
        })
        .collect();
    assert!(lengths.windows(2).all(|pair| pair[0] == pair[1]), "rows differ in length");
    (rows.len(), lengths.first().copied().unwrap_or(0))
}

/// The design at `path` with each `from` replaced by its `to`, in a file of its own.
pub(crate) fn altered(folder: &Path, path: &Path, changes: &[(&str, &str)]) -> std::path::PathBuf {
    let mut design = std::fs::read_to_string(path).expect("a design");
    for (from, to) in changes {
        assert!(design.contains(from), "{} has no {from}", path.display());
        design = design.replacen(from, to, 1);
    }
    let path = folder.join("altered.toml");
    std::fs::write(&path, design).expect("a folder for files");
    path
}
