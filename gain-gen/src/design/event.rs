//! `[event]`: control packets are sent only where they are worth what they cost, thesis chapter 5.

use super::DesignError;
use super::document::Section;

/// What a packet costs, for a controller that decides in every cycle whether to send one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Cost of sending one control packet, in units of the stage cost; at least 0. S_k of thesis (5.1), constant.
    pub send_cost: f64,
}

impl Event {
    /// `None`: a packet is sent in every cycle.
    pub(super) fn read(root: &Section<'_>) -> Result<Option<Self>, DesignError> {
        let Some(table) = root.optional("event", "a table with the key send_cost") else { return Ok(None) };
        let event = table.section(&["send_cost"])?;
        let field = event
            .required("send_cost", "what sending one packet costs, at least 0, in units of the stage cost")?;
        let send_cost = field.number()?;
        if send_cost < 0.0 {
            return Err(field.reject(format!("found the number {send_cost}")));
        }
        Ok(Some(Event { send_cost }))
    }
}
