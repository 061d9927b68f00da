//! Time that something took, over and over.

/// Ticks of a clock, of something that is done once a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Time {
    /// How often it was done.
    pub cycles: u32,
    /// Of all cycles together.
    pub total: u64,
    /// Of the longest one.
    pub longest: u32,
}

impl Time {
    pub(crate) fn add(&mut self, ticks: u32) {
        self.cycles += 1;
        self.total += u64::from(ticks);
        self.longest = self.longest.max(ticks);
    }
}
