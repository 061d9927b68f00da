//! The thesis' figures, recomputed with this project's networks: `host-sim figures`. And what `docs/comparison.md` shows.
//!
//! | file | what lives there |
//! |---|---|
//! | `mod` | which figures there are, and what each shows |
//! | [`by_length`] | costs over the sequence length, for several controllers and networks |
//! | [`cumulative`] | cost per step up to each step, over many runs |
//! | [`single_run`] | one run over time, with and without preview |
//! | [`paired`] | what other controllers cost more than `slqg`, run by run |
//!
//! Designs are the examples of the repository, compiled in.

pub mod by_length;
pub mod cumulative;
pub mod paired;
pub mod single_run;

use crate::contender::Kind;
use gain_gen::design::Design;
use std::str::FromStr;

/// A figure of the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    /// 3.9: cost over the length of the sequences, double integrator.
    CostOverLength,
    /// 3.10: cost per step up to step k, critical plant, lengths on both sides of the critical one.
    CostPerStep,
    /// 3.11: with and without acknowledgements.
    Unacknowledged,
    /// 4.4: a single run that follows a reference, with and without preview.
    SingleRun,
    /// 4.5: following a reference, with and without preview.
    Tracking,
    /// 5.3 and 5.4: sending what is worth it.
    EventTriggered,
}

impl Figure {
    /// In the order of the thesis.
    pub const ALL: [Self; 6] = [
        Self::CostOverLength,
        Self::CostPerStep,
        Self::Unacknowledged,
        Self::SingleRun,
        Self::Tracking,
        Self::EventTriggered,
    ];

    /// As on the command line and in names of files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::CostOverLength => "3.9",
            Self::CostPerStep => "3.10",
            Self::Unacknowledged => "3.11",
            Self::SingleRun => "4.4",
            Self::Tracking => "4.5",
            Self::EventTriggered => "5.3",
        }
    }

    /// What it shows.
    pub const fn title(self) -> &'static str {
        match self {
            Self::CostOverLength => "3.9: cost over the length of the sequences, double integrator",
            Self::CostPerStep => "3.10: mean cost per step up to step k, critical plant",
            Self::Unacknowledged => "3.11: with and without acknowledgements, double integrator",
            Self::SingleRun => "4.4: a single run that follows a reference, pendulum",
            Self::Tracking => "4.5: cost of following a reference, pendulum",
            Self::EventTriggered => "5.3 and 5.4: sending what is worth it, pendulum",
        }
    }
}

impl FromStr for Figure {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let name = if name == "5.4" { "5.3" } else { name };
        Self::ALL.into_iter().find(|figure| figure.name() == name).ok_or_else(|| {
            let known: Vec<_> = Self::ALL.iter().map(|figure| figure.name()).collect();
            format!("there is no figure `{name}` here; there are: {}", known.join(", "))
        })
    }
}

/// One of the repository's designs.
fn design(name: &'static str, text: &str) -> Design {
    Design::parse(text, name).unwrap_or_else(|error| unreachable!("an example of the repository: {error}"))
}

macro_rules! example {
    ($name:literal) => {
        $crate::figures::design(
            concat!($name, ".toml"),
            include_str!(concat!("../../designs/", $name, ".toml")),
        )
    };
}
pub(crate) use example;

impl Figure {
    /// What a figure over the length of sequences compares; `None` for the others.
    pub fn comparison(self) -> Option<by_length::Comparison> {
        let both = |designs: [Design; 2], kinds: &[Kind], lengths: usize, runs, steps| {
            Some(by_length::Comparison {
                designs: designs.to_vec(),
                kinds: kinds.to_vec(),
                lengths: 1..=lengths,
                runs,
                steps,
            })
        };
        let double_integrator = || [example!("double_integrator"), example!("double_integrator_bad")];
        match self {
            Self::CostOverLength => {
                let kinds = [Kind::Slqg, Kind::LqgLoss, Kind::Nominal, Kind::HoldLast, Kind::Lqg];
                both(double_integrator(), &kinds, 6, 200, 200)
            }
            Self::Unacknowledged => {
                both(double_integrator(), &[Kind::Slqg, Kind::SlqgUdp, Kind::SlqgUdpRounded], 6, 1000, 200)
            }
            Self::Tracking => {
                let designs = [example!("pendulum_tracking"), example!("pendulum_tracking_bad")];
                both(designs, &[Kind::Slqg, Kind::SlqgNoPreview, Kind::Nominal, Kind::Lqg], 6, 100, 500)
            }
            Self::EventTriggered => {
                let designs = [example!("pendulum_event"), example!("pendulum_event_bad")];
                both(designs, &[Kind::Slqg, Kind::SlqgAlways, Kind::Deadband, Kind::Lqg], 10, 200, 200)
            }
            Self::CostPerStep | Self::SingleRun => None,
        }
    }
}
