//! A round through all parts of what is checked, a few numbers at a time.

use super::part::Part;
use crate::{
    Scalar,
    checksum::{FIRST, after_word},
};

/// How far a round has come.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Round {
    part: usize,
    /// Numbers of this part that are done.
    done: usize,
    remainder: u32,
}

impl Round {
    /// Before the first number.
    pub(crate) const START: Self = Self { part: 0, done: 0, remainder: FIRST };

    /// Takes more numbers, as many as are `left`. `part`: the parts by their place. At the end of the round the checksum of all of them, and another round begins.
    ///
    /// A part that is no table counts for one number.
    // Once in flash, whatever is checked.
    #[inline(never)]
    pub(crate) fn go_on<'p, T: Scalar>(
        &mut self,
        mut left: usize,
        part: &dyn Fn(usize) -> Part<'p, T>,
    ) -> Option<u32> {
        while left > 0 {
            match part(self.part) {
                Part::Numbers(numbers) => {
                    let rest = numbers.get(self.done..).unwrap_or_default();
                    let (now, later) = rest.split_at(rest.len().min(left));
                    self.remainder = after_numbers(self.remainder, now);
                    left -= now.len();
                    self.done += now.len();
                    if !later.is_empty() {
                        return None;
                    }
                }
                Part::Word(word) => {
                    self.remainder = after_word(self.remainder, word);
                    left -= 1;
                }
                Part::End => {
                    let found = !self.remainder;
                    *self = Self::START;
                    return Some(found);
                }
            }
            (self.part, self.done) = (self.part + 1, 0);
        }
        None
    }

    /// The checksum of all parts at once.
    pub(crate) fn whole<'p, T: Scalar>(part: &dyn Fn(usize) -> Part<'p, T>) -> u32 {
        let mut round = Self::START;
        // No memory holds as many.
        round.go_on(usize::MAX, part).unwrap_or_default()
    }
}

fn after_numbers<T: Scalar>(remainder: u32, numbers: &[T]) -> u32 {
    let mut bytes = [0; size_of::<f64>()];
    numbers.iter().fold(remainder, |remainder, number| {
        // There is room for either scalar.
        let _ = number.write(&mut bytes);
        let (words, _) = bytes.as_chunks();
        let words = words.iter().take(usize::from(T::BYTES) / size_of::<u32>());
        words.fold(remainder, |remainder, word| after_word(remainder, u32::from_le_bytes(*word)))
    })
}

#[cfg(test)]
mod tests {
    use super::super::checksum_of;
    use super::*;

    const NUMBERS: [f64; 5] = [1.0, -0.0, 1e300, 3.5, -2.0];
    const PARTS: [Part<'static, f64>; 6] = [
        Part::Numbers(&NUMBERS),
        Part::Numbers(&[]),
        Part::Word(u32::MAX),
        Part::Word(7),
        Part::Numbers(&[0.5]),
        Part::End,
    ];
    const EXPECTED: u32 = checksum_of!(place => PARTS[place]);

    #[test]
    fn a_round_finds_what_the_compiler_found_however_many_numbers_are_taken_at_once() {
        for at_once in 1..=20 {
            let mut round = Round::START;
            for _ in 0..3 {
                let found = (0..20).find_map(|_| round.go_on(at_once, &|place| PARTS[place]));
                assert_eq!(found, Some(EXPECTED), "{at_once} at once");
            }
        }
        assert_eq!(Round::whole(&|place| PARTS[place]), EXPECTED);
    }

    #[test]
    fn a_bit_in_any_number_changes_what_is_found() {
        for (place, bit) in (0..NUMBERS.len()).flat_map(|place| (0..64).map(move |bit| (place, bit))) {
            let mut numbers = NUMBERS;
            numbers[place] = f64::from_bits(numbers[place].to_bits() ^ 1 << bit);
            let parts = |place: usize| if place == 0 { Part::Numbers(&numbers[..]) } else { PARTS[place] };
            assert_ne!(Round::whole(&parts), EXPECTED);
        }
    }

    #[test]
    fn the_checksum_of_a_table_is_that_of_its_bytes_on_the_wire() {
        let bytes: [[u8; 8]; 5] = NUMBERS.map(f64::to_le_bytes);
        let found = Round::whole(&|place| if place == 0 { Part::Numbers(&NUMBERS[..]) } else { Part::End });
        assert_eq!(found, crate::checksum::checksum(bytes.as_flattened()));
    }
}
