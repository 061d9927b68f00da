//! Which frame is which on the bus: three kinds in the compact form, and the clock.

use super::clock;
use embedded_can::{Frame, Id};
use slqg::{
    Scalar, Tick,
    blob::DesignId,
    wire::{
        self, Clock, Kind,
        can::{Check, Compact, Grid, Identifiers, InvalidCompact, PackError, UnpackError},
    },
};

/// A loop's form on a classic CAN bus; does not change while it runs, and is the same at all nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form<T, const NU: usize, const NY: usize> {
    clock: Id,
    check: Check,
    identifiers: Identifiers,
    compact: Compact<T, NU, NY>,
}

impl<T: Scalar, const NU: usize, const NY: usize> Form<T, NU, NY> {
    /// The form of the loop with the plant of `design`, with these identifiers and grids; id and grids are those that `gain-gen`
    /// writes for a design with `wire.format = "can-classic"`.
    ///
    /// The lowest identifier wins the bus: give it to the clock, which all nodes wait for.
    ///
    /// # Errors
    /// If two of the four identifiers are the same, or as [`Compact::new`].
    pub fn new(
        design: DesignId,
        clock: Id,
        identifiers: Identifiers,
        inputs: Grid<T, NU>,
        outputs: Grid<T, NY>,
    ) -> Result<Self, InvalidCompact> {
        let Identifiers { measurement, control, acknowledgement } = identifiers;
        if [measurement, control, acknowledgement].contains(&clock) {
            return Err(InvalidCompact::Identifiers);
        }
        let compact = Compact::new(design, identifiers, inputs, outputs)?;
        Ok(Self { clock, check: Check::new(design), identifiers, compact })
    }

    /// The identifier of frames of this kind, for a driver's filters; `None` if they do not go over the bus.
    pub fn identifier(&self, kind: Kind) -> Option<Id> {
        match kind {
            Kind::Clock => Some(self.clock),
            Kind::Measurement => Some(self.identifiers.measurement),
            Kind::Control => Some(self.identifiers.control),
            Kind::Acknowledgement => Some(self.identifiers.acknowledgement),
            _ => None,
        }
    }

    /// The kind that this identifier stands for; `None` if it is a stranger's.
    pub fn kind(&self, id: Id) -> Option<Kind> {
        [Kind::Clock, Kind::Measurement, Kind::Control, Kind::Acknowledgement]
            .into_iter()
            .find(|kind| self.identifier(*kind) == Some(id))
    }

    /// The CAN frame for the full frame `frame`.
    ///
    /// # Errors
    /// Says why `frame` is none of this loop, or does not fit.
    pub fn pack<F: Frame>(&self, frame: &[u8]) -> Result<F, PackError> {
        if Kind::of(frame) != Some(Kind::Clock) {
            return self.compact.pack(frame);
        }
        let (tick, told) = wire::decode_service::<T, Clock>(frame).map_err(PackError::Decode)?;
        clock::pack(self.clock, self.check, tick, told)
    }

    /// The full frame that `frame` stands for, written into `buffer`, [`super::LONGEST`] bytes at most. `now` is the
    /// receiver's own tick, as for [`Compact::unpack`]; the clock has a whole tick of its own, and its check covers that.
    ///
    /// # Errors
    /// Says why `frame` is none of this loop, or does not fit `buffer`.
    pub fn unpack<'b, F: Frame>(
        &self,
        frame: &F,
        now: Tick,
        buffer: &'b mut [u8],
    ) -> Result<&'b [u8], UnpackError> {
        if frame.id() != self.clock {
            return self.compact.unpack(frame, now, buffer);
        }
        let (tick, told) = clock::unpack(frame, self.check)?;
        wire::encode_service::<T, _>(tick, &told, buffer).map_err(UnpackError::Encode)
    }
}
