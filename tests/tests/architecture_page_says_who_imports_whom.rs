//! ARCHITECTURE.md says which room imports which, and no import leads back to where it began.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../ARCHITECTURE.md");
/// Items at the root of a crate that are some room's.
const AT_THE_ROOT: [(&str, &str); 5] = [
    ("Scalar", "scalar"),
    ("Tick", "tick"),
    ("Number", "number"),
    ("DefaultInput", "played"),
    ("Age", "played"),
];

type Imports = BTreeMap<String, BTreeSet<String>>;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The folders of sources that the page has tables for, with what each room may import.
fn told() -> Vec<(String, Imports)> {
    let mut folders: Vec<(String, Imports)> = Vec::new();
    for line in PAGE.lines() {
        if let Some(folder) = line.strip_prefix("## `").and_then(|rest| rest.strip_suffix('`')) {
            folders.push((folder.to_owned(), Imports::new()));
        } else if line.starts_with("## ") {
            folders.push((String::new(), Imports::new()));
        } else if let (Some((_, imports)), Some(row)) = (folders.last_mut(), line.strip_prefix("| `")) {
            let cells: Vec<&str> = row.split('|').collect();
            let [room, _, imported, ..] = cells[..] else { continue };
            let names = imported.split('`').skip(1).step_by(2).map(str::to_owned).collect();
            imports.insert(room.trim().trim_matches('`').to_owned(), names);
        }
    }
    folders.retain(|(folder, _)| !folder.is_empty());
    folders
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Names that follow `crate::` in a source, without comments and tests.
fn imported(source: &str) -> BTreeSet<String> {
    let code: String = source
        .lines()
        .take_while(|line| !line.contains("#[cfg(test)]"))
        .filter(|line| !line.trim_start().starts_with("//"))
        .flat_map(|line| [line, "\n"])
        .collect();
    let mut names = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        // `$crate` of a macro is somebody else's.
        if code[..at].ends_with(|before: char| before == '$' || before == '_' || before.is_alphanumeric()) {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        let Some(list) = rest.strip_prefix('{') else {
            names.insert(first_word(rest));
            continue;
        };
        let (mut depth, mut begun) = (0, 0);
        for (place, sign) in list.char_indices() {
            match sign {
                '{' => depth += 1,
                '}' if depth > 0 => depth -= 1,
                ',' | '}' if depth == 0 => {
                    names.insert(first_word(&list[begun..place]));
                    begun = place + 1;
                    if sign == '}' {
                        break;
                    }
                }
                _ => {}
            }
        }
    }
    names
}

fn first_word(text: &str) -> String {
    text.trim().chars().take_while(|sign| sign.is_alphanumeric() || *sign == '_').collect()
}

/// What the rooms of a folder import of each other.
fn found(folder: &str) -> Imports {
    let source = root().join(folder);
    let mut files = Vec::new();
    sources(&source, &mut files);
    let room_of = |file: &Path| {
        let first = file.strip_prefix(&source).expect("within").components().next().expect("a name");
        first.as_os_str().to_string_lossy().trim_end_matches(".rs").to_owned()
    };
    let mut imports = Imports::new();
    for file in files.iter().filter(|file| !["lib", "main", "bin"].contains(&&*room_of(file))) {
        let room = room_of(file);
        let text = std::fs::read_to_string(file).expect("a source");
        let of_room = imports.entry(room.clone()).or_default();
        for name in imported(&text) {
            let alias = AT_THE_ROOT.iter().find(|(item, _)| *item == name);
            of_room.insert(alias.map_or(name, |(_, room)| (*room).to_owned()));
        }
        of_room.remove(&room);
    }
    let rooms: BTreeSet<String> = imports.keys().cloned().collect();
    imports.values_mut().for_each(|names| names.retain(|name| rooms.contains(name)));
    imports
}

#[test]
fn every_room_imports_what_its_line_says_and_nothing_else() {
    let folders = told();
    assert!(folders.len() >= 3, "the page has no tables: {folders:?}");
    for (folder, told) in folders {
        let found = found(&folder);
        for (room, imports) in &found {
            let line = told.get(room);
            assert_eq!(
                Some(imports),
                line,
                "{folder}/{room}: found on the left, ARCHITECTURE.md says the right"
            );
        }
        assert_eq!(found.len(), told.len(), "{folder}: the page has a room that is not there");
    }
}

#[test]
fn no_import_leads_back_to_where_it_began() {
    for (folder, _) in told() {
        let mut left = found(&folder);
        // Rooms that import none that are left can lead nowhere.
        while let Some(room) = left
            .iter()
            .find(|(_, imports)| !imports.iter().any(|name| left.contains_key(name)))
            .map(|(room, _)| room.clone())
        {
            left.remove(&room);
        }
        assert!(left.is_empty(), "{folder}: a circle among {:?}", left.keys().collect::<Vec<_>>());
    }
}
