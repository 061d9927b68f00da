//! Figures and columns as every table on the terminal has them.

use std::fmt::Write;

/// Rows of cells in columns: the first `names` to the left, numbers to the right.
pub fn aligned(rows: &[Vec<String>], names: usize) -> String {
    let mut text = String::new();
    for row in rows {
        for (column, cell) in row.iter().enumerate() {
            let width = rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
            let between = if column == 0 { "" } else { "  " };
            // Writing to a string cannot fail.
            let _ = match column < names {
                true => write!(text, "{between}{cell:<width$}"),
                false => write!(text, "{between}{cell:>width$}"),
            };
        }
        text.push('\n');
    }
    text
}

/// Five significant digits, or what there is instead.
pub fn figure(value: Option<f64>) -> String {
    match value {
        None => "-".to_string(),
        Some(value) if value == 0.0 || (1e-3..1e6).contains(&value.abs()) => {
            let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
            format!("{value:.*}", (4 - digits).clamp(0, 8) as usize)
        }
        Some(value) => format!("{value:.4e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_five_digits_at_any_size() {
        assert_eq!(figure(Some(12345.678)), "12346");
        assert_eq!(figure(Some(1.2345678)), "1.2346");
        assert_eq!(figure(Some(0.0123456)), "0.012346");
        assert_eq!(figure(Some(1.2345678e9)), "1.2346e9");
        assert_eq!(figure(Some(0.0)), "0.0000");
        assert_eq!(figure(None), "-");
    }

    #[test]
    fn names_stand_to_the_left_and_numbers_to_the_right() {
        let rows = [vec!["a".to_string(), "1".to_string()], vec!["bcd".to_string(), "12".to_string()]];
        assert_eq!(aligned(&rows, 1), "a     1\nbcd  12\n");
    }
}
