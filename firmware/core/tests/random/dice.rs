//! Random numbers that are the same on every machine.

/// Uniform random numbers (xorshift).
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    /// In 0..1.
    pub(crate) fn roll(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    #[allow(dead_code)]
    /// A delay by `probabilities`, `None` for loss.
    #[allow(dead_code)]
    pub(crate) fn delay(&mut self, probabilities: &[f64]) -> Option<usize> {
        let mut left = self.roll();
        probabilities.iter().position(|probability| {
            left -= probability;
            left < 0.0
        })
    }
}
