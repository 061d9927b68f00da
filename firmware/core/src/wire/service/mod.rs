//! Payloads between a node and its host: the clock, what a node did, gains and references for it. Bytes 7 and on:
//!
//! ```text
//! clock           1 if cycle `tick` begins, 0 if it comes next (1 byte); period (4 bytes): microseconds until the next one, 0 if the node is to wait for it
//! applied         age (1 byte, as in an acknowledgement), inputs (1 byte), then one scalar per input
//! ran             1 if a control frame was sent, else 0 (1 byte); duration of the cycle in ticks of the node's clock (4 bytes)
//! part of gains   offset (2 bytes), length of the whole blob (2 bytes), then bytes of the blob from the offset on
//! answer          bytes of the blob received so far (2 bytes), verdict (1 byte)
//! reference       outputs (1 byte), samples (1 byte), then the scalars of each sample, from cycle `tick` on
//! question        nothing
//! status          role (1 byte), then six counts (4 bytes each), see [`Status`]
//! tuned           step (1 byte): 0 started, 1 switched, 2 kept; backward steps (4 bytes); distance or rate (binary32)
//! ```
//!
//! No node needs any of them to control: they tell it the time, and tell its host what it does. Those of fixed length are
//! here, the others in `lists`.

mod lists;

use super::envelope::{Kind, Reader, Writer};
use super::{DecodeError, EncodeError};
use crate::{Scalar, Tick};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

pub use lists::{
    GainsPart, Reference, decode_applied, decode_gains_part, decode_reference, encode_applied,
    encode_gains_part, encode_reference,
};

/// Bytes of the longest of these payloads, that of a status.
pub(super) const LONGEST: usize = 1 + 6 * 4;

/// A payload of fixed length.
pub trait Service: Serialize + DeserializeOwned {
    /// Of the frame that carries it.
    const KIND: Kind;
    /// Bytes of the payload.
    const LEN: usize;
}

/// Writes a frame about cycle `tick`, [`super::LONGEST_SERVICE`] bytes at most; `T` is the scalar of the loop.
///
/// # Errors
/// If `buffer` is too small.
pub fn encode_service<'b, T: Scalar, S: Service>(
    tick: Tick,
    service: &S,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    let mut writer = Writer::new::<T>(buffer, S::KIND, tick)?;
    writer.put(service)?;
    writer.seal()
}

/// Reads such a frame: its cycle and what it says.
///
/// # Errors
/// Says why the bytes are none.
pub fn decode_service<T: Scalar, S: Service>(frame: &[u8]) -> Result<(Tick, S), DecodeError> {
    let (tick, mut reader) = Reader::open::<T>(frame, S::KIND)?;
    let service = reader.take(S::LEN)?;
    reader.finish()?;
    Ok((tick, service))
}

/// Cycle `tick` begins: nodes that hear it run it. Or it comes next: a node that has just started takes frames for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// Whether it begins now.
    pub begins: bool,
    /// Time until the next one begins, in microseconds: a node that does not hear that begins it by itself. Zero: it waits.
    #[serde(with = "postcard::fixint::le")]
    pub period_us: u32,
}

/// The controller has run cycle `tick`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ran {
    /// Whether it has sent a control frame.
    pub sent: bool,
    /// How long it took, frames taken in before it included, in ticks of the node's own clock.
    #[serde(with = "postcard::fixint::le")]
    pub duration: u32,
}

/// How far a blob has come; `tick` is the number of its transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct GainsAnswer {
    /// Bytes received without a gap: the offset of the next part.
    #[serde(with = "postcard::fixint::le")]
    pub received: u16,
    /// What has become of it.
    pub verdict: Verdict,
}

/// What has become of a blob.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Verdict {
    /// Parts are missing.
    Incomplete,
    /// The gains are in force from the next cycle on.
    InForce,
    /// It is longer than the node has room for.
    TooLong,
    /// Damaged, or no blob.
    Damaged,
    /// Of another version or scalar.
    Format,
    /// For another plant.
    Design,
    /// For another number of states or inputs, another sequence length or default input.
    Dimensions,
    /// Its numbers are no gains.
    Numbers,
}

/// Asks a node how it is; `tick` is of no account.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Question {}

/// Which node says how it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Role {
    /// The controller.
    Controller,
    /// The actuator.
    Actuator,
}

/// How a node is in cycle `tick`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// Which node it is.
    pub role: Role,
    /// Cycles run since its start.
    #[serde(with = "postcard::fixint::le")]
    pub cycles: u32,
    /// Times the clock came with another cycle than the node was in.
    #[serde(with = "postcard::fixint::le")]
    pub realigned: u32,
    /// Frames that changed nothing.
    #[serde(with = "postcard::fixint::le")]
    pub rejected: u32,
    /// Frames lost because a queue was full or a frame was too long.
    #[serde(with = "postcard::fixint::le")]
    pub overruns: u32,
    /// Most bytes of stack in use so far.
    #[serde(with = "postcard::fixint::le")]
    pub stack: u32,
    /// Bytes of variables.
    #[serde(with = "postcard::fixint::le")]
    pub variables: u32,
}

/// What a controller that tunes itself did in cycle `tick`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tuned {
    /// What it did.
    pub step: TuningStep,
    /// Backward steps of the solution; 0 unless it switched.
    #[serde(with = "postcard::fixint::le")]
    pub steps: u32,
    /// How far the link is from the one in force, where it started; the bound of the mean-square rate, where it switched;
    /// else 0.
    pub value: f32,
}

/// What a controller that tunes itself does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum TuningStep {
    /// It has begun to solve for another link.
    Started,
    /// New gains are in force from the next cycle on.
    Switched,
    /// What was found was not put in force.
    Kept,
}

macro_rules! service {
    ($($name:ident: $len:expr),*) => {
        $(impl Service for $name {
            const KIND: Kind = Kind::$name;
            const LEN: usize = $len;
        })*
    };
}
service!(Clock: 1 + 4, Ran: 1 + 4, GainsAnswer: 2 + 1, Question: 0, Status: LONGEST, Tuned: 1 + 4 + 4);
