//! `host-sim pil`: the loop with its ends on boards in an emulator.

use super::{
    Failure,
    options::{LinkBecomes, Outages, refused, wrong},
    progress,
};
use clap::Args;
use gain_gen::{
    console::{print, tell},
    design::{Authentication, Design},
    emit::{Output, design_id},
    report::Report,
    solve::Method,
    warnings,
};
use host_sim::{
    contender::{Contender, Kind},
    pil::{self, Board, Files, Pil, PilError, Plan, Replacement, Request, Restart, Setup, Transport},
    size_class::{self, dispatch},
};
use slqg::DefaultInput;
use std::{
    fmt::Display,
    path::{Path, PathBuf},
    time::Instant,
};

#[derive(Args)]
pub(super) struct Options {
    /// Design file (TOML).
    design: PathBuf,
    /// Inputs per packet, instead of the design's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..))]
    sequence_length: Option<u8>,
    /// What the actuator does when its buffer has run out, instead of the design's.
    #[arg(long, value_name = "zero|hold", value_parser = default_input)]
    default_input: Option<DefaultInput>,
    /// Control cycles.
    #[arg(long, value_name = "K", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1..))]
    cycles: u32,
    /// Seed of all random numbers.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// The boards.
    #[arg(long, value_enum, default_value_t = Board::Mps2An386)]
    board: Board,
    /// How frames get to the nodes.
    #[arg(long, value_enum, default_value_t = Transport::Bulk)]
    transport: Transport,
    /// Kill a node in a cycle and start it again some cycles later: controller@5000+10. May be given several times, in any
    /// order.
    #[arg(long = "restart", value_name = "NODE@CYCLE+AWAY", conflicts_with = "restarts")]
    restart: Vec<Restart>,
    /// Kill either node in so many random cycles, and start it again up to 10 cycles later.
    #[arg(long, value_name = "COUNT")]
    restarts: Option<usize>,
    /// Send the gains of this design to the controller while it runs. Those of another plant of the same dimensions, or for
    /// another length or default input, it must refuse.
    #[arg(long, value_name = "OTHER", requires = "gains_at")]
    gains_of: Option<PathBuf>,
    /// The cycle from which on they are sent, a part in each.
    #[arg(long, value_name = "K", requires = "gains_of")]
    gains_at: Option<usize>,
    /// The controller solves its own gains when its link has changed.
    #[arg(long, conflicts_with_all = ["gains_of", "restart", "restarts"])]
    tuning: bool,
    /// Slices of a solution that it does in each cycle.
    #[arg(long, value_name = "S", default_value_t = 4, requires = "tuning", value_parser = clap::value_parser!(u16).range(1..))]
    slices: u16,
    #[command(flatten)]
    becomes: LinkBecomes,
    #[command(flatten)]
    outages: Outages,
    /// Count the instructions of the controller's cycles.
    #[arg(long)]
    count: bool,
    /// Do not build the controller's program, but run this one.
    #[arg(long, value_name = "IMAGE", requires = "actuator_image")]
    controller_image: Option<PathBuf>,
    /// Do not build the actuator's program, but run this one.
    #[arg(long, value_name = "IMAGE", requires = "controller_image")]
    actuator_image: Option<PathBuf>,
    /// Write the nodes' logs to this folder, controller.log and actuator.log, all starts of a run one after the other;
    /// `defmt-print -e IMAGE` reads them. Without it they are kept if the run fails.
    #[arg(long, value_name = "FOLDER")]
    logs: Option<PathBuf>,
    /// Print one JSON object instead of text.
    #[arg(long)]
    json: bool,
}

fn default_input(text: &str) -> Result<DefaultInput, String> {
    match text {
        "zero" => Ok(DefaultInput::Zero),
        "hold" => Ok(DefaultInput::Hold),
        _ => Err("give zero or hold".to_owned()),
    }
}

/// A design with what the command line changes in it.
fn load(options: &Options, path: &Path) -> Result<Design, Failure> {
    let mut design = warnings::load(path).map_err(|error| Failure::Input(error.to_string()))?;
    if let Some(default_input) = options.default_input {
        design.set_default_input(default_input);
    }
    if let Some(length) = options.sequence_length {
        design.set_sequence_length(length.into());
    }
    Ok(design)
}

/// The gains of another design as a blob, and as a controller.
///
/// The node shows that it refuses what does not fit it. Only what could not be simulated beside it is refused here.
fn replacement(
    options: &Options,
    path: &Path,
    at: usize,
    run: &Design,
) -> Result<(Replacement, Design, Contender), Failure> {
    let design = load(options, path)?;
    let sizes = |Design { plant, .. }: &Design| [plant.states(), plant.inputs(), plant.outputs()];
    let (found, needed) = (sizes(&design), sizes(run));
    if found != needed {
        let plant = |[states, inputs, outputs]: [usize; 3]| {
            format!("{states} states, {inputs} inputs and {outputs} outputs")
        };
        let message = format!(
            "--gains-of: the plant has {}, that of {} {}; gains must be of a plant of the same dimensions",
            plant(found),
            options.design.display(),
            plant(needed)
        );
        return Err(wrong(path, &message));
    }
    size_class::check(&design).map_err(|error| wrong(path, &error))?;
    let contender = Contender::new(Kind::Slqg, &design, options.cycles as usize)
        .map_err(|error| refused(&error, &design, path))?;
    let report = Report::new(&design, Method::InFlight);
    // Of one file, whose path says nothing.
    let emission = report.emission().map_err(|error| wrong(path, &error))?;
    let files = Output::blob(path).files(&emission, "").map_err(|error| wrong(path, &error))?;
    let blob = files.into_iter().flat_map(|file| file.content).collect();
    let format = |Design { controller, .. }: &Design| {
        (controller.sequence_length, controller.default_input, controller.scalar)
    };
    // Feedforward and trigger belong to gains and are not in a blob: a node that has them takes none.
    let takes_any = run.tracking.is_none() && run.event.is_none();
    let fits = takes_any && design_id(&design) == design_id(run) && format(&design) == format(run);
    let replacement = Replacement::new(blob, fits, at, options.cycles as usize);
    Ok((replacement.map_err(|error| wrong(path, &error))?, design, contender))
}

/// Random restarts: most cycles a node is away.
const LONGEST_AWAY: usize = 10;

/// Runs the loop on boards and prints whether they did what the simulator did. A difference is a failure.
pub(super) fn pil(options: &Options) -> Result<(), Failure> {
    let input = |error: &dyn Display| Failure::Input(error.to_string());
    let design = load(options, &options.design)?;
    let wrong = |error: &dyn Display| wrong(&options.design, error);
    size_class::check(&design).map_err(|error| wrong(&error))?;
    let cycles = options.cycles as usize;
    let kind = if options.tuning { Kind::SlqgTuning } else { Kind::Slqg };
    let refuse = |error| refused(&error, &design, &options.design);
    let mut contender = Contender::new(kind, &design, cycles).map_err(refuse)?;
    contender.slices = options.slices.into();
    if let Some(change) = options.becomes.change(cycles, "--cycles", |other| load(options, other))? {
        contender.meet(change, &design).map_err(refuse)?;
    }
    contender.outages = options.outages.within(cycles, "--cycles")?;
    let restarts = match options.restarts {
        Some(count) => pil::at_random(count, cycles, LONGEST_AWAY, options.seed),
        None => pil::in_order(options.restart.clone(), cycles),
    };
    let restarts = restarts.map_err(|error| input(&error))?;
    let other = match options.gains_of.as_ref().zip(options.gains_at) {
        Some((path, at)) => Some(replacement(options, path, at, &design)?),
        None => None,
    };
    pil::find_emulator().map_err(|error| input(&error))?;

    let images = match options.controller_image.clone().zip(options.actuator_image.clone()) {
        Some((controller, actuator)) => [controller, actuator],
        None => pil::build(&Request {
            design: &options.design,
            sequence_length: options.sequence_length.map(usize::from),
            default_input: options.default_input,
            board: options.board,
            transport: options.transport,
            slices: options.tuning.then_some(options.slices.into()),
            is_sealed: design.authentication == Authentication::Cmac,
        })
        .map_err(|error| input(&error))?,
    };
    let setups = images.map(|image| Setup {
        image,
        board: options.board,
        transport: options.transport,
        counts: options.count,
    });
    let plan = Plan { cycles, seed: options.seed, setups, restarts };

    let files = Files::new(options.logs.as_deref()).map_err(|error| input(&error))?;
    let bar = progress(cycles, "cycles");
    let start = Instant::now();
    let run = Pil {
        design: &design,
        contender: &contender,
        plan: &plan,
        replacement: other.as_ref().map(|(replacement, design, contender)| (replacement, design, contender)),
        files: &files,
        done: || bar.inc(1),
    };
    let outcome = dispatch(&design, run).map_err(|error| wrong(&error))?;
    bar.finish_and_clear();
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(PilError::Unfit(error)) => return Err(wrong(&error)),
        Err(PilError::Node(error)) => {
            // The error names the log of the node.
            files.keep_logs();
            return Err(Failure::Run(error.to_string()));
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    if options.json {
        print(format_args!("{}\n", outcome.json()))?;
    } else {
        print(outcome.text())?;
        tell(format_args!("{:.0} cycles per second", cycles as f64 / seconds));
    }
    match outcome.failures().join("; ") {
        failures if failures.is_empty() => Ok(()),
        failures => {
            Err(Failure::Run(format!("{failures}; the nodes' logs: {}", files.keep_logs().display())))
        }
    }
}
