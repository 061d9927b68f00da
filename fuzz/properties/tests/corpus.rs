//! The properties hold for the bytes that are kept, and these are what they are meant to be.

use slqg_properties::{PROPERTIES, seeds};
use std::collections::BTreeSet;
use std::path::Path;
use std::{fs, panic};

/// Bytes of all files together: what is kept is chosen, not gathered.
const MOST_BYTES: u64 = 200_000;

/// The files of a folder with this ending, by their names without it.
fn files(folder: &Path, ending: &str) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| path.extension().is_some_and(|found| found == ending))
        .map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned())
        .collect()
}

#[test]
fn every_property_holds_for_the_bytes_that_are_kept() {
    for (name, property) in PROPERTIES {
        let kept = files(&seeds::corpus().join(name), "seed");
        assert!(!kept.is_empty(), "{name}: nothing is kept");
        for seed in kept {
            let bytes = fs::read(seeds::file(name, &seed)).expect("a seed");
            let held = panic::catch_unwind(|| property(&bytes));
            assert!(held.is_ok(), "{name} does not hold for {seed}.seed; its message is above");
        }
    }
}

#[test]
fn seeds_are_what_their_recipes_make() {
    for (property, seeds) in seeds::all() {
        for (name, bytes) in seeds {
            let kept = fs::read(seeds::file(property, name)).unwrap_or_default();
            assert!(
                kept == bytes,
                "{property}/{name}.seed differs; if that is meant: cargo run -p slqg-properties --example seeds"
            );
        }
    }
}

#[test]
fn beside_the_seeds_there_are_only_regressions_and_all_together_is_little() {
    let mut bytes = 0;
    for (property, seeds) in seeds::all() {
        let made: BTreeSet<_> = seeds.iter().map(|(name, _)| (*name).to_owned()).collect();
        for found in files(&seeds::corpus().join(property), "seed") {
            assert!(
                made.contains(&found) || found.starts_with("regression_"),
                "{property}/{found}.seed: no recipe makes it; one that a run has found is called regression_.."
            );
            bytes += fs::metadata(seeds::file(property, &found)).expect("a seed").len();
        }
    }
    assert!(bytes <= MOST_BYTES, "{bytes} bytes are kept");
}

#[test]
fn every_property_is_run_by_a_program_for_libfuzzer() {
    let names: BTreeSet<_> = PROPERTIES.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(names, seeds::all().into_iter().map(|(name, _)| name.to_owned()).collect());
    let programs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz_targets");
    assert_eq!(names, files(&programs, "rs"));
    for name in names {
        let program = fs::read_to_string(programs.join(&name).with_extension("rs")).expect("a program");
        assert!(
            program.contains(&format!("slqg_properties::{name}::check")),
            "{name}.rs runs something else"
        );
    }
}
