//! Prints the tables of `docs/accuracy.md`: how far gains, rate and cost are from the right ones.

use slqg_tests::accuracy::{Plant, collection, riccati_benchmark};

fn main() {
    for plant in collection() {
        println!("| `{}` | {} |", plant.name, figures(&plant));
    }
    for plant in riccati_benchmark() {
        println!("| {} | {} | {} |", plant.name, plant.parameter, figures(&plant));
    }
}

fn figures(plant: &Plant) -> String {
    match plant.errors() {
        Ok(errors) => format!("{:.1e} | {:.1e} | {:.1e}", errors.gain, errors.cost, errors.rate),
        Err(why) => format!("{} |  | ", why.lines().next().unwrap_or_default()),
    }
}
