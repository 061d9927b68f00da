//! Pieces of what a checksum is taken of, and the checksum of constants.

use crate::checksum::after_word;

/// A piece of what is checked, in the order in which it is.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Part<'p, T> {
    /// Numbers of a table, vector or matrix; none where an option is not there.
    Numbers(&'p [T]),
    /// Settings that are no numbers, or where something is: a single bit of any of them makes another word.
    Word(u32),
    /// There is no more.
    End,
}

macro_rules! constants {
    ($scalar:ty, $number:ident => $words:expr) => {
        impl Part<'_, $scalar> {
            /// Of a constant: the checksum so far with this part taken through it; `None` if there is no more.
            pub(crate) const fn after(&self, mut remainder: u32) -> Option<u32> {
                match self {
                    Self::Numbers(numbers) => {
                        let mut place = 0;
                        while place < numbers.len() {
                            let $number = numbers[place].to_bits();
                            let (words, mut word) = ($words, 0);
                            while word < words.len() {
                                remainder = after_word(remainder, words[word]);
                                word += 1;
                            }
                            place += 1;
                        }
                        Some(remainder)
                    }
                    Self::Word(word) => Some(after_word(remainder, *word)),
                    Self::End => None,
                }
            }
        }
    };
}
constants!(f32, bits => [bits]);
constants!(f64, bits => [bits as u32, (bits >> 32) as u32]);

/// The checksum of constants: `$part` makes a [`Part`] of the name of its place.
macro_rules! checksum_of {
    ($place:ident => $part:expr) => {{
        let (mut remainder, mut $place) = ($crate::integrity::FIRST, 0_usize);
        while let Some(after) = $part.after(remainder) {
            remainder = after;
            $place += 1;
        }
        !remainder
    }};
}
pub(crate) use checksum_of;
