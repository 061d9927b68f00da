//! What a bus does to the design's frames: found by running them on it, once their lengths are known.
//!
//! How the bus is given is in `can`, how frames are carried in `wire`.

use super::document::Section;
use super::{Acknowledgement, DelayDistribution, Design, DesignError, FrameBytes, Link, WireSettings};
use slqg_links::{
    can::Format,
    loop_bus::{LoopPlan, Role, observed::observe},
    recording::Recording,
};

/// Rejects a bus without a form of frames that it can carry.
pub(super) fn check(root: &Section<'_>, design: &Design) -> Result<(), DesignError> {
    if design.network.bus.is_none() || design.wire != WireSettings::Bytes {
        return Ok(());
    }
    let found = "missing, but links go over a CAN bus".to_string();
    let allowed = "give \"can-fd\" for full frames, or \"can-classic\" for compact ones of 8 bytes";
    Err(root.reject("wire.format", found, allowed.into()))
}

/// The error of a bus on which frames of a link never arrive.
pub(super) fn nothing_arrives(root: &Section<'_>) -> DesignError {
    let found = "found a bus on which a link's frames never arrive".to_string();
    let allowed = "give more urgent identifiers, less other traffic, or a higher bit_rate";
    root.reject("network.can", found, allowed.into())
}

impl Design {
    /// Finds the delays of the links that are on a bus, for the frames that the design has now. Of frames that do not fit
    /// the bus nothing changes; see [`Design::misfit`]. False if those of some link never arrive: then neither.
    pub(crate) fn run_on_bus(&mut self) -> bool {
        let Some(bytes) = self.network.bus.as_ref().and(self.carried_bytes()) else { return true };
        let Some(plan) = &mut self.network.bus else { return true };
        let format = match (&self.wire, plan.settings.data_bit_rate) {
            (WireSettings::CanClassic(_), _) => Format::Classic,
            (_, data_bit_rate) => Format::Fd { bit_rate_switch: data_bit_rate.is_some() },
        };
        let FrameBytes { measurement, control, acknowledgement } = bytes;
        let lengths = [measurement, control, acknowledgement.unwrap_or(0)];
        let mut messages = plan.messages;
        for (message, bytes) in messages.iter_mut().zip(lengths) {
            if let Some(message) = message {
                message.bytes = bytes;
            }
        }
        if (messages, format) == (plan.messages, plan.format) {
            return true;
        }
        (plan.messages, plan.format) = (messages, format);
        let Some([sensor, actuator, told]) = observed(plan) else { return false };
        let network = &mut self.network;
        network.sensor_to_controller = sensor.map_or(network.sensor_to_controller.clone(), Link::bus);
        network.controller_to_actuator = actuator.map_or(network.controller_to_actuator.clone(), Link::bus);
        if let Some(told) = told {
            network.acknowledgement = Acknowledgement::Over(Link::bus(told));
        }
        if !self.controller.buffer_is_given {
            self.controller.measurement_buffer = self.network.sensor_to_controller.largest_delay();
        }
        true
    }
}

/// Shares of the delays by role; `None` if frames of some role never arrive.
fn observed(plan: &LoopPlan) -> Option<[Option<DelayDistribution>; Role::COUNT]> {
    let [a, b, c] = observe(plan).ok()?;
    let shares =
        |recording: Option<Recording>| recording.map(|recording| recording.shares()).transpose().ok();
    Some([shares(a)?, shares(b)?, shares(c)?])
}
