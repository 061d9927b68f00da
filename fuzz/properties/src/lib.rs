//! What must hold whatever bytes come in: one function for each way in, which panics where it does not hold.
//!
//! The same functions are run by libFuzzer, on bytes that it finds (`fuzz`, the folder above, and `cargo xtask fuzz`), and by this
//! crate's tests, on the bytes that are kept in `fuzz/corpus`. A function takes its bytes as they are, or reads a script from them:
//! what happens to an end of the loop, cycle by cycle, in frames whose checksums and tags are right.
//!
//! | room | what lives there |
//! |---|---|
//! | [`wire`] | frames of the loop |
//! | [`serial`] | frames on a serial line |
//! | [`service`] | frames between a node and its host |
//! | [`can`] | frames on a CAN bus, classic and FD |
//! | [`actuator`] | an actuator and the frames that it takes |
//! | [`controller`] | a controller and the frames that it takes |
//! | [`sealed`] | both behind guards, and somebody on their line |
//! | [`node`] | the programs of both boards, and what comes over their line |
//! | [`blob`] | gains as bytes |
//! | [`gains`] | gains that come over the link |
//! | [`logs`] | logs of a link |
//! | [`design`] | design files, and what is emitted of them |
//! | [`solved`] | the same for designs that are made up |
//! | `plant` | the loop that they all are of |
//! | [`script`] | frames and numbers, read from bytes |
//! | [`seeds`] | the bytes in `fuzz/corpus` |

pub mod actuator;
pub mod blob;
pub mod can;
pub mod controller;
pub mod design;
pub mod gains;
pub mod logs;
pub mod node;
mod plant;
pub mod script;
pub mod sealed;
pub mod seeds;
pub mod serial;
pub mod service;
pub mod solved;
pub mod wire;

/// A property of any bytes; it panics where they break it.
pub type Property = fn(&[u8]);

/// Every property by its name, which the program for libFuzzer and the folder of its corpus have, too.
pub const PROPERTIES: [(&str, Property); 13] = [
    ("actuator", actuator::check),
    ("blob", blob::check),
    ("can", can::check),
    ("controller", controller::check),
    ("design", design::check),
    ("gains", gains::check),
    ("logs", logs::check),
    ("node", node::check),
    ("sealed", sealed::check),
    ("serial", serial::check),
    ("service", service::check),
    ("solved", solved::check),
    ("wire", wire::check),
];

/// The property of that name.
pub fn named(name: &str) -> Option<Property> {
    PROPERTIES.iter().find(|(known, _)| *known == name).map(|(_, property)| *property)
}
