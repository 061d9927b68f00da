//! `[network]`: the links between the nodes. How one is given is in `link`.

use super::document::Section;
use super::link::{self, Surroundings};
use super::{DesignError, can};
use slqg::wire::MOST_AGES;
use slqg_links::{
    can::Id,
    link::Link,
    loop_bus::{LoopPlan, Role},
};

/// The links of the loop, as measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// From the controller node to the actuator node: carries control sequences.
    pub controller_to_actuator: Link,
    /// From the sensor to the controller node: carries measurements.
    pub sensor_to_controller: Link,
    /// From the actuator node back to the controller node.
    pub acknowledgement: Acknowledgement,
    /// The bus that links share which are on one, with the sizes of the loop's frames.
    pub bus: Option<LoopPlan>,
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
            "can",
        ])?;
        let carrying = |kind| Surroundings { sample_time, origin, kind };
        let meaning = "a link: { delays = [P(delay = 0), P(delay = 1), ..] } in steps, or one of gilbert_elliott, markov, trace, can";
        let one = |name, kind| link::read(&network.required(name, meaning)?, &carrying(kind));
        let (controller_to_actuator, control) = one("controller_to_actuator", CONTROL)?;
        let (sensor_to_controller, measurement) = one("sensor_to_controller", MEASUREMENT)?;
        let (acknowledgement, told) = acknowledgement(&network, &carrying(ACKNOWLEDGEMENT))?;
        let acknowledged_cycles = acknowledged_cycles(&network, &acknowledgement)?;
        let bus = bus(&network, [measurement, control, told], sample_time)?;
        Ok(Network {
            controller_to_actuator,
            sensor_to_controller,
            acknowledgement,
            bus,
            acknowledged_cycles,
        })
    }
}

fn bus(
    network: &Section<'_>,
    own: [Option<Id>; Role::COUNT],
    sample_time: f64,
) -> Result<Option<LoopPlan>, DesignError> {
    let meaning = "the bus of the links that are given as { can = { identifier = .. } }";
    match (network.optional("can", meaning), own == [None; Role::COUNT]) {
        (None, true) => Ok(None),
        (None, false) => {
            let allowed = "give the bus that the links with `can` share, as [network.can] with bit_rate";
            Err(network.reject("network.can", "missing".into(), allowed.into()))
        }
        (Some(field), true) => {
            let allowed =
                "give the links that go over the bus as { can = { identifier = .. } }, or leave it out";
            Err(field.reject_with("found a bus that no link is on".into(), allowed.into()))
        }
        (Some(field), false) => can::read(&field, own, sample_time).map(Some),
    }
}

fn acknowledgement(
    network: &Section<'_>,
    surroundings: &Surroundings<'_>,
) -> Result<(Acknowledgement, Option<Id>), DesignError> {
    let meaning = "\"instant\", \"none\" or { delays = [..] }";
    Ok(match network.optional("acknowledgement", meaning) {
        None => (Acknowledgement::Instant, None),
        Some(field) if field.is_text() => match field.choice(&[("instant", true), ("none", false)])? {
            true => (Acknowledgement::Instant, None),
            false => (Acknowledgement::None, None),
        },
        Some(field) => {
            let (link, id) = link::read(&field, surroundings)?;
            (Acknowledgement::Over(link), id)
        }
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
