//! `Bank`: two sets of gain tables, one in force and one that may be written.
//!
//! A law that is replaced while the loop runs is never in force by halves: whoever brings new tables (the link,
//! [`crate::blob`], or [`crate::synthesis`] on the device) writes the spare ones, over as many cycles as it takes, and
//! switches when all of them are there and have been checked. Where tables come from is not known here, and what they
//! do is [`crate::gains`]' business.

use crate::{
    DefaultInput, Scalar,
    blob::{self, BlobError, DesignId, Shape, storage_len},
    controller::Law,
    gains::{Gains, InvalidGains, Tables},
};

/// Room for two laws of the same dimensions, `LEN` numbers or more each.
#[derive(Debug, Clone)]
pub struct Bank<T, const NX: usize, const NU: usize, const LEN: usize> {
    length: usize,
    default_input: DefaultInput,
    sets: [[T; LEN]; 2],
    /// The set that may be written; the other is in force, if any is.
    spare: usize,
    /// `q(0)` of the law in force; `None` while none of the bank's is.
    in_force: Option<T>,
}

/// Why the tables are not put in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InvalidLaw {
    /// They are no gains.
    Gains(InvalidGains),
    /// The probability to arrive at once is not within 0..=1.
    NotAProbability,
}

impl<T: Scalar, const NX: usize, const NU: usize, const LEN: usize> Bank<T, NX, NU, LEN> {
    /// A bank without a law, for sequences of `length` inputs. `None` if `LEN` is less than [`storage_len`] of this shape.
    pub fn new(length: usize, default_input: DefaultInput) -> Option<Self> {
        let shape = Shape { length, states: NX, inputs: NU, default_input };
        (storage_len(&shape) <= LEN).then_some(Self {
            length,
            default_input,
            sets: [[T::zero(); LEN]; 2],
            spare: 0,
            in_force: None,
        })
    }

    /// Dimensions of the laws it holds.
    pub fn shape(&self) -> Shape {
        Shape { length: self.length, states: NX, inputs: NU, default_input: self.default_input }
    }

    /// Room for tables that are not in force: `Lx`, `M`, `r` one after the other, by rows.
    pub fn spare(&mut self) -> &mut [T] {
        let needed = storage_len(&self.shape());
        &mut self.sets[self.spare][..needed]
    }

    /// Puts the law of a blob in force, if it is one of the plant `expected` and of the bank's dimensions. `arrives_at_once` is
    /// `q(0)` of the link, which a blob does not tell.
    ///
    /// # Errors
    /// Says why it is not put in force; the law in force stays.
    pub fn load(&mut self, blob: &[u8], expected: DesignId, arrives_at_once: T) -> Result<(), BlobError> {
        let found = blob::header(blob)?;
        let shape = self.shape();
        let is_for_others =
            (found.shape.states, found.shape.inputs) == (shape.states, shape.inputs) && found.shape != shape;
        if is_for_others && found.design == expected {
            return Err(BlobError::Sequence);
        }
        blob::load::<T, NX, NU>(blob, self.spare(), Some(expected))?;
        self.switch(arrives_at_once).map_err(|error| match error {
            InvalidLaw::Gains(gains) => BlobError::Gains(gains),
            InvalidLaw::NotAProbability => BlobError::Gains(InvalidGains::NotAProbability),
        })
    }

    /// Puts what was written to [`Bank::spare`] in force, and makes the other set spare. `arrives_at_once` is `q(0)` of the
    /// link that the gains are for.
    ///
    /// # Errors
    /// If the numbers are no gains; the law in force stays, and the spare set may be written again.
    pub fn switch(&mut self, arrives_at_once: T) -> Result<(), InvalidLaw> {
        self.tables(self.spare).check_numbers().map_err(InvalidLaw::Gains)?;
        // NaN is outside.
        if !(T::zero()..=T::one()).contains(&arrives_at_once) {
            return Err(InvalidLaw::NotAProbability);
        }
        self.spare = 1 - self.spare;
        self.in_force = Some(arrives_at_once);
        Ok(())
    }

    /// Puts no law of the bank in force: that of the design is again.
    pub fn withdraw(&mut self) {
        self.in_force = None;
    }

    /// The law in force, for [`crate::controller::Controller::cycle_under`]; `None` while that of the design is.
    pub fn law(&self) -> Option<Law<'_, T, NX, NU>> {
        let arrives_at_once = self.in_force?;
        let gains = Gains::checked(self.length, self.default_input, self.tables(1 - self.spare));
        Some(Law { gains, arrives_at_once })
    }

    fn tables(&self, set: usize) -> Tables<'_, T> {
        self.shape().tables(&self.sets[set])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One state, one input, two inputs a sequence: `Lx`, `M`, `r` of 2, 2 and 1 numbers.
    fn bank() -> Bank<f32, 1, 1, 6> {
        Bank::new(2, DefaultInput::Zero).expect("five numbers fit")
    }

    #[test]
    fn a_law_is_in_force_only_after_the_switch() {
        let mut bank = bank();
        bank.spare().copy_from_slice(&[-1.0, -2.0, 0.25, 0.0, 0.5]);
        assert_eq!(bank.law(), None);
        bank.switch(0.75).unwrap();
        let law = bank.law().expect("just switched");
        assert_eq!(law.arrives_at_once, 0.75);
        assert_eq!(law.gains.arrival(1, 0), 0.5);
        bank.withdraw();
        assert_eq!(bank.law(), None);
    }

    #[test]
    fn writing_the_spare_set_leaves_the_law_in_force_alone() {
        let mut bank = bank();
        bank.spare().copy_from_slice(&[-1.0, -2.0, 0.25, 0.0, 0.5]);
        bank.switch(0.75).unwrap();
        bank.spare().fill(f32::NAN);
        assert_eq!(bank.law().expect("in force").gains.arrival(1, 0), 0.5);
        assert_eq!(bank.switch(0.5), Err(InvalidLaw::Gains(InvalidGains::NotFinite)));
        assert_eq!(bank.law().expect("still in force").arrives_at_once, 0.75);
        bank.spare().fill(0.0);
        assert_eq!(bank.switch(f32::NAN), Err(InvalidLaw::NotAProbability));
        bank.switch(0.5).unwrap();
        assert_eq!(bank.law().expect("the new one").gains.arrival(1, 0), 0.0);
    }

    #[test]
    fn a_bank_too_small_for_its_laws_is_refused() {
        assert!(Bank::<f32, 1, 1, 4>::new(2, DefaultInput::Zero).is_none());
        // With hold, M has a column more.
        assert!(Bank::<f32, 1, 1, 6>::new(2, DefaultInput::Hold).is_none());
        assert!(Bank::<f32, 1, 1, 7>::new(2, DefaultInput::Hold).is_some());
    }
}
