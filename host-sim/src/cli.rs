//! Command line: `host-sim run`, `host-sim sweep`, `host-sim identify` and `host-sim node`.
//!
//! Exit status: 0 done; 2 the input is wrong; 3 the loop cannot be stabilised.

use clap::{Args, Parser, Subcommand, ValueEnum};
use gain_gen::{
    design::{Acknowledgement, DelayDistribution, Design, Link},
    emit,
    lengths::Lengths,
    report::Report,
    solve::Method,
};
use host_sim::{
    bus_report,
    contender::{Contender, ContenderError, Kind},
    identify,
    monte_carlo::{Outcome, Plan, Simulate},
    node::{self, NodeError},
    output::{self, Pictures, Simulation},
    robustness::{self, Robustness},
    size_class::{self, dispatch},
};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slqg::estimator::Merging;
use std::{
    fmt::Display,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Simulates a closed loop over links that lose and delay packets, with the code that runs on the device.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a design many times and compare controllers.
    Run {
        #[command(flatten)]
        options: Options,
        /// Inputs per sequence, instead of the design's.
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=128))]
        sequence_length: Option<u16>,
        #[command(flatten)]
        pictures: Pictures,
    },
    /// Simulate a design with sequences of several lengths.
    ///
    /// A length with which a controller cannot stabilise the loop is told on stderr and has no row; the status is 0 if
    /// there is any row.
    Sweep {
        #[command(flatten)]
        options: Options,
        /// Lengths, 1 to 128: 4, 1..=12, 1..13 or 1,2,4,8
        #[arg(long, value_name = "RANGE")]
        lengths: Lengths,
        #[command(flatten)]
        pictures: Pictures,
    },
    /// Designs that differ in their network, each simulated on the network of each: what it costs when the link is not what
    /// was assumed.
    Robustness {
        /// Design files (TOML) with one plant and one cost.
        #[arg(required = true, value_name = "DESIGN")]
        designs: Vec<PathBuf>,
        /// The controller.
        #[arg(long, default_value = "slqg")]
        controller: Kind,
        #[command(flatten)]
        amount: Amount,
    },
    /// The CAN bus of a design in one run of the loop: load, fates and response times of all messages, delays.
    Bus {
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
    },
    /// Logs of a link to the delays of a design file, with confidence intervals and what speaks against them.
    Identify(identify::Options),
    /// One node of the loop in real time: controller, actuator, plant, or a link between them.
    Node(node::Options),
}

#[derive(Args)]
struct Options {
    /// Design file (TOML).
    design: PathBuf,
    /// Controllers to simulate, separated by commas: slqg (sequence-based LQG over the design's network), slqg-always (sends
    /// in every cycle, worth it or not), slqg-no-preview (takes the reference of the moment for all that is to come),
    /// slqg-channel (told the state of a bursty link one cycle late), slqg-task (time-varying law of a task that ends with the run), slqg-udp (without acknowledgements),
    /// slqg-udp-rounded (the same with the mean age rounded), lqg (at the plant, without a network: the lower bound).
    #[arg(long, value_delimiter = ',', default_value = "slqg,lqg")]
    controllers: Vec<Kind>,
    /// What becomes of acknowledgements, instead of the design's: instant, none, or the probabilities of a delay of 0, 1, ..
    /// cycles, as 0.7,0.1.
    #[arg(long, value_name = "A", value_parser = acknowledgement)]
    acknowledgement: Option<Acknowledgement>,
    /// Cycles that each acknowledgement tells, instead of the design's.
    #[arg(long, value_name = "C", value_parser = clap::value_parser!(u8).range(1..=8))]
    acknowledged_cycles: Option<u8>,
    /// What the estimator keeps apart where ages are not acknowledged, instead of the design's.
    #[arg(long, value_enum)]
    estimator: Option<EstimatorName>,
    #[command(flatten)]
    amount: Amount,
}

/// How much to simulate, and how to say it.
#[derive(Args)]
struct Amount {
    /// Runs per controller.
    #[arg(long, value_name = "R", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Control cycles per run.
    #[arg(long, value_name = "K", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Seed of all random numbers; the same seed gives the same numbers on any number of threads.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum EstimatorName {
    /// Nothing: one filter, told mean and covariance of the input.
    Single,
    /// The age in the last cycle.
    Imm,
    /// The ages in the last two cycles.
    Gpb2,
}

fn acknowledgement(text: &str) -> Result<Acknowledgement, String> {
    match text {
        "instant" => Ok(Acknowledgement::Instant),
        "none" => Ok(Acknowledgement::None),
        _ => {
            let probabilities: Option<Vec<f64>> =
                text.split(',').map(|part| part.trim().parse().ok()).collect();
            let probabilities =
                probabilities.ok_or("give instant, none, or probabilities separated by commas")?;
            let delays = DelayDistribution::new(probabilities).map_err(|error| error.to_string())?;
            Ok(Acknowledgement::Over(Link::independent(delays)))
        }
    }
}

/// What went wrong, by exit status.
enum Failure {
    /// The input is wrong: 2.
    Input(String),
    /// The loop cannot be stabilised: 3.
    Unstable(String),
}

pub(crate) fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Run { options, sequence_length, pictures } => run(&options, sequence_length, &pictures),
        Command::Sweep { options, lengths, pictures } => sweep(&options, &lengths, &pictures),
        Command::Robustness { designs, controller, amount } => robustness(&designs, controller, &amount),
        Command::Bus { design, steps, seed, frames, json } => {
            bus(&design, steps, seed, frames.as_deref(), json)
        }
        Command::Identify(options) => identify::run(&options)
            .map(|text| print!("{text}"))
            .map_err(|error| Failure::Input(error.to_string())),
        Command::Node(options) => {
            node::run(&options).map(|text| print!("{text}")).map_err(|error| match error {
                NodeError::Input(message) => Failure::Input(message),
                NodeError::Unstable(message) => Failure::Unstable(message),
            })
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Input(message)) => fail(2, &message),
        Err(Failure::Unstable(message)) => fail(3, &message),
    }
}

fn fail(status: u8, message: &str) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(status)
}

impl Amount {
    fn plan(&self) -> Plan {
        Plan { runs: self.runs as usize, steps: self.steps as usize, seed: self.seed }
    }
}

impl Options {
    fn load(&self) -> Result<Design, Failure> {
        let mut design = Design::load(&self.design).map_err(|error| Failure::Input(error.to_string()))?;
        if let Some(acknowledgement) = &self.acknowledgement {
            design.network.acknowledgement = acknowledgement.clone();
        }
        if let Some(cycles) = self.acknowledged_cycles {
            design.network.acknowledged_cycles = usize::from(cycles);
        }
        Ok(design)
    }

    fn plan(&self) -> Plan {
        self.amount.plan()
    }

    /// An error about the design.
    fn wrong(&self, error: &dyn Display) -> Failure {
        Failure::Input(format!("{}: {error}", self.design.display()))
    }

    /// The controller `kind` for `design`, which is the file's, perhaps with another length.
    fn contender(&self, kind: Kind, design: &Design) -> Result<Contender, Failure> {
        // Before gains are computed, which can take longer than saying no.
        size_class::check(design).map_err(|error| self.wrong(&error))?;
        let mut contender = Contender::new(kind, design, self.plan().steps)
            .map_err(|error| refused(&error, design, &self.design))?;
        if let (Some(estimator), true) =
            (self.estimator, contender.acknowledgement != Acknowledgement::Instant)
        {
            contender.merging = match estimator {
                EstimatorName::Single => Merging::Single,
                EstimatorName::Imm => Merging::Imm,
                EstimatorName::Gpb2 => Merging::Gpb2,
            };
        }
        Ok(contender)
    }

    fn simulate(
        &self,
        design: &Design,
        contender: &Contender,
        progress: &ProgressBar,
    ) -> Result<Outcome, Failure> {
        let simulate = Simulate { design, contender, plan: self.plan(), done: || progress.inc(1) };
        dispatch(design, simulate)
            .map_err(|error| self.wrong(&error))?
            .map_err(|error| self.wrong(&format_args!("controller.scalar: {error}; compute in f64")))
    }

    /// Writes the pictures that were asked for.
    fn draw(&self, pictures: &Pictures, simulation: &Simulation<'_>, design: &Design) -> Result<(), Failure> {
        pictures.write(simulation, design).map_err(|error| Failure::Input(error.to_string()))
    }

    fn print(&self, simulation: &Simulation<'_>) {
        if self.amount.json {
            println!("{}", output::json(simulation));
        } else {
            print!("{}", output::table(simulation));
        }
    }
}

fn simulation<'d>(design: &'d Design, plan: Plan, outcomes: Vec<Outcome>) -> Simulation<'d> {
    Simulation {
        name: &design.name,
        sample_time: design.plant.sample_time,
        goal: design.tracking.as_ref().map(|tracking| &tracking.goal),
        plan,
        outcomes,
    }
}

fn run(options: &Options, sequence_length: Option<u16>, pictures: &Pictures) -> Result<(), Failure> {
    let mut design = options.load()?;
    if let Some(length) = sequence_length {
        design.set_sequence_length(usize::from(length));
    }
    let contenders = options
        .controllers
        .iter()
        .map(|&kind| options.contender(kind, &design))
        .collect::<Result<Vec<_>, _>>()?;
    let progress = progress(contenders.len() * options.plan().runs);
    let outcomes = contenders
        .iter()
        .map(|contender| options.simulate(&design, contender, &progress))
        .collect::<Result<_, _>>()?;
    progress.finish_and_clear();

    let simulation = simulation(&design, options.plan(), outcomes);
    options.draw(pictures, &simulation, &design)?;
    options.print(&simulation);
    if !options.amount.json {
        print!("{}", pictures.told());
    }
    Ok(())
}

fn sweep(options: &Options, lengths: &Lengths, pictures: &Pictures) -> Result<(), Failure> {
    let mut design = options.load()?;
    let lengths = lengths.as_slice();
    let progress = progress(options.controllers.len() * lengths.len() * options.plan().runs);
    let (mut outcomes, mut unstable) = (Vec::new(), Vec::new());
    for &kind in &options.controllers {
        let lengths = if kind.ignores_length() { &lengths[..1] } else { lengths };
        for &length in lengths {
            design.set_sequence_length(length);
            match options.contender(kind, &design) {
                Ok(contender) => outcomes.push(options.simulate(&design, &contender, &progress)?),
                Err(Failure::Unstable(message)) => unstable.push(format!("N = {length}: {message}")),
                Err(wrong) => return Err(wrong),
            }
        }
    }
    progress.finish_and_clear();
    if outcomes.is_empty() {
        return Err(Failure::Unstable(unstable.join("\n")));
    }
    let simulation = simulation(&design, options.plan(), outcomes);
    options.draw(pictures, &simulation, &options.load()?)?;
    options.print(&simulation);
    if !options.amount.json {
        print!("{}", pictures.told());
    }
    unstable.iter().for_each(|message| eprintln!("not simulated: {message}"));
    Ok(())
}

fn bus(path: &Path, steps: u32, seed: u64, frames: Option<&Path>, json: bool) -> Result<(), Failure> {
    let mut design = Design::load(path).map_err(|error| Failure::Input(error.to_string()))?;
    let wrong = |error: &dyn Display| Failure::Input(format!("{}: {error}", path.display()));
    let Some(plan) = &mut design.network.bus else {
        return Err(wrong(
            &"network.can: missing: no link is on a bus; give links as { can = { identifier = .. } }",
        ));
    };
    plan.settings.log = frames.is_some();
    size_class::check(&design).map_err(|error| wrong(&error))?;
    let plan = Plan { runs: 1, steps: steps as usize, seed };
    let contender =
        Contender::new(Kind::Slqg, &design, plan.steps).map_err(|error| refused(&error, &design, path))?;
    let simulate = Simulate { design: &design, contender: &contender, plan, done: || () };
    let outcome = dispatch(&design, simulate)
        .map_err(|error| wrong(&error))?
        .map_err(|error| wrong(&format_args!("controller.scalar: {error}; compute in f64")))?;
    let bus = outcome.bus.as_ref().expect("the design has a bus");
    if let Some((file, text)) = frames.zip(bus_report::frames(bus)) {
        emit::write(file, &text).map_err(|error| {
            Failure::Input(format!("{}: cannot write the frames: {error}", file.display()))
        })?;
    }
    match json {
        true => println!("{}", bus_report::json(&design, bus)),
        false => print!("{}", bus_report::text(&design, bus, &outcome)),
    }
    Ok(())
}

fn robustness(paths: &[PathBuf], kind: Kind, amount: &Amount) -> Result<(), Failure> {
    let input = |error: &dyn Display| Failure::Input(error.to_string());
    let designs: Vec<Design> = paths
        .iter()
        .map(|path| Design::load(path).map_err(|error| input(&error)))
        .collect::<Result<_, _>>()?;
    robustness::check(&designs).map_err(|error| input(&error))?;
    let plan = amount.plan();
    let contender = |(design, path): (&Design, &PathBuf)| {
        size_class::check(design).map_err(|error| input(&format_args!("{}: {error}", path.display())))?;
        Contender::new(kind, design, plan.steps).map_err(|error| refused(&error, design, path))
    };
    let contenders: Vec<Contender> = designs.iter().zip(paths).map(contender).collect::<Result<_, _>>()?;
    let progress = progress(designs.len() * designs.len() * plan.runs);
    let table =
        Robustness::new(&designs, &contenders, plan, || progress.inc(1)).map_err(|error| input(&error))?;
    progress.finish_and_clear();
    match amount.json {
        true => {
            println!("{}", serde_json::to_string_pretty(&table).expect("numbers and strings are always JSON"))
        }
        false => print!("{}", table.table()),
    }
    Ok(())
}

fn refused(error: &ContenderError, design: &Design, path: &Path) -> Failure {
    let origin = path.display();
    match error {
        ContenderError::Unstable { .. } => {
            // Which condition fails is the generator's to say.
            let why = Report::new(design, Method::InFlight).require_stable().err();
            let why = why.map_or_else(String::new, |condition| format!(": {condition}"));
            Failure::Unstable(format!("{origin}: {error}{why}"))
        }
        wrong => Failure::Input(format!("{origin}: {wrong}")),
    }
}

/// A bar on stderr, when that is a terminal.
fn progress(runs: usize) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(runs as u64), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
