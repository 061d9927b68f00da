//! `[network]`: the links between the nodes. The distributions themselves are in `distribution`.

use super::document::{Field, Section};
use super::{DelayDistribution, DesignError};

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
}

/// When the controller learns which sequence the actuator plays out.
#[derive(Debug, Clone, PartialEq)]
pub enum Acknowledgement {
    /// One step later, always: the thesis' TCP-like network.
    Instant,
    /// Never: the thesis' UDP-like network.
    None,
    /// Over a link of its own.
    Delays(DelayDistribution),
}

impl Network {
    pub(super) fn read(root: &Section<'_>) -> Result<Self, DesignError> {
        let table = "a table with the links controller_to_actuator and sensor_to_controller";
        let network = root.required("network", table)?.section(&[
            "controller_to_actuator",
            "sensor_to_controller",
            "acknowledgement",
        ])?;
        let link = "a link: { delays = [P(delay = 0), P(delay = 1), ..] }, in steps";
        let acknowledgement = "\"instant\", \"none\" or { delays = [..] }";
        Ok(Network {
            controller_to_actuator: distribution(&network.required("controller_to_actuator", link)?)?,
            sensor_to_controller: distribution(&network.required("sensor_to_controller", link)?)?,
            acknowledgement: match network.optional("acknowledgement", acknowledgement) {
                None => Acknowledgement::Instant,
                Some(field) if field.is_text() => {
                    match field.choice(&[("instant", true), ("none", false)])? {
                        true => Acknowledgement::Instant,
                        false => Acknowledgement::None,
                    }
                }
                Some(field) => Acknowledgement::Delays(distribution(&field)?),
            },
        })
    }
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
