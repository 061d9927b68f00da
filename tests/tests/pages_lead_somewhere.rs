//! Citations and links lead to something: `THEORY n` to a section of `docs/theory.md`, links to files, and the index to every page.

use std::{
    fs,
    path::{Path, PathBuf},
};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every file of the project below `folder` with one of `endings`. What is built is not the project's, nor is what a hidden folder holds.
fn files(folder: &Path, endings: &[&str], found: &mut Vec<(PathBuf, String)>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let entry = entry.expect("an entry");
        let (path, kind) = (entry.path(), entry.file_type().expect("its kind"));
        let name = entry.file_name().to_string_lossy().into_owned();
        if kind.is_dir() && name != "target" && !name.starts_with('.') {
            files(&path, endings, found);
        } else if kind.is_file() && endings.iter().any(|ending| name.ends_with(ending)) {
            found.push((path.clone(), fs::read_to_string(path).expect("UTF-8")));
        }
    }
}

fn all(endings: &[&str]) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    files(&root(), endings, &mut found);
    assert!(!found.is_empty());
    found
}

/// Titles of the sections of `docs/theory.md`, by their number.
fn sections() -> Vec<String> {
    let text = fs::read_to_string(root().join("docs/theory.md")).expect("the page");
    let headings = text.lines().filter_map(|line| line.strip_prefix("## "));
    (1..)
        .zip(headings)
        .map(|(number, heading)| {
            let title = heading.strip_prefix(&format!("{number}. "));
            title.unwrap_or_else(|| panic!("docs/theory.md: {heading:?} is not section {number}")).to_owned()
        })
        .collect()
}

/// Numbers that follow `word` and a space in `text`, be it over the end of a comment's line.
fn cited(text: &str, word: &str) -> Vec<usize> {
    let number = |rest: &str| -> Option<usize> {
        let rest = rest.trim_start_matches([' ', '\n', '/', '!', '*']);
        let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
        digits.parse().ok()
    };
    text.split(word).skip(1).filter_map(number).collect()
}

#[test]
fn every_citation_of_the_theory_names_a_section() {
    let sections = sections();
    // Assembled, so that this file cites nothing by it.
    let word = ["THEO", "RY "].concat();
    let mut count = 0;
    for (path, text) in all(&[".rs", ".c", ".h", ".toml", ".md"]) {
        for number in cited(&text, &word) {
            assert!((1..=sections.len()).contains(&number), "{}: {word}{number}", path.display());
            count += 1;
        }
    }
    assert!(count > 40, "{count} citations were found");
    let theory = fs::read_to_string(root().join("docs/theory.md")).expect("the page");
    for number in cited(&theory, "section ") {
        assert!((1..=sections.len()).contains(&number), "docs/theory.md: section {number}");
    }
}

#[test]
fn a_citation_is_found_over_a_line_s_end() {
    assert_eq!(cited("see WORD 3, and WORD\n    /// 12. WORD x", "WORD"), [3, 12]);
}

#[test]
fn every_link_of_a_page_leads_to_a_file() {
    for (path, text) in all(&[".md"]) {
        let folder = path.parent().expect("a folder");
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let target = target.split('#').next().unwrap_or_default();
            let is_elsewhere = target.is_empty() || target.contains("://") || target.contains(' ');
            assert!(is_elsewhere || folder.join(target).exists(), "{}: {target}", path.display());
        }
    }
}

#[test]
fn the_index_names_every_page() {
    let index = fs::read_to_string(root().join("docs/README.md")).expect("the index");
    for entry in fs::read_dir(root().join("docs")).expect("the folder") {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        let is_listed = index.contains(&format!("]({name})")) || name == "README.md";
        assert!(is_listed || !name.ends_with(".md"), "docs/README.md does not name {name}");
    }
}

#[test]
fn files_that_the_bibliography_names_are_there() {
    let text = fs::read_to_string(root().join("docs/bibliography.md")).expect("the page");
    let named: Vec<_> = text.split('`').skip(1).step_by(2).filter(|name| name.contains('/')).collect();
    assert!(named.len() > 15, "{named:?}");
    for name in named {
        assert!(root().join(name).exists(), "docs/bibliography.md: {name}");
    }
}
