//! Names of the design's two files, and what names in them begin with.

use crate::emit::EmitError;
use std::path::{Path, PathBuf};

/// What is before names of functions if the file's own name cannot be.
const FALLBACK: &str = "design_";
/// What names in the files that all designs share begin with.
const SHARED: &str = "slqg_law";

#[derive(Debug, Clone, PartialEq)]
pub(in crate::emit) struct Names {
    pub(super) header: PathBuf,
    /// File name without `.h`.
    pub(super) stem: String,
    /// `motor` in `motor_init`.
    prefix: String,
}

impl Names {
    /// The names for a header at `path`.
    pub(in crate::emit) fn of(path: &Path) -> Result<Self, EmitError> {
        let refused =
            |advice: String| Err(EmitError::HeaderName { path: path.to_string_lossy().into_owned(), advice });
        let name = path.file_name().unwrap_or_default();
        if path.extension().is_none_or(|extension| extension != "h") {
            let mut proposed = PathBuf::from(name);
            proposed.set_extension("h");
            let proposed = if name.is_empty() { Path::new("motor.h") } else { &proposed };
            return refused(format!(
                "give a header, such as {proposed:?}; the source {:?} is written beside it",
                proposed.with_extension("c")
            ));
        }
        // An #include line takes a name as it is, without escapes. `?` could be part of a trigraph.
        let stem = Path::new(name).file_stem().and_then(|stem| stem.to_str());
        let Some(stem) = stem.filter(|stem| !stem.contains(|c: char| c.is_control() || "\"\\?".contains(c)))
        else {
            return refused("give a name without quotes, backslashes, `?` and control characters".into());
        };
        match prefix(stem) {
            prefix if prefix == SHARED => {
                refused(format!("{SHARED} is the law itself, for all designs: name it after the design"))
            }
            prefix => Ok(Self { header: path.into(), stem: stem.into(), prefix }),
        }
    }

    /// A file in the header's folder.
    pub(super) fn beside(&self, name: &str) -> PathBuf {
        self.header.with_file_name(name)
    }

    /// `text` with `@law@` and `@LAW@` replaced by what names of this design begin with.
    pub(super) fn fill(&self, text: &str) -> String {
        text.replace("@law@", &self.prefix).replace("@LAW@", &self.prefix.to_ascii_uppercase())
    }
}

/// The stem as the beginning of C identifiers: lower case, `_` for what they cannot contain. One that does not begin
/// with a letter goes after a word that does: other beginnings are no identifiers, or the compiler's own.
fn prefix(stem: &str) -> String {
    let name: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    if name.starts_with(|c: char| c.is_ascii_lowercase()) { name } else { format!("{FALLBACK}{name}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prefix_of(path: &str) -> String {
        Names::of(Path::new(path)).unwrap().prefix
    }

    #[test]
    fn names_begin_with_the_files_name() {
        assert_eq!(prefix_of("some/folder.d/motor.h"), "motor");
        assert_eq!(prefix_of("Left-Arm 2.v3.h"), "left_arm_2_v3");
        assert_eq!(prefix_of("2nd.h"), "design_2nd");
        assert_eq!(prefix_of("_motor.h"), "design__motor");
        assert_eq!(prefix_of("größe.h"), "gr__e");
        let names = Names::of(Path::new("a/motor.v2.h")).unwrap();
        assert_eq!(names.stem, "motor.v2");
    }

    #[test]
    fn a_name_that_is_no_headers_is_refused_with_one_that_is() {
        let advice = |path: &str| Names::of(Path::new(path)).unwrap_err().to_string();
        assert_eq!(
            advice("out/motor.c"),
            "--output: found \"out/motor.c\" for C; give a header, such as \"motor.h\"; the source \"motor.c\" is \
             written beside it"
        );
        for path in ["motor", "motor.hpp", ".h", "", "motor.H", ".."] {
            assert!(advice(path).contains("give a header, such as"), "{path}");
        }
        for path in ["a\"b.h", "a\\b.h", "what?.h", "a\nb.h"] {
            assert!(advice(path).contains("without quotes"), "{path}");
        }
        for path in ["slqg_law.h", "out/SLQG-Law.h"] {
            assert!(advice(path).contains("name it after the design"), "{path}");
        }
    }
}
