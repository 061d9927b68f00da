//! Where the keys of a design are written, for what is found out about them after reading.

use super::document::Document;
use std::collections::BTreeMap;
use toml::de::{DeTable, DeValue};

/// The file of a design and the line of each of its keys. Equal to any other: designs are equal if they say the same, wherever
/// it is written.
#[derive(Debug, Clone)]
pub struct Places {
    /// The file, or whatever name the caller gave the text.
    pub origin: String,
    /// By dotted key.
    lines: BTreeMap<String, usize>,
}

impl PartialEq for Places {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Places {
    pub(super) fn of(document: Document<'_>, table: &DeTable<'_>) -> Self {
        let mut places = Self { origin: document.origin.into(), lines: BTreeMap::new() };
        places.note(document, "", table);
        places
    }

    fn note(&mut self, document: Document<'_>, prefix: &str, table: &DeTable<'_>) {
        for (key, value) in table {
            let dotted = format!("{prefix}{}", key.get_ref());
            if let DeValue::Table(inner) = value.get_ref() {
                self.note(document, &format!("{dotted}."), inner);
            }
            self.lines.insert(dotted, document.line(key.span().start));
        }
    }

    /// The line of a dotted key, counted from 1; `None` if the design does not have it.
    pub fn line(&self, key: &str) -> Option<usize> {
        self.lines.get(key).copied()
    }
}
