//! Seeded chance: one stream for each purpose, so that one draw more changes nothing else.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// A stream of chance.
#[derive(Debug, Clone)]
pub(crate) struct Chance(ChaCha8Rng);

impl Chance {
    /// The stream `purpose` of a seed.
    pub(crate) fn new(seed: u64, purpose: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(purpose);
        Self(generator)
    }

    /// A number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0.random()
    }

    /// A number in [from, to).
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// The same, evenly in proportion.
    pub(crate) fn in_proportion(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.unit())
    }

    /// A number of mean 0 and this deviation.
    pub(crate) fn normal(&mut self, deviation: f64) -> f64 {
        let unit: f64 = self.0.sample(StandardNormal);
        unit * deviation
    }

    /// Whether something of this probability happens.
    pub(crate) fn happens(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// −1 or 1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.happens(0.5) { -1.0 } else { 1.0 }
    }

    /// One of these.
    pub(crate) fn one<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        let at = (self.unit() * of.len() as f64) as usize;
        &of[at.min(of.len() - 1)]
    }

    /// Sixteen bytes as hexadecimal digits.
    pub(crate) fn nonce(&mut self) -> String {
        (0..2)
            .map(|_| format!("{:016x}", self.0.random::<u64>()))
            .collect()
    }
}
