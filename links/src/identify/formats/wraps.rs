//! Numbers of a table that wrap: the times of sending tell how often.

use super::{
    super::{
        column::{Column, Sighting},
        counters::rounds::Rounds,
        time::Nanoseconds,
    },
    table::Row,
};

/// Of the numbers, no more may come again with another time of sending.
const MOST_AGAIN: f64 = 0.1;
/// Numbers of so many values wrap.
const MODULI: [u64; 4] = [1 << 4, 1 << 8, 1 << 16, 1 << 32];

/// Numbers that wrap go on; numbers that repeat otherwise are refused.
pub(super) fn renumbered(rows: &mut [Row], notes: &mut Vec<String>) -> Result<(), String> {
    rows.sort_by_key(|row| (row.sent, row.number));
    let drops = || rows.windows(2).filter(|pair| pair[1].number < pair[0].number);
    if drops().next().is_none() {
        return Ok(());
    }
    let largest = rows.iter().map(|row| row.number).max().unwrap_or(0);
    let wraps = |modulus: u64| {
        drops().all(|pair| pair[0].number >= modulus / 4 * 3 && pair[1].number < modulus.div_ceil(4))
    };
    let usual = MODULI.into_iter().find(|modulus| *modulus > largest).filter(|modulus| wraps(*modulus));
    // Any other number must show itself more than once.
    let other = || {
        let own = largest.saturating_add(1);
        (own <= 1 << 32 && drops().nth(1).is_some() && wraps(own)).then_some(own)
    };
    if let Some(modulus) = usual.or_else(other) {
        let sighting = |row: &Row| Sighting { number: row.number as u32, time: row.sent };
        let column: Column = rows.iter().map(sighting).collect();
        let rounds = Rounds::of(&column, modulus);
        let survey = rounds.survey(&column);
        survey.check()?;
        if survey.jumps > 0 {
            notes.push("numbers jump against the time: the table may hold two runs".into());
        }
        notes.push(format!("numbers wrap at {modulus}: the times of sending tell how often"));
        let numbers: Vec<u64> = rounds.sent(column.iter()).map(|numbered| numbered.number).collect();
        rows.iter_mut().zip(numbers).for_each(|(row, number)| row.number = number);
        return Ok(());
    }
    let mut by_number: Vec<(u64, Nanoseconds)> = rows.iter().map(|row| (row.number, row.sent)).collect();
    by_number.sort_unstable();
    let again = by_number.windows(2).filter(|pair| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1).count();
    match again as f64 > MOST_AGAIN * rows.len() as f64 {
        true => Err(format!(
            "{again} of {} numbers come again with another time of sending: the table holds two runs, or the numbers wrap in a way that \
             cannot be followed; give one file per run",
            rows.len()
        )),
        false => Ok(()),
    }
}
