//! Who knows whom inside the crate, as far as it is promised: what is emitted knows no report, and what spells numbers and JSON knows
//! nobody.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

fn sources(path: &Path, found: &mut Vec<PathBuf>) {
    if path.is_dir() {
        for entry in fs::read_dir(path).expect("a folder") {
            sources(&entry.expect("an entry").path(), found);
        }
    } else if path.exists() {
        found.push(path.into());
    }
}

/// The rooms that a room's code names, tests and comments left out.
fn known_to(room: &str) -> BTreeSet<String> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&source.join(room), &mut files);
    sources(&source.join(room).with_extension("rs"), &mut files);
    assert!(!files.is_empty(), "there is no room {room}");
    let mut known = BTreeSet::new();
    for file in files {
        let text = fs::read_to_string(file).expect("UTF-8");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
        let code: String = lines.map(|line| format!("{line}\n")).collect();
        assert!(!code.contains("crate::{"), "one `use` for each room, or this test does not see it");
        let names = code.split("crate::").skip(1);
        known.extend(
            names.map(|rest| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()),
        );
    }
    known.remove(room);
    known
}

#[test]
fn what_is_emitted_knows_neither_reports_nor_who_asks_for_it() {
    let known = known_to("emit");
    assert!(known.contains("solve") && known.contains("json"), "{known:?}");
    for above in ["report", "build", "sweep", "margins", "certificate", "warnings"] {
        assert!(!known.contains(above), "emit knows {above}");
    }
    assert!(known_to("report").contains("emit"), "reports say what of them is emitted");
}

#[test]
fn what_spells_numbers_sentences_and_json_knows_nobody() {
    for room in ["json", "figure", "paragraph"] {
        assert_eq!(known_to(room), BTreeSet::new(), "{room}");
    }
}
