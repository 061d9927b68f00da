//! From the TOML parser's complaint to a design error: line, and the dotted key as far as it can be told.

use super::DesignError;
use super::document::Document;
use toml::de::{DeTable, DeValue, Error};

/// `error` about the text of `document` as an error of the design.
pub(super) fn rejected(document: Document<'_>, error: &Error) -> DesignError {
    let span = error.span().unwrap_or(0..0);
    let message = error.message().trim();
    let inside = |span: std::ops::Range<usize>| document.text.get(span).unwrap_or_default();
    if message.starts_with("duplicate key") {
        let name = inside(span.clone());
        let header =
            inside(0..span.start).rsplit('\n').next().is_some_and(|line| line.trim_start().starts_with('['));
        let mut key = if header { String::new() } else { enclosing(document.text, span.start) };
        key.extend(name.escape_debug());
        return document.error(span.start, &key, "found this key twice".into(), "give it once".into());
    }
    let key = enclosing(document.text, span.start);
    let found = format!("not TOML: {}", message.replace('\n', ", "));
    let allowed = "mend the syntax (strings in \"..\", lists in [..], one key = value a line)".into();
    document.error(span.start, key.trim_end_matches('.'), found, allowed)
}

/// Dotted key, with a dot at its end, of the table that is written at `offset`; empty at top level.
fn enclosing(text: &str, offset: usize) -> String {
    let (recovered, _) = DeTable::parse_recoverable(text);
    let (mut key, mut table) = (String::new(), recovered.get_ref());
    loop {
        let around = table.iter().filter_map(|(name, value)| match value.get_ref() {
            // The span of a `[table]` covers its header only: all that follows belongs to it.
            DeValue::Table(inner)
                if value.span().contains(&offset)
                    || text.get(value.span()).is_some_and(|header| header.starts_with('[')) =>
            {
                (name.span().start < offset).then_some((name, inner))
            }
            _ => None,
        });
        let Some((name, inner)) = around.max_by_key(|(name, _)| name.span().start) else { return key };
        key = format!("{key}{}.", name.get_ref().escape_debug());
        table = inner;
    }
}
