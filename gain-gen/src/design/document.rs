//! Places in a design file: a [`Section`] is a table, a [`Field`] a value with its dotted key and line.
//!
//! Only here is TOML looked at. What a key means, and which values make sense, is decided by the callers.

use super::DesignError;
use nalgebra::DMatrix;
use std::ops::RangeInclusive;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Text of a design with the name it is reported under.
#[derive(Clone, Copy)]
pub(super) struct Document<'d> {
    pub(super) origin: &'d str,
    pub(super) text: &'d str,
}

impl Document<'_> {
    pub(super) fn error(&self, offset: usize, key: &str, found: String, allowed: String) -> DesignError {
        let line = Some(self.line(offset));
        DesignError { origin: self.origin.into(), line, key: key.into(), found, allowed }
    }

    /// The line of a byte, counted from 1.
    pub(super) fn line(&self, offset: usize) -> usize {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }
}

/// A table of the design: its dotted key and where that is written.
pub(super) struct Section<'d> {
    document: Document<'d>,
    key: String,
    offset: usize,
    table: &'d DeTable<'d>,
}

impl<'d> Section<'d> {
    /// The whole file. Errors: a key that is not in `allowed`.
    pub(super) fn root(
        document: Document<'d>,
        table: &'d DeTable<'d>,
        allowed: &[&str],
    ) -> Result<Self, DesignError> {
        Section { document, key: String::new(), offset: 0, table }.only(allowed)
    }

    /// Rejects the first key, in order of the file, that is not in `allowed`.
    fn only(self, allowed: &[&str]) -> Result<Self, DesignError> {
        let unknown = self.table.keys().filter(|key| !allowed.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(self) };
        let name = key.get_ref().as_ref();
        let advice = match nearest(name, allowed) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the keys here are {}", allowed.join(", ")),
        };
        let found = "no such key".to_string();
        let dotted = self.dotted(&name.escape_debug().to_string());
        Err(self.document.error(key.span().start, &dotted, found, advice))
    }

    /// The value of `name` if it is there. `meaning` completes the sentence "give ..".
    pub(super) fn optional(&self, name: &str, meaning: &'static str) -> Option<Field<'d>> {
        let (key, value) = self.table.get_key_value(name)?;
        Some(Field {
            document: self.document,
            key: self.dotted(name),
            offset: key.span().start,
            value: value.get_ref(),
            meaning,
        })
    }

    /// The value of `name`. `meaning` completes the sentence "give ..". Errors: the key is missing.
    pub(super) fn required(&self, name: &str, meaning: &'static str) -> Result<Field<'d>, DesignError> {
        self.optional(name, meaning)
            .ok_or_else(|| self.reject(&self.dotted(name), "missing".into(), format!("give {meaning}")))
    }

    /// An error about `key`, on the line where this table begins.
    pub(super) fn reject(&self, key: &str, found: String, allowed: String) -> DesignError {
        self.document.error(self.offset, key, found, allowed)
    }

    /// Dotted key of this table.
    pub(super) fn key(&self) -> &str {
        &self.key
    }

    fn dotted(&self, name: &str) -> String {
        if self.key.is_empty() { name.into() } else { format!("{}.{name}", self.key) }
    }
}

/// The key that was probably meant, if one is close enough.
fn nearest<'a>(name: &str, allowed: &[&'a str]) -> Option<&'a str> {
    let distance = |key: &str| strsim::damerau_levenshtein(name, key);
    let near = allowed.iter().copied().min_by_key(|key| distance(key))?;
    let close = near.len().div_ceil(3).min(name.len().max(near.len()) - 1);
    (distance(near) <= close).then_some(near)
}

/// A value of the design, with its dotted key, where it is written and what it should be.
#[derive(Clone)]
pub(super) struct Field<'d> {
    document: Document<'d>,
    key: String,
    offset: usize,
    value: &'d DeValue<'d>,
    meaning: &'static str,
}

impl<'d> Field<'d> {
    /// An error about this value; the allowed values are its meaning.
    pub(super) fn reject(&self, found: String) -> DesignError {
        self.reject_with(found, format!("give {}", self.meaning))
    }

    /// An error about this value with its own advice.
    pub(super) fn reject_with(&self, found: String, allowed: String) -> DesignError {
        self.document.error(self.offset, &self.key, found, allowed)
    }

    /// The table behind this key. Errors: no table, or one with a key that is not in `allowed`.
    pub(super) fn section(&self, allowed: &[&str]) -> Result<Section<'d>, DesignError> {
        let table = self.value.as_table().ok_or_else(|| self.unexpected())?;
        let (document, key, offset) = (self.document, self.key.clone(), self.offset);
        Section { document, key, offset, table }.only(allowed)
    }

    /// The value of `name` in the table behind this key, whose other keys are read elsewhere; `None` if there is none. Only
    /// for errors about it: it has no meaning of its own.
    pub(super) fn inner(&self, name: &str) -> Option<Field<'d>> {
        let (key, value) = self.value.as_table()?.get_key_value(name)?;
        Some(Field {
            key: format!("{}.{name}", self.key),
            offset: key.span().start,
            value: value.get_ref(),
            meaning: "",
            document: self.document,
        })
    }

    pub(super) fn is_text(&self) -> bool {
        self.value.is_str()
    }

    /// Errors: not a text.
    pub(super) fn text(&self) -> Result<&'d str, DesignError> {
        self.value.as_str().ok_or_else(|| self.unexpected())
    }

    /// Errors: not a truth value.
    pub(super) fn truth(&self) -> Result<bool, DesignError> {
        self.value.as_bool().ok_or_else(|| self.unexpected())
    }

    /// One of a few words. Errors: not a text, or none of these words.
    pub(super) fn choice<T: Copy>(&self, words: &[(&str, T)]) -> Result<T, DesignError> {
        let text = self.text()?;
        let chosen = words.iter().find(|(word, _)| *word == text);
        chosen.map(|(_, meaning)| *meaning).ok_or_else(|| self.unexpected())
    }

    /// Errors: not an integer, or outside `range`.
    pub(super) fn whole_number(&self, range: RangeInclusive<usize>) -> Result<usize, DesignError> {
        let integer = self.value.as_integer().ok_or_else(|| self.unexpected())?;
        usize::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .filter(|number| range.contains(number))
            .ok_or_else(|| self.unexpected())
    }

    /// Errors: not a number, or not finite.
    pub(super) fn number(&self) -> Result<f64, DesignError> {
        let number = match self.value {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|value| value as f64)
            }
            _ => None,
        };
        number.filter(|number: &f64| number.is_finite()).ok_or_else(|| self.unexpected())
    }

    /// A list of finite numbers. Errors: anything else, on the line of the first wrong entry.
    pub(super) fn numbers(&self) -> Result<Vec<f64>, DesignError> {
        let entries = self.value.as_array().ok_or_else(|| self.unexpected())?;
        let entries = entries.iter().enumerate();
        entries.map(|(at, entry)| self.finite(entry, || format!("entry {}", at + 1))).collect()
    }

    /// The entries of a list. Errors: not a list.
    pub(super) fn entries(&self) -> Result<Vec<Field<'d>>, DesignError> {
        let entries = self.value.as_array().ok_or_else(|| self.unexpected())?;
        Ok(entries.iter().map(|entry| self.entry(entry)).collect())
    }

    /// A list of texts, at least one. Errors: anything else, on the line of the first wrong entry.
    pub(super) fn texts(&self) -> Result<Vec<&'d str>, DesignError> {
        let entries = self.value.as_array().filter(|entries| !entries.is_empty());
        let entries = entries.ok_or_else(|| self.unexpected())?;
        entries.iter().map(|entry| self.entry(entry).text()).collect()
    }

    /// A list of lists of finite numbers, each of any length. Errors: anything else, on the line of the first wrong entry.
    pub(super) fn lists(&self) -> Result<Vec<Vec<f64>>, DesignError> {
        let entries = self.value.as_array().ok_or_else(|| self.unexpected())?;
        entries.iter().map(|entry| self.entry(entry).numbers()).collect()
    }

    /// A matrix, given as a list of rows of equal, nonzero length. Errors: anything else, on the line of the
    /// first wrong row or entry.
    pub(super) fn matrix(&self) -> Result<DMatrix<f64>, DesignError> {
        let rows = self.value.as_array().ok_or_else(|| self.unexpected())?;
        let (mut numbers, mut columns) = (Vec::new(), 0);
        for (i, spanned) in rows.iter().enumerate() {
            let place = self.entry(spanned);
            let Some(row) = spanned.get_ref().as_array() else {
                let found = format!("found {} as row {}", describe(spanned.get_ref()), i + 1);
                return Err(place.reject_with(found, "write a matrix as a list of rows: [[..], [..]]".into()));
            };
            if i == 0 {
                columns = row.len();
            }
            if row.is_empty() {
                return Err(
                    place.reject_with(format!("found no entry in row {}", i + 1), "give numbers".into())
                );
            }
            if row.len() != columns {
                let found = format!("found {} entries in row {}, {columns} in row 1", row.len(), i + 1);
                return Err(place.reject_with(found, "give rows of equal length".into()));
            }
            for (j, entry) in row.iter().enumerate() {
                numbers.push(self.finite(entry, || format!("row {}, column {}", i + 1, j + 1))?);
            }
        }
        if rows.is_empty() {
            return Err(self.reject("found an empty list".into()));
        }
        Ok(DMatrix::from_row_slice(rows.len(), columns, &numbers))
    }

    fn finite(
        &self,
        entry: &'d Spanned<DeValue<'d>>,
        place: impl Fn() -> String,
    ) -> Result<f64, DesignError> {
        let entry = self.entry(entry);
        entry.number().map_err(|_| {
            let found = format!("found {} as {}", describe(entry.value), place());
            entry.reject_with(found, "give a finite number".into())
        })
    }

    /// An entry of this list: reported under the same key, on its own line.
    fn entry(&self, value: &'d Spanned<DeValue<'d>>) -> Field<'d> {
        Field { offset: value.span().start, value: value.get_ref(), ..self.clone() }
    }

    fn unexpected(&self) -> DesignError {
        self.reject(format!("found {}", describe(self.value)))
    }
}

/// `1 state`, `3 states`.
pub(super) fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the text {text:?}"),
        DeValue::Integer(integer) => format!("the number {integer}"),
        DeValue::Float(float) => format!("the number {float}"),
        DeValue::Boolean(truth) => format!("the truth value {truth}"),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(list) if list.is_empty() => "an empty list".into(),
        DeValue::Array(_) => "a list".into(),
        DeValue::Table(_) => "a table".into(),
    }
}
