//! What packets meet between two nodes: delays, losses, bursts, other traffic on the bus; simulated or recorded.
//!
//! Nothing here knows of plants, gains or controllers: packets are bytes, and time is counted in control cycles, or in
//! nanoseconds on a bus.
//!
//! | room | what lives there |
//! |---|---|
//! | [`delay`] | a distribution of delays in whole cycles, with losses |
//! | [`markov`] | a channel that comes and goes: bursts of losses and delays |
//! | [`channel`] | such a channel in a simulation, cycle by cycle |
//! | [`recording`] | what became of the packets of a log, to be met again |
//! | [`link`] | any of these between two nodes, and what a single packet meets on it |
//! | [`path`] | packets under way on a link, cycle by cycle |
//! | [`can`] | a CAN bus with other traffic and errors on it, event by event |
//! | [`loop_bus`] | the links of a control loop over one CAN bus, cycle by cycle |
//! | [`identify`] | from logs of a real link to its delay distribution, with what speaks against it |

pub mod can;
pub mod channel;
pub mod delay;
pub mod identify;
pub mod link;
pub mod loop_bus;
pub mod markov;
pub mod path;
pub mod recording;
