//! Seeded random numbers for tests.

/// xorshift64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Returns a number from 0 to below `bound`.
    pub(crate) fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % bound
    }
}
