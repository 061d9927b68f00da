//! What the controller is to follow.

use super::Controller;
use crate::{
    Scalar,
    tracking::{Feedforward, RejectedReference},
};
use nalgebra::SVector;

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Controller<'_, T, NX, NU, NY> {
    /// Follows `reference`: the samples `z_{k+1}, z_{k+2}, ..`, where `k` is the cycle that [`Controller::cycle`] runs
    /// next.
    ///
    /// Samples beyond the design's preview change nothing, and of fewer the last one stands for those missing: a set point
    /// is one sample. The feedforward stays in force until the next call, so a reference that moves is handed over in
    /// every cycle. Before the first call the reference is zero. A sequence that is proposed already stays as it is.
    ///
    /// # Errors
    /// Says why the reference is not followed; the one before stays in force.
    pub fn follow<const NZ: usize>(&mut self, reference: &[SVector<T, NZ>]) -> Result<(), RejectedReference> {
        let preview = self.design.preview.as_ref().ok_or(RejectedReference::NoPreview)?;
        // Beside what is in force, which may have to stay; and beside the sequence, which may be proposed already. What is
        // expected is written anew before it is looked at again.
        let Feedforward { inputs, displaced } =
            preview.fill_feedforward(reference, self.expected, self.room)?;
        put(self.feedforward, inputs);
        put(self.displaced, displaced);
        (self.is_fed_forward, self.displaced_len) = (true, displaced.len());
        Ok(())
    }

    /// Sets the feedforward of the next cycle and those after it, where it was computed beforehand: for tasks of finite
    /// length, cycle by cycle along with [`Controller::set_gains`]. The design needs no preview for that. Inputs that are
    /// missing are zero, those beyond the sequence do not count.
    ///
    /// # Errors
    /// If it is not finite; the one before stays in force.
    pub fn set_feedforward(&mut self, feedforward: Feedforward<'_, T, NU>) -> Result<(), RejectedReference> {
        if !feedforward.is_finite() {
            return Err(RejectedReference::NotFinite);
        }
        put(self.feedforward, feedforward.inputs);
        put(self.displaced, feedforward.displaced);
        self.is_fed_forward = true;
        self.displaced_len = feedforward.displaced.len().min(self.displaced.len());
        Ok(())
    }

    /// The same from a table: the numbers of each input one after the other.
    ///
    /// # Errors
    /// As [`Controller::set_feedforward`].
    pub fn set_feedforward_rows(&mut self, rows: &[T]) -> Result<(), RejectedReference> {
        if !rows.iter().all(|value| value.is_finite()) {
            return Err(RejectedReference::NotFinite);
        }
        self.forget_reference();
        for (input, row) in self.feedforward.iter_mut().zip(rows.chunks_exact(NU.max(1))) {
            input.copy_from_slice(row);
        }
        self.is_fed_forward = true;
        Ok(())
    }

    /// The reference is zero.
    pub(super) fn forget_reference(&mut self) {
        self.feedforward.fill(SVector::zeros());
        (self.is_fed_forward, self.displaced_len) = (false, 0);
    }
}

/// Writes `values`, and zeros after them.
fn put<T: Scalar, const NU: usize>(room: &mut [SVector<T, NU>], values: &[SVector<T, NU>]) {
    let values = values.iter().copied().chain(core::iter::repeat(SVector::zeros()));
    room.iter_mut().zip(values).for_each(|(place, value)| *place = value);
}
