//! A controller to simulate: which gains it has and which network it gets.
//!
//! There is one control algorithm, the core's. The collocated LQG controller is the same algorithm on a network that
//! loses and delays nothing: sequences of one input, designed for that network.

use gain_gen::{
    design::{Acknowledgement, DelayDistribution, Design},
    solve::{Law, LoopProblem, Method, solve},
    stability::loses_sight,
};
use std::str::FromStr;

/// The controllers that can be named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Sequence-based LQG on the design's network. Thesis chapter 3.
    Slqg,
    /// LQG at the plant, without a network: no controller on any network does better.
    Lqg,
}

impl Kind {
    /// Every controller there is.
    pub const ALL: [Self; 2] = [Self::Slqg, Self::Lqg];

    /// As on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slqg => "slqg",
            Self::Lqg => "lqg",
        }
    }
}

impl FromStr for Kind {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let known: Vec<_> = Self::ALL.iter().map(|kind| kind.name()).collect();
            format!("no controller is called `{name}`; there are: {}", known.join(", "))
        })
    }
}

/// A controller with its gains and its network.
#[derive(Debug, Clone)]
pub struct Contender {
    /// Which controller.
    pub kind: Kind,
    /// Its control law.
    pub law: Law,
    /// Delay of its link to the actuator.
    pub actuator_link: DelayDistribution,
    /// Delay of its link from the sensor.
    pub sensor_link: DelayDistribution,
    /// Most cycles a measurement may be late and still count.
    pub measurement_buffer: usize,
}

/// Why a controller cannot be simulated.
#[derive(Debug, Clone, thiserror::Error)]
pub enum ContenderError {
    /// The controller needs another kind of acknowledgement.
    #[error(
        "network.acknowledgement: `{controller}` needs to know each cycle what the actuator applied; \
         give acknowledgement = \"instant\", or simulate `lqg` only"
    )]
    Acknowledgement {
        /// The controller.
        controller: &'static str,
    },
    /// No gains stabilise the loop.
    #[error("`{controller}` cannot stabilise the loop")]
    Unstable {
        /// The controller.
        controller: &'static str,
    },
}

impl Contender {
    /// The controller `kind` designed for `design`.
    ///
    /// # Errors
    /// If the controller cannot work with the design's network.
    pub fn new(kind: Kind, design: &Design) -> Result<Self, ContenderError> {
        let controller = kind.name();
        let perfect = DelayDistribution::new(vec![1.0]).expect("certain arrival is a distribution");
        let mut problem = LoopProblem::of(design);
        let network = &design.network;
        let (sensor_link, measurement_buffer) = match kind {
            Kind::Slqg => {
                if network.acknowledgement != Acknowledgement::Instant {
                    return Err(ContenderError::Acknowledgement { controller });
                }
                (network.sensor_to_controller.clone(), design.controller.measurement_buffer)
            }
            Kind::Lqg => {
                problem.link = perfect.clone();
                problem.length = 1;
                (perfect, 0)
            }
        };
        let solution = solve(&problem, Method::InFlight);
        if !solution.is_stabilising() || loses_sight(&design.plant, &sensor_link, measurement_buffer) {
            return Err(ContenderError::Unstable { controller });
        }
        Ok(Self { kind, law: solution.law, actuator_link: problem.link, sensor_link, measurement_buffer })
    }
}
