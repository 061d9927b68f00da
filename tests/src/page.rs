//! A page of the documentation whose figures are compared with what the tools find.

use gain_gen::design::Design;
use std::path::Path;

/// A page of `docs/`.
#[derive(Debug, Clone, Copy)]
pub struct Page {
    /// Name of the file.
    pub name: &'static str,
    /// What is in it.
    pub text: &'static str,
}

impl Page {
    /// Looks for `sentence`, wherever its lines break.
    ///
    /// # Panics
    /// If it is not there.
    pub fn says(&self, sentence: &str) {
        let spaced = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(spaced(self.text).contains(&spaced(sentence)), "not in docs/{}: {sentence}", self.name);
    }

    /// The lines of the indented block below a heading, without the spaces around them.
    pub fn block(&self, heading: &str) -> Vec<String> {
        let below = self.text.lines().skip_while(|line| *line != format!("## {heading}")).skip(1);
        let section = below.take_while(|line| !line.starts_with('#'));
        section.filter(|line| line.starts_with("    ")).map(|line| line.trim().to_string()).collect()
    }
}

/// A design of `designs/`.
///
/// # Panics
/// If there is none of that name.
pub fn design(name: &str) -> Design {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name);
    Design::load(&path.with_extension("toml")).expect("a design of the repository")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: Page =
        Page { name: "page.md", text: "# T\n\none\ntwo\n\n## a\n\n    1  2\n    3\n\n## b\n\n    4\n" };

    #[test]
    fn a_block_is_that_of_its_heading() {
        assert_eq!(PAGE.block("a"), ["1  2", "3"]);
        assert_eq!(PAGE.block("b"), ["4"]);
        assert!(PAGE.block("c").is_empty());
    }

    #[test]
    fn a_sentence_may_go_over_lines() {
        PAGE.says("one two");
        assert!(std::panic::catch_unwind(|| PAGE.says("two one")).is_err());
    }
}
