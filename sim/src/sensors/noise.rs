//! Seeded random numbers: an independent ChaCha8 stream for each robot and sensor, so that adding a
//! robot or a sensor does not change the noise of the others.

use chacha20::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;

/// Purpose of a stream of random numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    EncoderPhase = 1,
    Camera = 2,
    Imu = 3,
}

/// A stream of random numbers.
#[derive(Debug)]
pub(crate) struct Noise(ChaCha8Rng);

impl Noise {
    /// The stream for one purpose of the robot named `robot`.
    pub(crate) fn new(seed: u64, robot: &str, purpose: Purpose) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(hash(robot).wrapping_add(purpose as u64));
        Self(generator)
    }

    /// A normally distributed number of mean 0 and standard deviation `deviation`.
    pub(crate) fn normal(&mut self, deviation: f64) -> f64 {
        let unit: f64 = self.0.sample(StandardNormal);
        unit * deviation
    }

    /// A uniformly distributed number in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0.random()
    }
}

/// FNV-1a hash of a name, the same on every machine.
fn hash(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
