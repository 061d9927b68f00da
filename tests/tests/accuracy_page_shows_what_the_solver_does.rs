//! The errors on the page about accuracy are those of today: none is more than ten times as large.

use rayon::prelude::*;
use slqg_tests::accuracy::{Errors, Plant, collection, riccati_benchmark};

const PAGE: &str = include_str!("../../docs/accuracy.md");
/// Errors below some units in the last place come and go with the order of additions.
const ROUNDING: f64 = 1e-15;

/// The last three cells of the line that begins with these: errors of gain, cost and rate.
fn shown(cells: &str) -> [f64; 3] {
    let line = PAGE.lines().find(|line| line.starts_with(cells)).unwrap_or_else(|| panic!("no {cells}"));
    let figures: Vec<_> = line.trim_end_matches('|').rsplit('|').take(3).map(str::trim).collect();
    let figure = |at: usize| figures[at].parse().unwrap_or_else(|_| panic!("no figure: {line}"));
    [figure(2), figure(1), figure(0)]
}

fn holds(plant: &Plant, cells: &str) {
    let Errors { gain, rate, cost } = plant.errors().unwrap_or_else(|why| panic!("{}: {why}", plant.name));
    for (found, shown) in [gain, cost, rate].into_iter().zip(shown(cells)) {
        assert!(found <= 10.0 * shown.max(ROUNDING), "{cells} {found:e}, not {shown:e}");
    }
}

#[test]
fn errors_on_the_collection_are_what_the_page_says() {
    let plants = collection();
    let solved = plants.par_iter().filter(|plant| !plant.answer.refused);
    solved.for_each(|plant| holds(plant, &format!("| `{}` |", plant.name)));
}

#[test]
fn errors_on_the_riccati_benchmark_are_what_the_page_says() {
    riccati_benchmark()
        .par_iter()
        .for_each(|plant| holds(plant, &format!("| {} | {} |", plant.name, plant.parameter)));
}
