//! Seeded random numbers: one stream for each purpose, so that an additional draw in one does not change
//! the others.

use chacha20::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;

/// A stream of random numbers.
#[derive(Debug)]
pub(crate) struct RandomStream(ChaCha8Rng);

impl RandomStream {
    /// The stream `purpose` of a seed.
    pub(crate) fn new(seed: u64, purpose: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(purpose);
        Self(generator)
    }

    /// A uniform number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0.random()
    }

    /// A uniform number in [from, to).
    pub(crate) fn uniform(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// A log-uniform number in [from, to).
    pub(crate) fn log_uniform(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.unit())
    }

    /// A normal number with mean 0 and this standard deviation.
    pub(crate) fn normal(&mut self, deviation: f64) -> f64 {
        let unit: f64 = self.0.sample(StandardNormal);
        unit * deviation
    }

    /// True with this probability.
    pub(crate) fn bernoulli(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// −1 or 1 with equal probability.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.bernoulli(0.5) { -1.0 } else { 1.0 }
    }

    /// One of the items with equal probability.
    pub(crate) fn choose<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        let at = (self.unit() * of.len() as f64) as usize;
        &of[at.min(of.len() - 1)]
    }

    /// Sixteen random bytes as hexadecimal digits.
    pub(crate) fn nonce(&mut self) -> String {
        (0..2)
            .map(|_| format!("{:016x}", self.0.random::<u64>()))
            .collect()
    }
}
