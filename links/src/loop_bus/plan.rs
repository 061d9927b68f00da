//! [`LoopPlan`]: how a control loop uses a bus, and who its nodes are.

use crate::can::{Attempts, Format, Id, NodeId, Pattern, Settings, Time};

/// What a frame is for the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// From the sensor to the controller.
    Measurement,
    /// From the controller to the actuator.
    Control,
    /// From the actuator to the controller.
    Acknowledgement,
}

impl Role {
    /// How many there are.
    pub const COUNT: usize = 3;
    /// All, in the order of a cycle.
    pub const ALL: [Self; Self::COUNT] = [Self::Measurement, Self::Control, Self::Acknowledgement];
    /// First node that is none of the loop's: for other traffic.
    pub const FIRST_FREE_NODE: u16 = Self::COUNT as u16;

    /// The node that sends it: each sends one role.
    pub fn node(self) -> NodeId {
        NodeId(self as u16)
    }

    /// Cycles until the first taking that can have a frame: an acknowledgement is about a cycle that is over.
    pub(super) fn first_taken_after(self) -> u64 {
        u64::from(self == Self::Acknowledgement)
    }

    pub(super) fn tag(self, cycle: u64) -> u64 {
        cycle * Self::COUNT as u64 + self as u64
    }

    /// The role of the frame with this tag.
    pub fn of(tag: u64) -> Self {
        Self::ALL[(tag % Self::COUNT as u64) as usize]
    }

    pub(super) fn cycle(tag: u64) -> u64 {
        tag / Self::COUNT as u64
    }
}

/// One of the loop's messages on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Message {
    /// Identifier: the lower, the more urgent.
    pub id: Id,
    /// Bytes of each frame, as its format carries them: padding included.
    pub bytes: usize,
}

/// How a control loop uses a bus.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopPlan {
    /// The bus with its other traffic, from node [`Role::FIRST_FREE_NODE`] on.
    pub settings: Settings,
    /// Control cycle, in nanoseconds.
    pub sample_time: Time,
    /// When in a cycle the controller takes measurements and acknowledgements and sends, in nanoseconds from its begin.
    pub controller_at: Time,
    /// When in a cycle the actuator takes sequences, applies an input and acknowledges; after the controller.
    pub actuator_at: Time,
    /// What goes over the bus, by [`Role`]; `None` goes elsewhere.
    pub messages: [Option<Message>; Role::COUNT],
    /// Format of the loop's frames.
    pub format: Format,
    /// How often each of them is tried.
    pub attempts: Attempts,
    /// Whether a new frame takes the place of an older one of its role that still waits.
    pub replaces: bool,
}

impl LoopPlan {
    /// What the loop sends of a role; `None` if that goes elsewhere.
    pub fn message(&self, role: Role) -> Option<&Message> {
        self.messages[role as usize].as_ref()
    }

    /// When in a cycle frames of a role are sent.
    pub(super) fn sent_at(&self, role: Role) -> Time {
        match role {
            Role::Measurement => 0,
            Role::Control => self.controller_at,
            Role::Acknowledgement => self.actuator_at,
        }
    }

    /// When in a cycle frames of a role are taken.
    pub(super) fn taken_at(&self, role: Role) -> Time {
        match role {
            Role::Measurement | Role::Acknowledgement => self.controller_at,
            Role::Control => self.actuator_at,
        }
    }

    /// Longest period of the other traffic, in nanoseconds; 0 without any.
    pub(super) fn longest_period(&self) -> Time {
        let period = |pattern: &Pattern| match *pattern {
            Pattern::Periodic { period, offset, .. } => period.max(offset),
            Pattern::Sporadic { minimum, extra } => minimum + extra,
        };
        self.settings.sources.iter().map(|source| period(&source.pattern)).max().unwrap_or(0)
    }
}
