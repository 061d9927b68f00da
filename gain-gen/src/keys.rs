//! Key files: the keys of a loop whose frames are sealed. They are apart from the design, and nothing prints what is in them.
//!
//! ```toml
//! loop_id = 1
//! measurement = "..."        # 32 hexadecimal digits each, of a source of random numbers
//! control = "..."
//! acknowledgement = "..."
//! clock = "..."
//! gains = "..."
//! ```

use slqg::authentication::{Association, Identity, Key, Keys, Session, Side};
use slqg::blob::DesignId;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// Names of the keys, in the order in which they are kept.
const NAMES: [&str; 5] = ["measurement", "control", "acknowledgement", "clock", "gains"];
const LOOP_ID: &str = "loop_id";

/// The keys of a loop. `Debug` tells none of them.
#[derive(Debug, Clone)]
pub struct KeyFile {
    /// Number of the loop among those that share keys.
    pub loop_id: u32,
    keys: [Secret; NAMES.len()],
    are_known: bool,
}

/// A key as digits, checked.
#[derive(Clone)]
struct Secret(String);

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Secret(..)")
    }
}

/// Why there are no keys. No message holds what is in the file.
#[derive(Debug, thiserror::Error)]
pub enum KeyFileError {
    /// It cannot be read.
    #[error("{}: cannot be read: {reason}; give a key file, docs/nodes.md says what is in one", path.display())]
    Unreadable {
        /// Which.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
    /// Others can read it.
    #[error("{}: others than its owner may read or write it (mode {mode:04o}); run: chmod 600 {}", path.display(), path.display())]
    Open {
        /// Which.
        path: PathBuf,
        /// Its mode.
        mode: u32,
    },
    /// It is not as it should be.
    #[error("{}: {problem}", path.display())]
    Wrong {
        /// Which.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        problem: String,
    },
}

impl KeyFile {
    /// Reads the keys in the file at `path`, which nobody but its owner may read or write.
    ///
    /// # Errors
    /// If it cannot be read, others may read it, or it does not hold each key once.
    pub fn read(path: &Path) -> Result<Self, KeyFileError> {
        let unreadable = |reason| KeyFileError::Unreadable { path: path.into(), reason };
        // What is looked at is what is read, whoever replaces the file meanwhile.
        let file = std::fs::File::open(path).map_err(unreadable)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let mode = file.metadata().map_err(unreadable)?.mode() & 0o7777;
            if mode & 0o077 != 0 {
                return Err(KeyFileError::Open { path: path.into(), mode });
            }
        }
        let text = std::io::read_to_string(file).map_err(unreadable)?;
        Self::parse(&text).map_err(|problem| KeyFileError::Wrong { path: path.into(), problem })
    }

    /// Keys for tests and emulators: everybody knows them.
    pub fn of_tests() -> Self {
        let keys = std::array::from_fn(|at| Secret(format!("{:032x}", 0xc0ff_ee00 + at as u128)));
        Self { loop_id: 1, keys, are_known: true }
    }

    /// One end of an association of the loop, for the plant `design`.
    pub fn session(&self, association: Association, side: Side, design: DesignId) -> Session {
        let identity = Identity { loop_id: self.loop_id, design };
        let [measurement, control, acknowledgement, clock, gains] = self
            .keys
            .each_ref()
            .map(|Secret(digits)| Key::from_hex(digits).expect("checked when it was read"));
        let keys = match association {
            Association::Sensing => Keys::one_way(measurement),
            Association::Loop => Keys { downstream: control, upstream: acknowledgement },
            Association::Timing => Keys::one_way(clock),
            Association::Service => Keys::one_way(gains),
        };
        Session::new(association, side, identity, keys)
    }

    /// The keys as Rust source, for build scripts of nodes. Whoever reads what is built knows them.
    pub fn source(&self) -> String {
        let mut text = format!(
            "const LOOP_ID: u32 = {};\n/// Whether everybody knows the keys.\nconst ARE_KNOWN: bool = {};\n",
            self.loop_id, self.are_known
        );
        for (name, Secret(digits)) in NAMES.iter().zip(&self.keys) {
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "const {}: slqg::authentication::Key = \
                 slqg::authentication::Key::from_hex({digits:?}).expect(\"checked by the build script\");",
                name.to_uppercase()
            );
        }
        text
    }

    fn parse(text: &str) -> Result<Self, String> {
        // The parser's own message would show the line, and with it perhaps a key.
        let line = |offset: usize| 1 + text.get(..offset).map_or(0, |before| before.matches('\n').count());
        let table = DeTable::parse(text).map_err(|error| {
            let line = line(error.span().map_or(0, |span| span.start));
            format!("line {line}: not TOML, or a key twice; give one `name = \"digits\"` a line")
        })?;
        let table = table.get_ref();
        let is_none = |name: &str| name != LOOP_ID && !NAMES.contains(&name);
        if let Some((name, _)) = table.iter().find(|(name, _)| is_none(name.get_ref())) {
            let line = line(name.span().start);
            return Err(format!(
                "line {line}: found a name that is none of a key file's; give {LOOP_ID}, {}",
                NAMES.join(", ")
            ));
        }
        let wrong = |name: &str, allowed: &str| match table.get(name) {
            Some(value) => {
                format!("line {}: {name}: found something else; give {allowed}", line(value.span().start))
            }
            None => format!("{name}: missing; give {allowed}"),
        };
        let loop_id = match table.get(LOOP_ID).map(|value| value.get_ref()) {
            Some(DeValue::Integer(number)) => u32::from_str_radix(number.as_str(), number.radix()).ok(),
            _ => None,
        };
        let loop_id = loop_id.ok_or_else(|| wrong(LOOP_ID, "the loop's number, 0 to 4294967295"))?;
        let mut keys = [const { Secret(String::new()) }; NAMES.len()];
        for (name, key) in NAMES.iter().zip(&mut keys) {
            match table.get(*name).map(|value| value.get_ref()) {
                Some(DeValue::String(digits)) if Key::from_hex(digits).is_some() => {
                    *key = Secret(digits.to_string());
                }
                _ => {
                    return Err(wrong(name, "32 hexadecimal digits in \"..\", as of `openssl rand -hex 16`"));
                }
            }
        }
        for (at, Secret(key)) in keys.iter().enumerate() {
            if let Some(other) = keys[..at].iter().position(|Secret(other)| other.eq_ignore_ascii_case(key)) {
                return Err(format!(
                    "{} and {} are the same key; give each one of its own",
                    NAMES[other], NAMES[at]
                ));
            }
        }
        Ok(Self { loop_id, keys, are_known: false })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(change: &[(&str, &str)]) -> String {
        let digit = |at: usize| format!("{at:x}").repeat(32);
        let mut text = "loop_id = 7\n".to_owned();
        for (at, name) in (10..).zip(NAMES) {
            text += &format!("{name} = \"{}\"\n", digit(at));
        }
        change.iter().fold(text, |text, (from, to)| text.replace(from, to))
    }

    #[test]
    fn a_key_file_holds_each_key_once_and_its_debug_form_none() {
        let file = KeyFile::parse(&text(&[])).unwrap();
        assert_eq!(file.loop_id, 7);
        let printed = format!("{file:?}");
        assert!(!printed.contains("aaaa") && !printed.contains("bbbb"), "{printed}");
        assert!(file.source().contains("const CONTROL: slqg::authentication::Key"));
    }

    #[test]
    fn a_wrong_key_file_is_refused_with_its_line_and_without_what_it_holds() {
        for (change, says) in [
            (("loop_id = 7\n", ""), "loop_id: missing; give the loop's number"),
            (("loop_id = 7", "loop_id = -7"), "line 1: loop_id: found something else"),
            (
                ("clock = \"d", "clock = \""),
                "line 5: clock: found something else; give 32 hexadecimal digits",
            ),
            (("control", "controll"), "line 3: found a name that is none of a key file's"),
            (("control = \"b", "control = b"), "line 3: not TOML"),
            (("dddd", "aaaa"), "measurement and clock are the same key"),
        ] {
            let error = KeyFile::parse(&text(&[change])).unwrap_err();
            assert!(error.contains(says), "{error}");
            assert!(!["aaaa", "bbbb", "dddd"].iter().any(|digits| error.contains(digits)), "{error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_key_file_that_others_can_read_is_refused() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("keys.toml");
        std::fs::write(&path, text(&[])).unwrap();
        for (mode, is_refused) in
            [(0o644, true), (0o640, true), (0o602, true), (0o600, false), (0o400, false)]
        {
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
            let read = KeyFile::read(&path);
            assert_eq!(read.is_err(), is_refused, "{mode:o}");
            if let Err(error) = read {
                assert!(
                    error.to_string().contains(&format!("(mode {mode:04o}); run: chmod 600 ")),
                    "{error}"
                );
            }
        }
        let missing = KeyFile::read(&folder.path().join("none")).unwrap_err().to_string();
        assert!(missing.contains("cannot be read"), "{missing}");
    }
}
