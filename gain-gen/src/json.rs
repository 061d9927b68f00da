//! JSON as it is laid out everywhere: to be read by people, too, with matrices as lists of rows.

use nalgebra::DMatrix;
use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};
use std::io::{self, Write};

/// A matrix as JSON and scripts take it: a list of rows.
pub(crate) type Rows = Vec<Vec<f64>>;

/// JSON with each field of an object on its own line and lists, which are matrices here, without breaks.
pub(crate) fn line_per_field(document: &impl Serialize) -> String {
    let mut bytes = Vec::new();
    write_line_per_field(&mut bytes, document).expect("names and numbers are written to memory");
    String::from_utf8(bytes).expect("JSON is UTF-8")
}

/// The same, written as it is made.
pub(crate) fn write_line_per_field(mut writer: impl Write, document: &impl Serialize) -> io::Result<()> {
    document.serialize(&mut Serializer::with_formatter(&mut writer, LinePerField { depth: 0 }))?;
    writer.write_all(b"\n")
}

struct LinePerField {
    depth: usize,
}

impl LinePerField {
    fn new_line<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| writer.write_all(b"  "))
    }
}

impl Formatter for LinePerField {
    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        self.new_line(writer)?;
        writer.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        self.new_line(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if first { Ok(()) } else { writer.write_all(b", ") }
    }
}

/// The matrix as rows; a matrix without columns as empty rows.
pub(crate) fn rows(matrix: &DMatrix<f64>) -> Rows {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// The rows of upper triangles that stand one after the other in `values`; `sizes`: rows of each.
pub(crate) fn triangles(mut values: &[f64], sizes: impl IntoIterator<Item = usize>) -> Vec<Rows> {
    let mut row = |length: usize| {
        let (row, rest) = values.split_at(length);
        values = rest;
        row.to_vec()
    };
    sizes.into_iter().map(|size| (1..=size).rev().map(&mut row).collect()).collect()
}

/// One object with the fields of all `objects`, texts of [`line_per_field`], one after the other.
pub(crate) fn joined(objects: &[&str]) -> String {
    let fields = |object: &&str| {
        let inner = object.trim_end().strip_prefix('{').and_then(|rest| rest.strip_suffix('}'));
        inner.expect("an object").trim_end().to_owned()
    };
    format!("{{{}\n}}\n", objects.iter().map(fields).collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::{joined, line_per_field, triangles};

    #[test]
    fn triangles_are_taken_apart_row_by_row() {
        let found = triangles(&[1.0, 2.0, 3.0, 4.0], [2, 1]);
        assert_eq!(found, [vec![vec![1.0, 2.0], vec![3.0]], vec![vec![4.0]]]);
        assert!(triangles(&[], []).is_empty());
    }

    #[test]
    fn joined_objects_read_as_one() {
        #[derive(serde::Serialize)]
        struct Pair {
            a: f64,
            b: Vec<f64>,
        }
        #[derive(serde::Serialize)]
        struct Single {
            c: Option<Pair>,
        }
        let pair = || Pair { a: 1.5, b: vec![0.25, 2.0] };
        let text = joined(&[&line_per_field(&pair()), &line_per_field(&Single { c: Some(pair()) })]);
        assert_eq!(
            text,
            "{\n  \"a\": 1.5,\n  \"b\": [0.25, 2.0],\n  \"c\": {\n    \"a\": 1.5,\n    \"b\": [0.25, 2.0]\n  }\n}\n"
        );
        assert!(serde_json::from_str::<serde_json::Value>(&text).is_ok());
    }
}
