//! `host-sim bus`: the bus of a design in one run of the loop.

use super::{
    Failure,
    options::{refused, wrong},
};
use clap::Args;
use gain_gen::{console::print, emit, warnings};
use host_sim::{
    bus_report,
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    size_class,
};
use std::{fmt::Display, path::PathBuf};

#[derive(Args)]
pub(super) struct Options {
    /// Design file (TOML) with links on a bus.
    design: PathBuf,
    /// Control cycles.
    #[arg(long, value_name = "K", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Seed of all random numbers.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Also write every frame with its fate to this file, comma-separated.
    #[arg(long, value_name = "FILE.csv")]
    frames: Option<PathBuf>,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
}

/// Runs the loop once and prints what became of the bus.
pub(super) fn bus(options: &Options) -> Result<(), Failure> {
    let Options { design: path, steps, seed, frames, json } = options;
    let mut design = warnings::load(path).map_err(|error| Failure::Input(error.to_string()))?;
    let wrong = |error: &dyn Display| wrong(path, error);
    let Some(plan) = &mut design.network.bus else {
        return Err(wrong(
            &"network.can: missing: no link is on a bus; give links as { can = { identifier = .. } }",
        ));
    };
    plan.settings.log = frames.is_some();
    size_class::check(&design).map_err(|error| wrong(&error))?;
    let plan = Plan { runs: 1, steps: *steps as usize, seed: *seed };
    let contender =
        Contender::new(Kind::Slqg, &design, plan.steps).map_err(|error| refused(&error, &design, path))?;
    let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
    let outcome = simulate.outcome().map_err(|error| wrong(&error))?;
    let bus = outcome.bus.as_ref().expect("the design has a bus");
    if let Some((file, text)) = frames.as_ref().zip(bus_report::frames(bus)) {
        emit::write(file, &text).map_err(|error| {
            Failure::Input(format!("{}: cannot write the frames: {error}", file.display()))
        })?;
    }
    match json {
        true => print(format_args!("{}\n", bus_report::json(&design, bus)))?,
        false => print(bus_report::text(&design, bus, &outcome))?,
    }
    Ok(())
}
