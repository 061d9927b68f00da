//! One control cycle: estimate, law, and the frame out, if it is worth one.

use super::{Controller, CycleError, Law, count};
use crate::{
    Scalar,
    wire::{self, EncodeError},
};

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Controller<'_, T, NX, NU, NY> {
    /// Runs one cycle: estimates the state, decides the sequence, and writes it as a frame into `buffer`.
    ///
    /// Returns the frame to send, [`wire::control_len`] bytes; `None` if nothing is to be sent: the sequence is not worth a
    /// packet, or no finite one came out, which costs the loop no more than a lost packet, or the loop is lost. Each is counted. The
    /// actuator needs no word of it: it plays on and acknowledges what it plays. Thesis (3.30), THEORY 3, 7.
    ///
    /// # Errors
    /// If `buffer` is too small for the frame. The cycle is over even so, as if the packet was lost.
    pub fn cycle<'b>(&mut self, buffer: &'b mut [u8]) -> Result<Option<&'b [u8]>, EncodeError> {
        self.run(&self.design.law(), buffer)
    }

    /// As [`Controller::cycle`], under another law than the design's: that of a [`crate::bank::Bank`], which may change from
    /// cycle to cycle. Preview gains and trigger stay as they are.
    ///
    /// # Errors
    /// If the law is for sequences of another length or for another default input, or if `buffer` is too small.
    pub fn cycle_under<'b>(
        &mut self,
        law: &Law<'_, T, NX, NU>,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, CycleError> {
        self.design.check_law(law.gains.length(), law.gains.default_input()).map_err(CycleError::Law)?;
        self.run(law, buffer).map_err(CycleError::Encode)
    }

    fn run<'b>(
        &mut self,
        law: &Law<'_, T, NX, NU>,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, EncodeError> {
        self.open(law);
        self.last.not_finite = !self.in_flight.proposed().is_finite();
        let frame = if self.last.not_finite {
            count(&mut self.counts.not_finite);
            Ok(None)
        } else if self.is_lost() {
            count(&mut self.counts.withheld);
            Ok(None)
        } else if !self.is_worth_sending(law) {
            count(&mut self.counts.not_worth_sending);
            Ok(None)
        } else {
            wire::encode_control(&self.in_flight.proposed(), buffer).map(Some)
        };
        self.close(law, matches!(frame, Ok(Some(_))));
        frame
    }
}
