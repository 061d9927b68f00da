//! The sweep as a table for people: one line per length and default input.

use super::Sweep;
use crate::figure::{figure, grouped};
use core::fmt::{self, Display, Formatter};

/// Heads of the columns and their widths. The length and the default input before them are set apart.
const COLUMNS: [(&str, usize); 5] = [
    ("rate per step", 15),
    ("tr(P W) per step", 18),
    ("to the longest", 16),
    ("Lx, M, r", 15),
    ("coupled form", 18),
];

impl Display for Sweep {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let inputs: Vec<_> = self.default_inputs.iter().map(|&input| input.name()).collect();
        writeln!(
            f,
            "{}: default input {}, tables in {}\n",
            self.name.escape_debug(),
            inputs.join(" and "),
            self.scalar.name()
        )?;
        write!(f, "{:>5}  {:<8}{:<10}", "N", "default", "verdict")?;
        COLUMNS.iter().try_for_each(|(head, width)| write!(f, "{head:>width$}"))?;
        writeln!(f)?;
        for figures in &self.results {
            let (length, input) = (figures.sequence_length, figures.default_input.name());
            write!(f, "{length:>5}  {input:<8}{:<10}", figures.verdict.name())?;
            let relative = self.relative_cost(figures);
            let cells = [
                figure(figures.mean_square_rate),
                figure(figures.control_cost),
                relative.map_or_else(|| "-".into(), excess),
                self.size(figures.table_floats),
                self.size(figures.coupled_table_floats),
            ];
            cells.iter().zip(COLUMNS).try_for_each(|(cell, (_, width))| write!(f, "{cell:>width$}"))?;
            writeln!(f)?;
        }
        Ok(())
    }
}

impl Sweep {
    fn size(&self, floats: usize) -> String {
        format!("{} bytes", grouped(self.bytes(floats)))
    }
}

/// How much more than 1 a ratio is: in percent, or as a multiple where that is easier to read.
fn excess(ratio: f64) -> String {
    if ratio < 2.0 { format!("{:+.2} %", 100.0 * (ratio - 1.0)) } else { format!("x {}", figure(ratio)) }
}
