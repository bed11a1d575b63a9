//! Seeded random numbers for the tests of this stage.

/// xorshift64.
pub(super) struct Random(pub(super) u64);

impl Random {
    /// From 0 to below `bound`.
    pub(super) fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % bound
    }
}
