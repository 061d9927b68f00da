//! `host-sim robustness`: designs on networks that they were not made for.

use super::{
    Failure,
    options::{Amount, refused, wrong},
    progress,
};
use clap::Args;
use gain_gen::{console::print, design::Design, warnings};
use host_sim::{
    contender::{Contender, Kind},
    robustness::{self, Robustness},
    size_class,
};
use std::{fmt::Display, path::PathBuf};

#[derive(Args)]
pub(super) struct Options {
    /// Design files (TOML) with one plant and one cost.
    #[arg(required = true, value_name = "DESIGN")]
    designs: Vec<PathBuf>,
    /// The controller.
    #[arg(long, default_value = "slqg")]
    controller: Kind,
    #[command(flatten)]
    amount: Amount,
}

/// Simulates every design on the network of each, and prints.
pub(super) fn robustness(options: &Options) -> Result<(), Failure> {
    let Options { designs: paths, controller: kind, amount } = options;
    let input = |error: &dyn Display| Failure::Input(error.to_string());
    let designs: Vec<Design> = paths
        .iter()
        .map(|path| warnings::load(path).map_err(|error| input(&error)))
        .collect::<Result<_, _>>()?;
    robustness::check(&designs, *kind).map_err(|error| input(&error))?;
    let plan = amount.plan();
    let contender = |(design, path): (&Design, &PathBuf)| {
        size_class::check(design).map_err(|error| wrong(path, &error))?;
        Contender::new(*kind, design, plan.steps).map_err(|error| refused(&error, design, path))
    };
    let contenders: Vec<Contender> = designs.iter().zip(paths).map(contender).collect::<Result<_, _>>()?;
    let progress = progress(designs.len() * designs.len() * plan.runs, "runs");
    let table =
        Robustness::new(&designs, &contenders, plan, || progress.inc(1)).map_err(|error| input(&error))?;
    progress.finish_and_clear();
    match amount.json {
        true => {
            let json = serde_json::to_string_pretty(&table).expect("numbers and strings are always JSON");
            print(format_args!("{json}\n"))?
        }
        false => print(table.table())?,
    }
    Ok(())
}
