//! A room of the core imports only rooms below it: there is no circle among them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// What the crate's root offers of the rooms.
const AT_ROOT: [(&str, &str); 5] = [
    ("Age", "played"),
    ("DefaultInput", "played"),
    ("Number", "number"),
    ("Scalar", "scalar"),
    ("Tick", "tick"),
];

/// The first names of the paths after each `crate::` of a source text, without comments and unit tests.
fn imports(source: &str) -> BTreeSet<String> {
    let code: Vec<&str> = source.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let code = code.join("\n");
    let code = code.split("#[cfg(test)]").next().unwrap_or_default().to_owned();
    let mut names = BTreeSet::new();
    for path in code.split("crate::").skip(1) {
        let mut name = String::new();
        let (mut depth, mut is_first) = (0, true);
        for character in path.chars() {
            match character {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 1 => {
                    names.insert(std::mem::take(&mut name));
                    is_first = true;
                }
                _ if character.is_alphanumeric() || character == '_' => {
                    if is_first && depth <= 1 {
                        name.push(character);
                    }
                }
                _ if character.is_whitespace() && name.is_empty() => {}
                _ => is_first = false,
            }
            if depth == 0 && !is_first || depth < 0 || character == '}' && depth == 0 {
                break;
            }
        }
        names.insert(name);
    }
    names.remove("");
    names
}

/// Adds what the files at `path`, all of `room`, import.
fn read(path: &Path, room: &str, all: &mut BTreeMap<String, BTreeSet<String>>) {
    if path.is_dir() {
        for entry in fs::read_dir(path).expect("a folder of sources") {
            read(&entry.expect("an entry").path(), room, all);
        }
        return;
    }
    let source = fs::read_to_string(path).expect("a source");
    let named = |name: String| {
        let room = AT_ROOT.iter().find(|(offered, _)| *offered == name).map(|(_, room)| (*room).to_owned());
        room.unwrap_or(name)
    };
    let of_room = all.entry(room.to_owned()).or_default();
    of_room.extend(imports(&source).into_iter().map(named).filter(|name| name != room));
}

fn rooms() -> BTreeMap<String, BTreeSet<String>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src")).expect("the sources") {
        let path = entry.expect("an entry").path();
        let room = path.file_stem().and_then(|stem| stem.to_str()).expect("a name").to_owned();
        if room != "lib" {
            read(&path, &room, &mut all);
        }
    }
    let known: BTreeSet<String> = all.keys().cloned().collect();
    all.values_mut().for_each(|imported| imported.retain(|name| known.contains(name)));
    all
}

#[test]
fn what_a_source_imports_is_found() {
    let source = "use crate::{\n    Scalar, Tick,\n    wire::{self, can::Grid},\n    bank::InvalidLaw,\n};\n//! crate::event\n\
                  fn f() -> crate::blob::Shape { crate::arrival::f() }\n#[cfg(test)]\nuse crate::tuning;";
    let expected = ["Scalar", "Tick", "wire", "bank", "blob", "arrival"].map(str::to_owned);
    assert_eq!(imports(source), BTreeSet::from(expected));
}

#[test]
fn a_room_imports_only_rooms_below_it() {
    let mut rooms = rooms();
    assert!(rooms.len() > 15 && rooms["controller"].contains("estimator"), "{rooms:?}");
    // Whoever imports nothing that is left may be taken away; of a circle all would stay.
    while let Some(ground) =
        rooms.iter().find(|(_, imported)| imported.is_empty()).map(|(room, _)| room.clone())
    {
        rooms.remove(&ground);
        rooms.values_mut().for_each(|imported| {
            imported.remove(&ground);
        });
    }
    assert!(rooms.is_empty(), "in circles, or on top of them: {rooms:?}");
}
