//! The words of the command line: commands, options, what may be given for each, and their help.
//!
//! What is done about them is in [`super`].

use clap::{Args, Parser, Subcommand, ValueEnum};
use gain_gen::design::{Design, DesignError, LONGEST_SEQUENCE};
use gain_gen::lengths::Lengths;
use gain_gen::report::LONGEST_TASK;
use gain_gen::solve::Method;
use slqg::DefaultInput;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Lengths a design may ask for.
const LENGTHS: RangeInclusive<usize> = 1..=LONGEST_SEQUENCE;

/// Lengths a task may have.
const HORIZONS: RangeInclusive<usize> = 1..=LONGEST_TASK;

/// Optimal gains for control over links that lose and delay packets
///
/// Exit status: 0 done; 2 the input is wrong, stderr says where and how to mend it; 3 the loop is not stable, or not
/// shown to be, stderr says which condition fails or is open.
#[derive(Parser)]
#[command(name = "gain-gen", version)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Command,
}

#[derive(Subcommand)]
pub(super) enum Command {
    /// Tell whether a design can be stabilised, and with what gains and figures
    Report {
        #[command(flatten)]
        source: Source,
        /// Recursion that computes the gains: the small one, or the reference over all ages of the buffer
        #[arg(long, value_enum, default_value = "in-flight")]
        method: MethodName,
        /// Print one JSON object with all tables instead of text
        #[arg(long)]
        json: bool,
        /// Spell out the gains for every age of the buffer in the JSON, however many they are
        ///
        /// Without it the field `gains` is null where they are more than 10000 numbers: from N = 12 on for two states and
        /// one input. They grow with the fourth power of N, and all of them follow from lx, m and r.
        #[arg(long, requires = "json")]
        mode_gains: bool,
        /// Add how far it is to instability, with the filter in the loop and with the state known: in loss, delay,
        /// sample time and each entry of the plant; a minute or more for N = 20
        #[arg(long)]
        margins: bool,
        /// Add the time-varying gains of a task of so many cycles (1 to 10000), which ends with cost.terminal
        ///
        /// With [tracking] the task follows the reference of the design. Not with [event].
        #[arg(long, value_name = "K", value_parser = horizon)]
        horizon: Option<usize>,
        /// Write a proof of stability to this file, as JSON that anybody can check
        #[arg(long, value_name = "FILE")]
        certificate: Option<PathBuf>,
    },
    /// Compare sequence lengths: stability, cost and size of the tables for each
    ///
    /// The status is 0 if the loop is shown to be stable with any of the lengths.
    Sweep {
        /// Design file (TOML); its sequence length does not matter
        design: PathBuf,
        /// Lengths, 1 to 128: 4, 1..=12, 1..13 or 1,2,4,8
        #[arg(long, value_name = "RANGE")]
        lengths: Lengths,
        /// What the actuator applies when its buffer has run out, instead of the design's
        #[arg(long, value_enum)]
        default_input: Option<SweptInputName>,
        /// Print one JSON object instead of a table
        #[arg(long)]
        json: bool,
        /// Also draw cost, rate and size over the length, as SVG
        #[arg(long, value_name = "FILE.svg")]
        plot: Option<PathBuf>,
        /// Solve also where that takes more than 2 GB of memory or half an hour, as estimated
        #[arg(long)]
        accept_effort: bool,
    },
    /// Write the gains, the plant and the settings of both nodes to a file
    ///
    /// An existing file is replaced only by a complete new one; a loop that is not shown to be stable writes nothing.
    Emit {
        #[command(flatten)]
        source: Source,
        /// What to write
        #[arg(long, value_enum)]
        to: FormatName,
        /// Write the time-varying gains of a task of so many cycles (1 to 10000) instead of the steady-state ones
        ///
        /// The task ends with the weight cost.terminal. It need not be one that could go on for ever. With [tracking] it
        /// follows the reference of the design. rust and json only, and not with [event].
        #[arg(long, value_name = "K", value_parser = horizon)]
        horizon: Option<usize>,
        /// File to write; for C the header, which ends in .h
        #[arg(long, value_name = "FILE")]
        output: PathBuf,
        /// Write a loop whose stability is undecided, too; what is written says what is not shown
        ///
        /// Late or missing acknowledgements and input limits on an unstable plant leave it so. An unstable loop writes nothing
        /// all the same.
        #[arg(long)]
        accept_undecided_stability: bool,
    },
}

/// A design file, and what the command line changes in it.
#[derive(Args)]
pub(super) struct Source {
    /// Design file (TOML): plant, cost, network and controller settings
    pub(super) design: PathBuf,
    /// Inputs per packet, 1 to 128, instead of the design's
    #[arg(long, value_name = "N", value_parser = sequence_length)]
    sequence_length: Option<usize>,
    /// What the actuator applies when its buffer has run out, instead of the design's
    #[arg(long, value_enum)]
    default_input: Option<DefaultInputName>,
    /// Solve also where that takes more than 2 GB of memory or half an hour, as estimated
    #[arg(long)]
    pub(super) accept_effort: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum DefaultInputName {
    /// Zero input
    Zero,
    /// The input applied last
    Hold,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum SweptInputName {
    /// Zero input
    Zero,
    /// The input applied last
    Hold,
    /// One after the other, in one table
    Both,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum MethodName {
    /// The project's own recursion: small and fast
    InFlight,
    /// The reference recursion, one gain per age of the actuator's buffer: slow for long sequences
    Coupled,
}

impl MethodName {
    pub(super) fn method(self) -> Method {
        match self {
            Self::InFlight => Method::InFlight,
            Self::Coupled => Method::Coupled,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum FormatName {
    /// Rust source to include in a no_std crate that depends on slqg
    Rust,
    /// C99: a header, and beside it a source that ends in .c instead of .h and the law for both; without [tracking] and [event]
    C,
    /// The report's JSON with the plant's model and the settings of both nodes
    Json,
    /// Bytes with a checksum, which slqg::blob loads at run time: the gains alone; without [tracking] and [event]
    Blob,
}

impl Source {
    /// The design as the command line has it.
    pub(super) fn load(&self) -> Result<Design, DesignError> {
        let mut design = Design::load(&self.design)?;
        if let Some(name) = self.default_input {
            // A length that the design leaves open is chosen anew.
            design.set_default_input(match name {
                DefaultInputName::Zero => DefaultInput::Zero,
                DefaultInputName::Hold => DefaultInput::Hold,
            });
        }
        if let Some(length) = self.sequence_length {
            design.set_sequence_length(length);
        }
        Ok(design)
    }
}

fn sequence_length(text: &str) -> Result<usize, String> {
    whole_number(text, "inputs", &LENGTHS)
}

fn horizon(text: &str) -> Result<usize, String> {
    whole_number(text, "cycles", &HORIZONS)
}

fn whole_number(text: &str, of: &str, allowed: &RangeInclusive<usize>) -> Result<usize, String> {
    let advice = || format!("give a whole number of {of} from {} to {}", allowed.start(), allowed.end());
    text.parse().ok().filter(|number| allowed.contains(number)).ok_or_else(advice)
}
