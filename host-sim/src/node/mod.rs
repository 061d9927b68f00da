//! The loop in real time: controller, actuator, plant and link as processes that pass each other datagrams.
//!
//! As in [`crate::closed_loop`] there is no controller and no actuator here: both are the core's. What lives here is what runs
//! them by the wall clock, and what carries their frames. docs/real-time.md is the page for users.
//!
//! | room | what lives there |
//! |---|---|
//! | [`clock`] | cycles on the wall clock, and what becomes of those that were missed |
//! | [`clock_offset`] | whether another node's clock is apart from this one's |
//! | [`event_loop`] | the loop of every node: act, sleep, receive |
//! | [`controller`], [`actuator`], [`plant`], [`relay`] | what each node does, told the time |
//! | [`transport`] | UDP and CAN FD |
//! | [`applied`] | the datagram from the actuator to the plant |
//! | [`arrivals`], [`statistics`] | what is counted, and how it is printed |
//! | `options`, `loaded`, `carrier`, `start` | from the command line to a node that runs |

pub mod actuator;
pub mod applied;
pub mod arrivals;
mod carrier;
pub mod clock;
pub mod clock_offset;
pub mod controller;
pub mod event_loop;
mod loaded;
mod options;
pub mod plant;
pub mod relay;
mod start;
pub mod statistics;
pub mod transport;

pub use options::Options;
pub use start::run;

/// Why a node does not run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NodeError {
    /// The design or an option is wrong.
    #[error("{0}")]
    Input(String),
    /// No gains stabilise the loop.
    #[error("{0}")]
    Unstable(String),
}
