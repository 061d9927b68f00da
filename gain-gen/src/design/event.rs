//! `[event]`: control packets are sent only where they are worth what they cost, thesis chapter 5, or at fixed times.

use super::DesignError;
use super::document::Section;

/// Most cycles between packets of a schedule.
pub const LONGEST_PERIOD: usize = 64;

/// What a packet costs, for a controller that decides in every cycle whether to send one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Cost of sending one control packet, in units of the stage cost; at least 0. S_k of thesis (5.1), constant.
    pub send_cost: f64,
    /// What is taken to be done later.
    pub base: Base,
    /// What decides.
    pub rule: Rule,
}

/// When later packets are taken to be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// In every cycle so many apart; at least 1.
    Every(usize),
    /// As the cheapest schedule has them, or for a trigger one that is a little shorter.
    Auto,
}

/// What decides whether a packet is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Whether it is worth its price.
    Worth,
    /// The clock: it is sent in the cycles of the base, and in no other.
    Schedule,
}

impl Rule {
    /// As in design files and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Worth => "worth",
            Self::Schedule => "schedule",
        }
    }
}

impl Event {
    /// Packets that cost so much are sent where they are worth it, all later ones taken to be sent.
    pub const fn at(send_cost: f64) -> Self {
        Self { send_cost, base: Base::Every(1), rule: Rule::Worth }
    }

    /// Whether later packets may be taken to be sent more rarely than always.
    pub fn may_pause(&self) -> bool {
        self.base != Base::Every(1) || self.rule == Rule::Schedule
    }

    /// `None`: a packet is sent in every cycle. `is_tracking`: whether there is a reference.
    pub(super) fn read(root: &Section<'_>, is_tracking: bool) -> Result<Option<Self>, DesignError> {
        let Some(table) = root.optional("event", "a table with the key send_cost") else { return Ok(None) };
        let event = table.section(&["send_cost", "base", "rule"])?;
        let field = event
            .required("send_cost", "what sending one packet costs, at least 0, in units of the stage cost")?;
        let send_cost = field.number()?;
        if send_cost < 0.0 {
            return Err(field.reject(format!("found the number {send_cost}")));
        }
        let rule = match event.optional("rule", "\"worth\" or \"schedule\"") {
            Some(field) => field.choice(&[("worth", Rule::Worth), ("schedule", Rule::Schedule)])?,
            None => Rule::Worth,
        };
        let meaning = "\"auto\", or the number of cycles, 1 to 64, from one later packet to the next";
        let base = event.optional("base", meaning);
        let is_given = base.is_some();
        let base = match base {
            Some(field) if field.is_text() => field.choice(&[("auto", Base::Auto)])?,
            Some(field) => Base::Every(field.whole_number(1..=LONGEST_PERIOD)?),
            None if rule == Rule::Schedule => Base::Auto,
            None => Base::Every(1),
        };
        let found = Self { send_cost, base, rule };
        if is_tracking && found.may_pause() {
            let allowed = "with [tracking] only base = 1 and rule = \"worth\": what a pause costs depends on the reference";
            let key = if is_given { "event.base" } else { "event.rule" };
            return Err(event.reject(key, "found [tracking] beside it".into(), allowed.into()));
        }
        Ok(Some(found))
    }
}
