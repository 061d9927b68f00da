//! Numbers for tests: the same on every machine and in every run.

use slqg::Scalar;
use slqg::nalgebra::SVector;

/// splitmix64.
pub(crate) struct Draws(pub(crate) u64);

impl Draws {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `bound`.
    pub(crate) fn below(&mut self, bound: usize) -> usize {
        (self.bits() % bound as u64) as usize
    }

    /// Entries within -1 and 1.
    pub(crate) fn vector<T: Scalar, const D: usize>(&mut self) -> SVector<T, D> {
        SVector::from_fn(|_, _| T::nearest((self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0))
    }
}
