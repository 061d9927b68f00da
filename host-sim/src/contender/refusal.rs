//! Why a controller cannot be simulated, and what can be told of that from the design alone.

use super::{Kind, adapting::can_be_tuned, channel::MOST_TABLES};
use gain_gen::{
    design::{Acknowledgement, Design},
    solve::PreviewTooLong,
};

/// Why a controller cannot be simulated.
#[derive(Debug, Clone, thiserror::Error)]
pub enum ContenderError {
    /// No gains stabilise the loop.
    #[error("`{controller}` cannot stabilise the loop")]
    Unstable {
        /// The controller.
        controller: &'static str,
    },
    /// The design tracks something that it does not give.
    #[error("tracking.reference: missing; give the points in time that the simulation is to follow")]
    NoReference,
    /// The preview cannot be as long as asked.
    #[error(transparent)]
    Preview(#[from] PreviewTooLong),
    /// The controller differs from `slqg` in something that the design does not have.
    #[error("`{controller}` is `slqg` here: the design has no {table}; leave it out")]
    Pointless {
        /// The controller.
        controller: &'static str,
        /// The table it is about.
        table: &'static str,
    },
    /// There is no channel to know.
    #[error(
        "`slqg-channel` needs a link controller_to_actuator given as gilbert_elliott or markov: on others packets are \
         independent, and `slqg` is optimal"
    )]
    NoChannel,
    /// The channel's designs do not go with something else the design asks for.
    #[error("`slqg-channel` cannot go with {with}: {reason}; leave it out, or simulate `slqg`")]
    ChannelAlone {
        /// The key.
        with: &'static str,
        /// Why.
        reason: &'static str,
    },
    /// The channel is too rich for the simulator.
    #[error(
        "`slqg-channel`: a channel of {states} states and sequences of {length} inputs make more than {MOST_TABLES} tables; \
         shorten the sequences"
    )]
    TooManyTables {
        /// States of the channel.
        states: usize,
        /// Inputs per sequence.
        length: usize,
    },
    /// What the controller would not solve for itself would stay as it was.
    #[error("`slqg-tuning` cannot go with {with}: {reason}; leave it out, or simulate `slqg`")]
    TunesAlone {
        /// The key.
        with: &'static str,
        /// Why.
        reason: &'static str,
    },
    /// Of a bus the link cannot be taken alone.
    #[error("a link on a bus cannot change during a run: what becomes of packets there is up to the traffic")]
    ChangesOnBus,
    /// A task cannot decide whether to send.
    #[error(
        "`slqg-task` cannot be event-triggered: what sending is worth is known for a loop that goes on; leave [event] out, or simulate `slqg`"
    )]
    TriggeredTask,
    /// The controller has no form that follows a reference.
    #[error(
        "`{controller}` follows no reference: its law is made without one; leave [tracking] out, or simulate `nominal`, which is told \
         the reference ahead"
    )]
    FollowsNothing {
        /// The controller.
        controller: &'static str,
    },
}

/// Whether the design has what the controller is about, and nothing that it cannot do.
pub(super) fn makes_sense(kind: Kind, design: &Design) -> Result<(), ContenderError> {
    let controller = kind.name();
    match kind {
        Kind::SlqgAlways | Kind::SlqgPeriodic if design.event.is_none() => {
            Err(ContenderError::Pointless { controller, table: "[event]" })
        }
        Kind::SlqgPeriodic if design.tracking.is_some() => Err(ContenderError::FollowsNothing { controller }),
        Kind::SlqgNoPreview if design.tracking.is_none() => {
            Err(ContenderError::Pointless { controller, table: "[tracking]" })
        }
        Kind::SlqgTuning => can_be_tuned(design),
        Kind::SlqgTask if design.event.is_some() => Err(ContenderError::TriggeredTask),
        Kind::Mpc if design.tracking.is_some() => Err(ContenderError::FollowsNothing { controller }),
        Kind::SlqgChannel => {
            let (with, reason) = if design.event.is_some() {
                ("[event]", "what sending is worth is known for independent packets")
            } else if design.tracking.is_some() {
                ("[tracking]", "preview gains are known for independent packets")
            } else if design.network.acknowledgement != Acknowledgement::Instant {
                ("network.acknowledgement", "its gains are for ages known one cycle late")
            } else {
                return Ok(());
            };
            Err(ContenderError::ChannelAlone { with, reason })
        }
        _ => Ok(()),
    }
}
