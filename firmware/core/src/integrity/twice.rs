//! A value with its copy.

use core::hint::black_box;

/// A value that is kept twice, and given out only while both copies are equal.
///
/// The compiler must not know that they are: it would keep one, or leave the comparison out.
///
/// ```
/// use slqg::integrity::Twice;
///
/// let mut limit = Twice::new(3_u32);
/// assert_eq!(limit.get(), Some(&3));
/// limit.set(4);
/// assert_eq!(limit.get(), Some(&4));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Twice<V> {
    value: V,
    copy: V,
}

impl<V: Copy + PartialEq> Twice<V> {
    /// Both copies of `value`.
    pub const fn new(value: V) -> Self {
        Self { value, copy: value }
    }

    /// Replaces both copies.
    #[inline(always)]
    pub fn set(&mut self, value: V) {
        *self = Self::new(value);
    }

    /// The value; `None` if the copies differ, one of them having changed by itself, or if it is not equal to itself.
    #[inline(always)]
    pub fn get(&self) -> Option<&V> {
        let Self { value, copy } = black_box(self);
        (value == copy).then_some(value)
    }

    /// The value, or its copy if they differ: for what is told of it, not for what is done with it.
    pub(crate) fn either(&self) -> &V {
        &self.value
    }

    /// With one copy changed, for tests of what comes of it.
    #[cfg(test)]
    pub(crate) fn damage(&mut self, of_copy: bool, change: impl FnOnce(&mut V)) {
        change(if of_copy { &mut self.copy } else { &mut self.value });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_of_either_copy_is_missed_by_nobody() {
        for (of_copy, bit) in (0..64).flat_map(|bit| [(false, bit), (true, bit)]) {
            let mut kept = Twice::new(0x0123_4567_89ab_cdef_u64);
            kept.damage(of_copy, |value| *value ^= 1 << bit);
            assert_eq!(kept.get(), None);
            kept.set(7);
            assert_eq!(kept.get(), Some(&7));
        }
    }

    #[test]
    fn a_number_that_is_none_is_not_given_out() {
        assert_eq!(Twice::new(f32::NAN).get(), None);
    }
}
