//! Random numbers of the tests.

/// A xorshift pseudo-random generator.
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    /// Less than `limit`.
    pub(crate) fn below(&mut self, limit: i64) -> i64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 1).cast_signed() % limit
    }
}
