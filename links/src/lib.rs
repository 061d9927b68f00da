//! What packets meet between two nodes: delays, losses, bursts, other traffic on the bus; simulated or recorded.
//!
//! Nothing here knows of plants, gains or controllers: packets are bytes, and time is counted in control cycles, or in bit
//! times on a bus.
//!
//! | room | what lives there |
//! |---|---|
//! | [`delay`] | a distribution of delays in whole cycles, with losses |
//! | [`can`] | a CAN bus with other traffic and errors on it, event by event in bit times |
//! | [`identify`] | from logs of a real link to its delay distribution, with what speaks against it |

pub mod can;
pub mod delay;
pub mod identify;
