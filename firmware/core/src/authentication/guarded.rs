//! A controller or an actuator behind its guard: what it takes has been opened, what it sends is sealed.

use super::{Guard, HEAD_LEN, HELLO_LEN, Nonces, NotSealed, Opened, Refused};
use crate::{
    Scalar, actuator,
    actuator::{Actuator, Applied},
    controller,
    controller::Controller,
    wire::{self, EncodeError},
};

/// An end and its guard. The end is the same as without one.
#[derive(Debug)]
pub struct Guarded<E, const S: usize> {
    end: E,
    guard: Guard<S>,
}

/// Why a frame changed nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NotTaken<R> {
    /// The guard has refused it.
    Refused(Refused),
    /// The end has.
    Rejected(R),
}

impl<R: core::fmt::Display> core::fmt::Display for NotTaken<R> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Refused(why) => why.fmt(f),
            Self::Rejected(why) => why.fmt(f),
        }
    }
}

impl<R: core::error::Error> core::error::Error for NotTaken<R> {}

/// The answer to a hello, if the bytes were one that has an answer.
type Answer = Option<[u8; HELLO_LEN]>;

impl<E, const S: usize> Guarded<E, S> {
    /// `end` behind `guard`.
    pub fn new(end: E, guard: Guard<S>) -> Self {
        Self { end, guard }
    }

    /// The end.
    pub fn end(&self) -> &E {
        &self.end
    }

    /// Its guard.
    pub fn guard(&self) -> &Guard<S> {
        &self.guard
    }

    /// Its guard, for what is done with it beside frames of the loop.
    pub fn guard_mut(&mut self) -> &mut Guard<S> {
        &mut self.guard
    }

    fn open<R>(
        &mut self,
        bytes: &[u8],
        nonces: &mut impl Nonces,
        receive: impl FnOnce(&mut E, &[u8]) -> Result<(), R>,
    ) -> Result<Answer, NotTaken<R>> {
        match self.guard.open(bytes, nonces).map_err(NotTaken::Refused)? {
            Opened::Hello(answer) => Ok(answer),
            Opened::Frame(frame) => {
                receive(&mut self.end, frame).map_err(NotTaken::Rejected)?;
                Ok(None)
            }
        }
    }
}

/// What an end encodes, sealed in the same buffer.
fn sealed<'b, const S: usize>(
    guard: &mut Guard<S>,
    buffer: &'b mut [u8],
    len: usize,
) -> Result<&'b [u8], NotSealed> {
    let sealed = buffer.get_mut(..HEAD_LEN + len).ok_or(NotSealed::BufferTooSmall)?;
    let (head, frame) = sealed.split_at_mut(HEAD_LEN);
    head.copy_from_slice(&guard.head(frame)?);
    Ok(sealed)
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize, const S: usize>
    Guarded<Controller<'_, T, NX, NU, NY>, S>
{
    /// Takes bytes from the link: any number of them, in any order. Returns the answer to a hello.
    ///
    /// # Errors
    /// Says why they changed nothing. It is counted, by the guard or by the controller.
    pub fn receive(
        &mut self,
        bytes: &[u8],
        nonces: &mut impl Nonces,
    ) -> Result<Answer, NotTaken<controller::RejectedFrame>> {
        self.open(bytes, nonces, |controller, frame| controller.receive(frame))
    }

    /// Runs one cycle, [`Controller::cycle`]; `buffer` holds [`HEAD_LEN`] bytes more than it takes. `None` if nothing is to be
    /// sent, or cannot be sealed: the controller takes a sequence that was not sealed for one that was lost.
    ///
    /// # Errors
    /// If the buffer is too small.
    pub fn cycle<'b>(&mut self, buffer: &'b mut [u8]) -> Result<Option<&'b [u8]>, EncodeError> {
        self.guard.cycle();
        let room = buffer.get_mut(HEAD_LEN..).ok_or(EncodeError::BufferTooSmall)?;
        let Some(len) = self.end.cycle(room)?.map(<[u8]>::len) else { return Ok(None) };
        Ok(sealed(&mut self.guard, buffer, len).ok())
    }
}

impl<T: Scalar, const NU: usize, const S: usize> Guarded<Actuator<'_, T, NU>, S> {
    /// Takes bytes from the link: any number of them, in any order. Returns the answer to a hello.
    ///
    /// # Errors
    /// Says why they changed nothing. It is counted, by the guard or by the actuator.
    pub fn receive(
        &mut self,
        bytes: &[u8],
        nonces: &mut impl Nonces,
    ) -> Result<Answer, NotTaken<actuator::RejectedFrame>> {
        self.open(bytes, nonces, |actuator, frame| actuator.receive(frame))
    }

    /// Plays one cycle, [`Actuator::step`].
    pub fn step(&mut self) -> Applied<T, NU> {
        self.guard.cycle();
        self.end.step()
    }

    /// The acknowledgement of the last `cycles` cycles, sealed; `buffer` holds [`HEAD_LEN`] bytes more than
    /// [`wire::LONGEST_ACKNOWLEDGEMENT`]. `None` if nothing was played yet, or it cannot be sealed.
    pub fn acknowledgement<'b>(&mut self, cycles: usize, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        let told = self.end.acknowledgement(cycles)?;
        let len = wire::encode_acknowledgement::<T>(&told, buffer.get_mut(HEAD_LEN..)?).ok()?.len();
        sealed(&mut self.guard, buffer, len).ok()
    }
}
