//! `[network]`: the links between the nodes. The distributions themselves are in `distribution`.

use super::document::{Field, Section};
use super::{DelayDistribution, DesignError};
use slqg::wire::MOST_AGES;

/// Most entries of a list of delays; a longer one is a mistake, not a link.
const MOST_DELAYS: usize = 1000;

/// The links of the loop, as measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// From the controller node to the actuator node: carries control sequences.
    pub controller_to_actuator: DelayDistribution,
    /// From the sensor to the controller node: carries measurements.
    pub sensor_to_controller: DelayDistribution,
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
    Delays(DelayDistribution),
}

impl Acknowledgement {
    /// Most cycles ago that an acknowledgement which tells `cycles` cycles may tell of: the latest one, and the earliest
    /// of its cycles. At least one: even an instant one comes in the cycle after the one it is about.
    pub fn reach(&self, cycles: usize) -> usize {
        match self {
            Self::Instant | Self::None => 1,
            Self::Delays(delays) => delays.largest_delay() + cycles,
        }
    }
}

impl Network {
    pub(super) fn read(root: &Section<'_>) -> Result<Self, DesignError> {
        let table = "a table with the links controller_to_actuator and sensor_to_controller";
        let network = root.required("network", table)?.section(&[
            "controller_to_actuator",
            "sensor_to_controller",
            "acknowledgement",
            "acknowledged_cycles",
        ])?;
        let link = "a link: { delays = [P(delay = 0), P(delay = 1), ..] }, in steps";
        let controller_to_actuator = distribution(&network.required("controller_to_actuator", link)?)?;
        let sensor_to_controller = distribution(&network.required("sensor_to_controller", link)?)?;
        let acknowledgement = acknowledgement(&network)?;
        let acknowledged_cycles = acknowledged_cycles(&network, &acknowledgement)?;
        Ok(Network { controller_to_actuator, sensor_to_controller, acknowledgement, acknowledged_cycles })
    }
}

fn acknowledgement(network: &Section<'_>) -> Result<Acknowledgement, DesignError> {
    let meaning = "\"instant\", \"none\" or { delays = [..] }";
    Ok(match network.optional("acknowledgement", meaning) {
        None => Acknowledgement::Instant,
        Some(field) if field.is_text() => match field.choice(&[("instant", true), ("none", false)])? {
            true => Acknowledgement::Instant,
            false => Acknowledgement::None,
        },
        Some(field) => Acknowledgement::Delays(distribution(&field)?),
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

fn distribution(link: &Field<'_>) -> Result<DelayDistribution, DesignError> {
    let meaning = "the probabilities of delay 0, 1, .. steps, each within 0 and 1, with a sum of at most 1 \
                   (what is missing to 1 is loss) and above 0";
    let field = link.section(&["delays"])?.required("delays", meaning)?;
    let probabilities = field.numbers()?;
    if probabilities.len() > MOST_DELAYS {
        let found = format!("found {} delays", probabilities.len());
        return Err(field.reject_with(found, format!("give at most {MOST_DELAYS}; count the rest as loss")));
    }
    DelayDistribution::new(probabilities).map_err(|error| field.reject(error.to_string()))
}
