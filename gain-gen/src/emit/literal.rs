//! Numbers and tables as literals of Rust and C in the device's scalar, by the shortest text that reads back the same.

use super::EmitError;
use crate::design::DeviceScalar;
use nalgebra::DMatrix;

/// Width of a line of numbers.
const WIDTH: usize = 100;

/// One table of numbers on its way to the device.
#[derive(Clone, Copy)]
pub(super) struct Table {
    /// As errors name it.
    pub(super) name: &'static str,
    pub(super) scalar: DeviceScalar,
}

impl Table {
    /// `value` rounded to the device's scalar.
    pub(super) fn number(self, value: f64) -> Result<String, EmitError> {
        self.fits(value)?;
        Ok(match self.scalar {
            DeviceScalar::F32 => format!("{:?}", value as f32),
            DeviceScalar::F64 => format!("{value:?}"),
        })
    }

    /// Whether `value` is finite in the device's scalar.
    pub(super) fn fits(self, value: f64) -> Result<(), EmitError> {
        let finite = match self.scalar {
            DeviceScalar::F32 => (value as f32).is_finite(),
            DeviceScalar::F64 => value.is_finite(),
        };
        if finite { Ok(()) } else { Err(self.refused(value)) }
    }

    /// [`Table::number`] as a literal of C: there, a number without suffix is a `double`.
    pub(super) fn c_number(self, value: f64) -> Result<String, EmitError> {
        let suffix = match self.scalar {
            DeviceScalar::F32 => "f",
            DeviceScalar::F64 => "",
        };
        Ok(self.number(value)? + suffix)
    }

    /// As [`Table::number`], but a number that is not zero must not become zero.
    pub(super) fn nonzero(self, value: f64) -> Result<(), EmitError> {
        let vanishes = self.scalar == DeviceScalar::F32 && value != 0.0 && value as f32 == 0.0;
        if vanishes { Err(self.refused(value)) } else { Ok(()) }
    }

    fn refused(self, value: f64) -> EmitError {
        let advice = match self.scalar {
            DeviceScalar::F32 => "choose other units or controller.scalar = \"f64\"",
            DeviceScalar::F64 => "choose other units",
        };
        EmitError::OutOfRange { table: self.name, value, scalar: self.scalar.name(), advice }
    }

    /// `values` in lines of `indent` spaces, each number followed by a comma; a new line for every `row` numbers.
    pub(super) fn lines(self, values: &[f64], row: usize, indent: usize) -> Result<String, EmitError> {
        let mut text = String::new();
        for numbers in values.chunks(row.max(1)) {
            let numbers = numbers.iter().map(|&value| self.number(value)).collect::<Result<Vec<_>, _>>()?;
            text.push_str(&wrapped(&numbers, indent));
        }
        Ok(text)
    }

    /// `values` as the initialiser of a C array that is indented by `indent`.
    pub(super) fn c_list<'v>(
        self,
        values: impl IntoIterator<Item = &'v f64>,
        indent: usize,
    ) -> Result<String, EmitError> {
        let numbers: Result<Vec<_>, _> = values.into_iter().map(|&value| self.c_number(value)).collect();
        let numbers = numbers?;
        let line = format!("{{{}}}", numbers.join(", "));
        if indent + line.len() < WIDTH {
            return Ok(line);
        }
        Ok(format!("{{\n{}{:indent$}}}", wrapped(&numbers, indent + 4), ""))
    }

    /// The rows of `matrix` as the initialiser of a C array of arrays.
    pub(super) fn c_rows(self, matrix: &DMatrix<f64>) -> Result<String, EmitError> {
        let mut text = String::from("{\n");
        for row in matrix.row_iter() {
            text.push_str(&format!("    {},\n", self.c_list(row.iter(), 4)?));
        }
        Ok(text + "}")
    }

    /// The rows of `matrix`, as [`Table::lines`].
    pub(super) fn rows(self, matrix: &DMatrix<f64>, indent: usize) -> Result<String, EmitError> {
        self.lines(matrix.transpose().as_slice(), matrix.ncols(), indent)
    }

    /// `matrix` as the storage of a static matrix: an array of columns.
    pub(super) fn columns(self, matrix: &DMatrix<f64>, indent: usize) -> Result<String, EmitError> {
        let mut text = String::from("[\n");
        for column in matrix.column_iter() {
            let numbers: Result<Vec<_>, _> = column.iter().map(|&value| self.number(value)).collect();
            text.push_str(&format!("{:1$}[{2}],\n", "", indent + 4, numbers?.join(", ")));
        }
        text.push_str(&format!("{:indent$}]", ""));
        Ok(text)
    }
}

/// `numbers` with a comma behind each, in lines of `indent` spaces that are broken at the width.
fn wrapped(numbers: &[String], indent: usize) -> String {
    let mut text = String::new();
    let mut line = String::new();
    for number in numbers {
        if !line.is_empty() && indent + line.len() + number.len() + 2 > WIDTH {
            text.push_str(&format!("{:indent$}{line}\n", ""));
            line.clear();
        }
        line.push_str(if line.is_empty() { "" } else { " " });
        line.push_str(number);
        line.push(',');
    }
    text + &format!("{:indent$}{line}\n", "")
}

#[cfg(test)]
mod tests {
    use super::*;

    const SINGLE: Table = Table { name: "lx", scalar: DeviceScalar::F32 };
    const DOUBLE: Table = Table { name: "lx", scalar: DeviceScalar::F64 };

    #[test]
    fn a_literal_reads_back_as_the_rounded_number() {
        for value in [0.1, -0.0, 1.0, 16_777_217.0, 3.046_174_197_867_086e-6, -1e30, 1e-40, 123_456_789.0] {
            let text = SINGLE.number(value).unwrap();
            assert_eq!(text.parse::<f32>().unwrap().to_bits(), (value as f32).to_bits(), "{text}");
            assert!(text.contains(['.', 'e']), "{text} would be an integer");
            assert_eq!(DOUBLE.number(value).unwrap().parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
        assert_eq!(SINGLE.number(0.1).unwrap(), "0.1");
    }

    #[test]
    fn what_the_scalar_cannot_hold_is_refused() {
        assert!(SINGLE.number(1e39).is_err());
        assert!(DOUBLE.number(1e39).is_ok());
        assert!(DOUBLE.number(f64::NAN).is_err());
        assert!(SINGLE.nonzero(1e-50).is_err());
        assert!(SINGLE.nonzero(0.0).is_ok());
        assert!(DOUBLE.nonzero(1e-50).is_ok());
    }

    #[test]
    fn a_long_row_is_broken_within_the_width() {
        let values = [1.0 / 3.0; 40];
        let text = DOUBLE.lines(&values, 40, 8).unwrap();
        assert!(text.lines().all(|line| line.len() <= WIDTH && line.starts_with("        0.3")));
        assert_eq!(text.matches(',').count(), 40);
    }

    #[test]
    fn a_literal_of_c_names_its_type() {
        assert_eq!(SINGLE.c_number(1e-40).unwrap(), "1e-40f");
        assert_eq!(DOUBLE.c_number(2.0).unwrap(), "2.0");
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(SINGLE.c_rows(&matrix).unwrap(), "{\n    {1.0f, 2.0f},\n    {3.0f, 4.0f},\n}");
        let long = DOUBLE.c_rows(&DMatrix::from_element(1, 20, 1.0 / 3.0)).unwrap();
        assert!(long.starts_with("{\n    {\n        0.3") && long.ends_with(",\n    },\n}"), "{long}");
        assert_eq!(DOUBLE.c_list(&[0.5, 0.25], 0).unwrap(), "{0.5, 0.25}");
    }

    #[test]
    fn storage_is_column_by_column() {
        let matrix = DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let text = SINGLE.columns(&matrix, 0).unwrap();
        assert_eq!(text, "[\n    [1.0, 4.0],\n    [2.0, 5.0],\n    [3.0, 6.0],\n]");
        assert_eq!(SINGLE.rows(&matrix, 2).unwrap(), "  1.0, 2.0, 3.0,\n  4.0, 5.0, 6.0,\n");
    }
}
