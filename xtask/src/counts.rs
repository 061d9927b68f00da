//! A table of instruction counts as text: written, read, and compared with another one.
//!
//! Where counts come from is `target_bench`'s business.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

/// Part of a kept count that a new one may be off, both ways.
const BAND: f64 = 0.1;
/// Before the compiler's name.
const COMPILER: &str = "# compiler: ";

/// Instructions of one thing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Count {
    /// Words with single blanks between them: `loop` and case, or design, sequence length and step.
    pub(crate) name: String,
    /// Over the cycles that were counted.
    pub(crate) mean: u64,
    /// Of the longest cycle.
    pub(crate) longest: u64,
    /// What it cannot do without, in the longest cycle.
    pub(crate) multiply_adds: Option<u64>,
}

/// All counts of one run, and who compiled what was counted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Table {
    pub(crate) compiler: String,
    pub(crate) counts: Vec<Count>,
}

impl Table {
    /// What differs from a table that was kept, in words: counts out of their bands, counts missing, and new ones.
    pub(crate) fn strayed_from(&self, kept: &Self) -> Vec<String> {
        let of = |table: &Self, name: &str| table.counts.iter().find(|count| count.name == name).cloned();
        let mut strayed = Vec::new();
        for before in &kept.counts {
            match of(self, &before.name) {
                None => strayed.push(format!("{}: not counted any more", before.name)),
                Some(now) => {
                    let [mean, longest] = [(before.mean, now.mean), (before.longest, now.longest)]
                        .map(|(before, now)| now.abs_diff(before) as f64 > BAND * before as f64);
                    if mean || longest {
                        strayed.push(format!(
                            "{}: mean {}, was {}; longest {}, was {}",
                            before.name, now.mean, before.mean, now.longest, before.longest
                        ));
                    }
                }
            }
        }
        let new = self.counts.iter().filter(|count| of(kept, &count.name).is_none());
        strayed.extend(new.map(|count| format!("{}: not in the file", count.name)));
        strayed
    }
}

impl Display for Table {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "# Instructions on a Cortex-M4F, f32, as docs/counts.md explains them. Written by")?;
        writeln!(f, "#     cargo xtask bench target --update")?;
        writeln!(f, "{COMPILER}{}", self.compiler)?;
        let header = ["", "mean", "longest", "mul-adds", "ratio"];
        writeln!(f, "{:<44} {:>8} {:>8} {:>9} {:>6}", header[0], header[1], header[2], header[3], header[4])?;
        let mut group = "";
        for Count { name, mean, longest, multiply_adds } in &self.counts {
            let own = name.rsplit_once(' ').map_or("", |(group, _)| group);
            if own != group {
                writeln!(f)?;
                group = own;
            }
            write!(f, "{name:<44} {mean:>8} {longest:>8}")?;
            if let Some(least) = multiply_adds {
                write!(f, " {least:>9} {:>6.1}", *longest as f64 / *least as f64)?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

impl FromStr for Table {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let compiler = text.lines().find_map(|line| line.strip_prefix(COMPILER));
        let compiler = compiler.ok_or_else(|| format!("no line begins with {COMPILER:?}"))?.to_owned();
        let lines = (1..).zip(text.lines());
        let rows = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with(['#', ' ']));
        let count = |(number, line): (usize, &str)| {
            row(line).ok_or_else(|| format!("line {number}, {line:?}: not a name, mean and longest"))
        };
        Ok(Self { compiler, counts: rows.map(count).collect::<Result<_, _>>()? })
    }
}

/// A name of two or three words, mean, longest, and perhaps multiply-adds with their ratio.
fn row(line: &str) -> Option<Count> {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let (name, numbers) = words.split_at_checked(if words.first() == Some(&"loop") { 2 } else { 3 })?;
    let (mean, longest, rest) = match numbers {
        [mean, longest, rest @ ..] => (mean.parse().ok()?, longest.parse().ok()?, rest),
        _ => return None,
    };
    let multiply_adds = match rest {
        [] => None,
        [least, _ratio] => Some(least.parse().ok()?),
        _ => return None,
    };
    Some(Count { name: name.join(" "), mean, longest, multiply_adds })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let count = |name: &str, mean, longest, multiply_adds| Count {
            name: name.into(),
            mean,
            longest,
            multiply_adds,
        };
        let counts = vec![
            count("loop pendulum", 9000, 30000, None),
            count("pendulum 8 law", 300, 310, Some(88)),
            count("pendulum 8 decode-control", 900, 900, None),
        ];
        Table { compiler: "a compiler".into(), counts }
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        assert_eq!(table().to_string().parse(), Ok(table()));
    }

    #[test]
    fn a_count_may_stray_by_a_tenth_and_no_further_either_way() {
        for (mean, within) in [(330, true), (331, false), (270, true), (269, false)] {
            let mut now = table();
            now.counts[1].mean = mean;
            let strayed = now.strayed_from(&table());
            assert_eq!(strayed.is_empty(), within, "{mean}: {strayed:?}");
            assert!(within || strayed[0].starts_with("pendulum 8 law: "), "{strayed:?}");
        }
    }

    #[test]
    fn counts_that_are_missing_or_new_are_named() {
        let mut fewer = table();
        let gone = fewer.counts.pop().expect("not empty");
        assert_eq!(fewer.strayed_from(&table()), [format!("{}: not counted any more", gone.name)]);
        assert_eq!(table().strayed_from(&fewer), [format!("{}: not in the file", gone.name)]);
    }

    #[test]
    fn a_line_that_is_no_count_is_named() {
        let error = format!("{}pendulum 8 law 300\n", table()).parse::<Table>().unwrap_err();
        assert!(error.contains("pendulum 8 law 300"), "{error}");
        assert!("".parse::<Table>().is_err());
    }
}
