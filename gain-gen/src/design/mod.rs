//! Design files: plant, cost, network and controller settings, read from TOML and fully checked.
//!
//! What comes out of here needs no further checks: shapes fit, numbers are finite, covariances and weights are
//! definite, and the plant can be stabilised and observed. Whether it can be stabilised *over this network* is
//! a result of the synthesis, not a property of the file.
//!
//! One file per table (`plant`, `cost`, `network` with its `link` and its bus (`can`, `bus`), `controller`, `tracking` with
//! its `reference` and `set_point`, `event`, `wire`, `safety`), the ideas they share beside them: places in the file (`document`,
//! `syntax`; `places` for what is found out later), definiteness (`symmetric`),
//! unstable modes (`modes`), states that a constant input holds (`equilibrium`).

mod bus;
mod can;
mod controller;
mod cost;
mod document;
mod eigenvalues;
mod equilibrium;
mod error;
mod estimator;
mod event;
mod length_choice;
mod link;
pub(crate) mod modes;
mod network;
mod places;
mod plant;
mod reference;
mod safety;
mod set_point;
mod symmetric;
mod syntax;
mod tracking;
mod wire;

pub use controller::{ControllerSettings, DeviceScalar, LONGEST_SEQUENCE};
pub use cost::Cost;
pub use error::DesignError;
pub use estimator::NotLinear;
pub use event::{Base, Event, LONGEST_PERIOD, Rule};
pub use length_choice::{LengthChoice, LongSequences};
pub use network::{Acknowledgement, Network};
pub use places::Places;
pub use plant::{MOST_INPUTS, MOST_STATES, Plant};
pub use reference::{Interpolation, Reference};
pub use safety::{Gate, Safety};
pub use set_point::SetPoint;
pub use slqg_links::{
    delay::{DelayDistribution, DistributionError},
    link::{Behaviour, Link},
    markov::MarkovLink,
};
pub use tracking::{Goal, Preview, Tracking, Trajectory};
pub use wire::{Authentication, Counted, FrameBytes, Misfit, Steps, ValueLimits, WireSettings};

use document::{Document, Section};
use std::path::Path;
use toml::de::DeTable;
use tracking::TrackedOutputs;

/// A complete, checked design.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Name of the design, as reports and generated source show it.
    pub name: String,
    /// The plant, in discrete time.
    pub plant: Plant,
    /// What the controller weighs.
    pub cost: Cost,
    /// The links.
    pub network: Network,
    /// Settings of controller and actuator node.
    pub controller: ControllerSettings,
    /// What follows a reference; `None`: the state is to be 0.
    pub tracking: Option<Tracking>,
    /// What a control packet costs; `None`: one is sent in every cycle.
    pub event: Option<Event>,
    /// What carries the frames.
    pub wire: WireSettings,
    /// Whether frames are sealed.
    pub authentication: Authentication,
    /// What both ends do where measurements or packets fail.
    pub safety: Safety,
    /// Where its keys are written.
    pub places: Places,
}

impl Design {
    /// Reads and checks the design file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or its text is rejected as in [`Design::parse`].
    pub fn load(path: &Path) -> Result<Self, DesignError> {
        let origin = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &origin),
            Err(reason) => Err(DesignError {
                origin,
                line: None,
                key: String::new(),
                found: format!("cannot be read: {reason}"),
                allowed: "give the path of a design file".into(),
            }),
        }
    }

    /// Reads and checks a design. `origin` is the name under which errors report the text.
    ///
    /// A sequence length that is left open is chosen here, so that a design always has one; see [`crate::lengths`].
    ///
    /// # Errors
    /// The first rejection: syntax, an unknown or missing key, a wrong type, shape or value.
    pub fn parse(text: &str, origin: &str) -> Result<Self, DesignError> {
        let document = Document { origin, text };
        let table = DeTable::parse(text).map_err(|error| syntax::rejected(document, &error))?;
        let keys = ["name", "plant", "cost", "network", "controller", "tracking", "event", "wire", "safety"];
        let root = Section::root(document, table.get_ref(), &keys)?;
        let name = root.required("name", "a name, such as \"pendulum\"")?;
        if name.text()?.trim().is_empty() {
            return Err(name.reject("found an empty name".into()));
        }
        let (plant, unstable) = Plant::read(&root)?;
        let outputs = TrackedOutputs::read(&root, &plant)?;
        let tracked = outputs.as_ref().map(|outputs| &outputs.z);
        let (cost, weights) = Cost::read(&root, &plant, &unstable, tracked)?;
        let tracking = outputs.map(|outputs| outputs.finish(&plant, weights, &cost.r)).transpose()?;
        let mut network = Network::read(&root, origin, plant.sample_time)?;
        let (controller, tolerance) =
            ControllerSettings::read(&root, plant.inputs(), network.sensor_to_controller.largest_delay())?;
        let event = Event::read(&root, tracking.is_some())?;
        let wire = WireSettings::read(&root, &plant, &controller, &mut network)?;
        let authentication = Authentication::read(&root, &wire)?;
        let name = name.text()?.into();
        let places = Places::of(document, table.get_ref());
        let around = (&network, &controller, event.is_some());
        let safety = Safety::read(&root, &plant, around)?;
        let mut design = Design {
            name,
            plant,
            cost,
            network,
            controller,
            tracking,
            event,
            wire,
            authentication,
            safety,
            places,
        };
        design.check_estimator(&root)?;
        bus::check(&root, &design)?;
        let mut arrives = design.run_on_bus();
        if let Some(tolerance) = tolerance {
            design.choose_length(tolerance);
            arrives &= design.run_on_bus();
        }
        WireSettings::check(&root, &design)?;
        // The links over a bus are known by now.
        let around = (&design.network, &design.controller, design.event.is_some());
        design.safety = Safety::read(&root, &design.plant, around)?;
        if !arrives {
            return Err(bus::nothing_arrives(&root));
        }
        Ok(design)
    }

    /// Most cycles ago that an acknowledgement may tell of.
    pub fn acknowledgement_buffer(&self) -> usize {
        self.network.acknowledgement.reach(self.network.acknowledged_cycles)
    }

    /// Cycles that the estimator remembers, the current one included: `H` of [`slqg::controller::Controller`]. They reach
    /// back to the latest measurement that counts and to the earliest cycle that is acknowledged.
    pub fn history(&self) -> usize {
        self.controller.measurement_buffer.max(self.acknowledgement_buffer()) + 1
    }
}
