//! `[network]`: the links between the nodes. How one is given is in `link`.

use super::DesignError;
use super::document::Section;
use super::link::{self, Surroundings};
use slqg::wire::MOST_AGES;
use slqg_links::link::Link;

/// The links of the loop, as measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// From the controller node to the actuator node: carries control sequences.
    pub controller_to_actuator: Link,
    /// From the sensor to the controller node: carries measurements.
    pub sensor_to_controller: Link,
    /// From the actuator node back to the controller node.
    pub acknowledgement: Acknowledgement,
    /// Of how many of its last cycles each acknowledgement tells, 1 to 8: a later one makes good an earlier loss.
    /// Without acknowledgements the number has no meaning.
    pub acknowledged_cycles: usize,
}

/// When the controller learns which sequence the actuator plays out.
#[derive(Debug, Clone, PartialEq)]
pub enum Acknowledgement {
    /// One step later, always: the thesis' TCP-like network.
    Instant,
    /// Never: the thesis' UDP-like network.
    None,
    /// Over a link of its own. Delay 0 is what [`Acknowledgement::Instant`] guarantees: there before the next cycle.
    Over(Link),
}

impl Acknowledgement {
    /// Most cycles ago that an acknowledgement which tells `cycles` cycles may tell of: the latest one, and the earliest
    /// of its cycles. At least one: even an instant one comes in the cycle after the one it is about.
    pub fn reach(&self, cycles: usize) -> usize {
        match self {
            Self::Instant | Self::None => 1,
            Self::Over(link) => link.largest_delay() + cycles,
        }
    }
}

/// Kinds of frames, as docs/wire-format.md numbers them.
const MEASUREMENT: u8 = 1;
const CONTROL: u8 = 2;
const ACKNOWLEDGEMENT: u8 = 3;

impl Network {
    /// `origin`: the design file, beside which traces are looked for. `sample_time` in seconds.
    pub(super) fn read(root: &Section<'_>, origin: &str, sample_time: f64) -> Result<Self, DesignError> {
        let table = "a table with the links controller_to_actuator and sensor_to_controller";
        let network = root.required("network", table)?.section(&[
            "controller_to_actuator",
            "sensor_to_controller",
            "acknowledgement",
            "acknowledged_cycles",
        ])?;
        let carrying = |kind| Surroundings { sample_time, origin, kind };
        let meaning = "a link: { delays = [P(delay = 0), P(delay = 1), ..] } in steps, or one of gilbert_elliott, markov, trace";
        let one = |name, kind| link::read(&network.required(name, meaning)?, &carrying(kind));
        let controller_to_actuator = one("controller_to_actuator", CONTROL)?;
        let sensor_to_controller = one("sensor_to_controller", MEASUREMENT)?;
        let acknowledgement = acknowledgement(&network, &carrying(ACKNOWLEDGEMENT))?;
        let acknowledged_cycles = acknowledged_cycles(&network, &acknowledgement)?;
        Ok(Network { controller_to_actuator, sensor_to_controller, acknowledgement, acknowledged_cycles })
    }
}

fn acknowledgement(
    network: &Section<'_>,
    surroundings: &Surroundings<'_>,
) -> Result<Acknowledgement, DesignError> {
    let meaning = "\"instant\", \"none\" or { delays = [..] }";
    Ok(match network.optional("acknowledgement", meaning) {
        None => Acknowledgement::Instant,
        Some(field) if field.is_text() => match field.choice(&[("instant", true), ("none", false)])? {
            true => Acknowledgement::Instant,
            false => Acknowledgement::None,
        },
        Some(field) => Acknowledgement::Over(link::read(&field, surroundings)?),
    })
}

fn acknowledged_cycles(
    network: &Section<'_>,
    acknowledgement: &Acknowledgement,
) -> Result<usize, DesignError> {
    let meaning = "a whole number of cycles from 1 to 8";
    let Some(field) = network.optional("acknowledged_cycles", meaning) else {
        // All that a frame holds: each costs one byte.
        return Ok(MOST_AGES);
    };
    if *acknowledgement == Acknowledgement::None {
        let found = "found beside acknowledgement = \"none\"".to_string();
        let allowed = "give it with acknowledgement = { delays = [..] } or \"instant\" only";
        return Err(field.reject_with(found, allowed.into()));
    }
    field.whole_number(1..=MOST_AGES)
}
