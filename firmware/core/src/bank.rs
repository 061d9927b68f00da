//! `Bank`: two sets of gain tables, one in force and one that may be written.
//!
//! A law that is replaced while the loop runs is never in force by halves: whoever brings new tables (the link,
//! [`crate::blob`], or [`crate::synthesis`] on the device) writes the spare ones, over as many cycles as it takes, and
//! switches when all of them are there and have been checked. Where tables come from is not known here, and what they
//! do is [`crate::gains`]' business.

use crate::{
    Scalar,
    blob::{self, BlobError, DesignId, Shape, storage_len},
    checked::{Finite, Probabilities},
    controller::Law,
    gains::{Gains, InvalidGains, Tables},
    integrity::{Part, Round, Twice},
    played::DefaultInput,
};

/// Two laws of the same dimensions, in memory that is lent.
///
/// ```
/// use slqg::DefaultInput;
/// use slqg::bank::{Bank, memory_len};
/// use slqg::blob::Shape;
///
/// // Laws for one state, one input and two inputs a sequence: `Lx`, `M` and `r` are five numbers.
/// const SHAPE: Shape = Shape { length: 2, states: 1, inputs: 1, default_input: DefaultInput::Zero };
/// let mut memory = [0.0_f32; memory_len(&SHAPE)];
/// let mut bank = Bank::<f32, 1, 1>::new(2, DefaultInput::Zero, &mut memory).expect("memory enough");
/// assert_eq!(bank.law(), None);
/// bank.spare().copy_from_slice(&[-1.0, -2.0, 0.25, 0.0, 0.5]);
/// bank.switch(0.75).expect("gains");
/// assert_eq!(bank.law().expect("in force").gains.arrival(1, 0), 0.5);
/// ```
#[derive(Debug)]
pub struct Bank<'m, T, const NX: usize, const NU: usize> {
    length: usize,
    default_input: DefaultInput,
    sets: [&'m mut [T]; 2],
    choice: Twice<Choice<T>>,
    /// CRC-32/ISCSI of the tables in force: of the bytes of their blob, or as they were when they were put in force.
    checksum: u32,
    round: Round,
}

/// Which set is in force.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Choice<T> {
    /// The set that may be written; the other is in force, if any is.
    spare: usize,
    /// `q(0)` of the law in force; `None` while none of the bank's is.
    in_force: Option<T>,
}

/// Why the tables are not put in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InvalidLaw {
    /// They are no gains.
    Gains(InvalidGains),
    /// The probability to arrive at once is not within 0..=1.
    NotAProbability,
}

impl core::fmt::Display for InvalidLaw {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Gains(why) => why.fmt(f),
            Self::NotAProbability => f.write_str("the probability to arrive at once is not within 0..=1"),
        }
    }
}

impl core::error::Error for InvalidLaw {}

/// Numbers of memory that a bank for laws of this shape is lent.
pub const fn memory_len(shape: &Shape) -> usize {
    storage_len(shape).saturating_mul(2)
}

impl<'m, T: Scalar, const NX: usize, const NU: usize> Bank<'m, T, NX, NU> {
    /// A bank without a law, for sequences of `length` inputs. `None` if `memory` is less than [`memory_len`] of this shape.
    pub fn new(length: usize, default_input: DefaultInput, memory: &'m mut [T]) -> Option<Self> {
        let needed = storage_len(&Shape { length, states: NX, inputs: NU, default_input });
        let (first, rest) = memory.split_at_mut_checked(needed)?;
        let second = rest.get_mut(..needed)?;
        let choice = Twice::new(Choice { spare: 0, in_force: None });
        Some(Self { length, default_input, sets: [first, second], choice, checksum: 0, round: Round::START })
    }

    /// Dimensions of the laws it holds.
    pub fn shape(&self) -> Shape {
        Shape { length: self.length, states: NX, inputs: NU, default_input: self.default_input }
    }

    /// Room for tables that are not in force: `Lx`, `M`, `r` one after the other, by rows.
    pub fn spare(&mut self) -> &mut [T] {
        // Of a choice that has changed by itself either set may be written: no law is in force.
        let [first, second] = &mut self.sets;
        if self.choice.either().spare == 0 { first } else { second }
    }

    /// The set in force, if one is; it may be the wrong one only if [`Bank::check_memory`] says so.
    fn numbers_in_force(&self) -> Option<(&[T], T)> {
        let Choice { spare, in_force } = self.choice.get()?;
        let [first, second] = &self.sets;
        Some((if *spare == 0 { second } else { first }, (*in_force)?))
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
        })?;
        // Of the bytes whose own checksum was right, so that what was written wrong is found, too.
        self.checksum = blob::tables_checksum(blob);
        Ok(())
    }

    /// Puts what was written to [`Bank::spare`] in force, and makes the other set spare. `arrives_at_once` is `q(0)` of the
    /// link that the gains are for.
    ///
    /// # Errors
    /// If the numbers are no gains; the law in force stays, and the spare set may be written again.
    pub fn switch(&mut self, arrives_at_once: T) -> Result<(), InvalidLaw> {
        let shape = self.shape();
        let numbers = &*self.spare();
        let checksum = Round::whole(&|place| whole(place, numbers));
        let [lx, m, arrival] = shape.split(numbers);
        Tables::check(lx, m, arrival).map_err(InvalidLaw::Gains)?;
        // NaN is outside.
        if !(T::zero()..=T::one()).contains(&arrives_at_once) {
            return Err(InvalidLaw::NotAProbability);
        }
        let spare = if self.choice.either().spare == 0 { 1 } else { 0 };
        self.choice.set(Choice { spare, in_force: Some(arrives_at_once) });
        (self.checksum, self.round) = (checksum, Round::START);
        Ok(())
    }

    /// Puts no law of the bank in force: that of the design is again.
    pub fn withdraw(&mut self) {
        if let Some(choice) = self.choice.get() {
            self.choice.set(Choice { in_force: None, ..*choice });
        }
    }

    /// Takes up to `numbers` more of the tables in force through a checksum. `false` if they, or which of them are in force, have
    /// changed by themselves: whoever runs under their law must be told, [`crate::controller::Controller::report_memory_fault`].
    ///
    /// It is for idle time, as [`crate::controller::Controller::check_memory`], which knows nothing of a bank.
    pub fn check_memory(&mut self, numbers: usize) -> bool {
        let Self { sets: [first, second], choice, checksum, round, .. } = self;
        let Some(Choice { spare, in_force }) = choice.get() else { return false };
        let tables = if *spare == 0 { &**second } else { &**first };
        in_force.is_none()
            || round.go_on(numbers, &|place| whole(place, tables)).is_none_or(|found| found == *checksum)
    }

    /// The law in force, for [`crate::controller::Controller::cycle_under`]; `None` while that of the design is.
    pub fn law(&self) -> Option<Law<'_, T, NX, NU>> {
        let (numbers, arrives_at_once) = self.numbers_in_force()?;
        // Checked before they were put in force, and not written to since.
        let [lx, m, arrival] = self.shape().split(numbers);
        let (lx, m, arrival) = (Finite::checked(lx), Finite::checked(m), Probabilities::checked(arrival));
        let gains = Gains::check(self.length, self.default_input, Tables { lx, m, arrival }).ok()?;
        Some(Law { gains, arrives_at_once })
    }
}

/// A set as one table.
fn whole<T>(place: usize, numbers: &[T]) -> Part<'_, T> {
    if place == 0 { Part::Numbers(numbers) } else { Part::End }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One state, one input, two inputs a sequence: `Lx`, `M`, `r` of 2, 2 and 1 numbers.
    fn bank(memory: &mut [f32; 10]) -> Bank<'_, f32, 1, 1> {
        Bank::new(2, DefaultInput::Zero, memory).expect("five numbers fit twice")
    }

    #[test]
    fn a_law_is_in_force_only_after_the_switch() {
        let mut memory = [0.0; 10];
        let mut bank = bank(&mut memory);
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
        let mut memory = [0.0; 10];
        let mut bank = bank(&mut memory);
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
        let mut memory = [0.0; 14];
        assert!(Bank::<f32, 1, 1>::new(2, DefaultInput::Zero, &mut memory[..9]).is_none());
        // With hold, M has a column more.
        assert!(Bank::<f32, 1, 1>::new(2, DefaultInput::Hold, &mut memory[..13]).is_none());
        assert!(Bank::<f32, 1, 1>::new(2, DefaultInput::Hold, &mut memory).is_some());
    }

    #[test]
    fn a_bit_that_flips_in_the_law_in_force_is_found_within_one_round_and_one_in_the_spare_set_is_none() {
        for (place, bit) in (0..10).flat_map(|place| (0..32).map(move |bit| (place, bit))) {
            let mut memory = [0.0; 10];
            let mut bank = bank(&mut memory);
            bank.spare().copy_from_slice(&[-1.0, -2.0, 0.25, 0.0, 0.5]);
            bank.switch(0.75).unwrap();
            let number = &mut bank.sets[place / 5][place % 5];
            *number = f32::from_bits(number.to_bits() ^ 1 << bit);
            // Five numbers, two at a time.
            let is_sound = (0..3).all(|_| bank.check_memory(2));
            assert_eq!(is_sound, place >= 5, "number {place}, bit {bit}");
        }
    }

    #[test]
    fn a_choice_that_changes_by_itself_puts_no_law_in_force_and_is_told() {
        for of_copy in [false, true] {
            let mut memory = [0.0; 10];
            let mut bank = bank(&mut memory);
            bank.choice.damage(of_copy, |choice| choice.in_force = Some(0.5));
            assert_eq!(bank.law(), None, "gains of zero");
            assert!(!bank.check_memory(1));
        }
    }
}
