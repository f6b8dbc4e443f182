//! Process noise of a robot that is told speeds: it moves and turns by more or less than its wheels say.

use crate::maker::random::RandomStream;

/// Period in which the noise changes (s).
pub(crate) const WANDER_PERIOD_S: f64 = 0.005;

/// How the noise varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WanderKind {
    /// Gaussian, Ornstein-Uhlenbeck.
    Steady,
    /// The same, in proportion to the speed.
    Speed,
    /// Rare pulses.
    Gusts,
}

/// Noise of one kind.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Wander {
    pub(crate) kind: WanderKind,
    /// Standard deviation along the body (m/s) and about the vertical axis (rad/s) at the largest speed; of gusts:
    /// their typical size.
    pub(crate) size: [f64; 2],
    /// Correlation time; of gusts: mean duration (s).
    pub(crate) time_s: f64,
    /// Mean time between gusts (s).
    pub(crate) between_s: f64,
}

/// A realisation.
#[derive(Debug)]
pub(crate) struct Wandering<'a> {
    noise: &'a Wander,
    random: RandomStream,
    unit: [f64; 2],
    /// Rest of a gust (s).
    left_s: f64,
}

impl<'a> Wandering<'a> {
    /// A realisation.
    pub(crate) fn new(noise: &'a Wander, mut random: RandomStream) -> Self {
        let unit = if noise.kind == WanderKind::Gusts {
            [0.0; 2]
        } else {
            [random.normal(1.0), random.normal(1.0)]
        };
        Self {
            noise,
            random,
            unit,
            left_s: 0.0,
        }
    }

    /// Speeds [m/s, rad/s] of the next period; `share` is the speed over the largest.
    pub(crate) fn step(&mut self, share: f64) -> [f64; 2] {
        let Wander {
            kind,
            time_s,
            between_s,
            size,
        } = *self.noise;
        if kind == WanderKind::Gusts {
            self.gust(time_s, between_s);
        } else {
            let decay = (-WANDER_PERIOD_S / time_s).exp();
            let fresh = (1.0 - decay * decay).sqrt();
            self.unit = self
                .unit
                .map(|unit| decay * unit + self.random.normal(fresh));
        }
        let factor = if kind == WanderKind::Speed {
            share
        } else {
            1.0
        };
        [0, 1].map(|i| size[i] * self.unit[i] * factor)
    }

    fn gust(&mut self, time_s: f64, between_s: f64) {
        self.left_s -= WANDER_PERIOD_S;
        if self.left_s > 0.0 {
            return;
        }
        self.unit = [0.0; 2];
        if self.random.bernoulli(WANDER_PERIOD_S / between_s) {
            self.left_s = time_s * self.random.uniform(0.5, 1.5);
            self.unit = [0, 1].map(|_| self.random.sign() * self.random.log_uniform(0.5, 2.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(kind: WanderKind, share: f64) -> Vec<[f64; 2]> {
        let noise = Wander {
            kind,
            size: [0.1, 0.2],
            time_s: 0.1,
            between_s: 10.0,
        };
        let mut process = Wandering::new(&noise, RandomStream::new(1, 0));
        (0..100_000).map(|_| process.step(share)).collect()
    }

    fn deviation(values: &[[f64; 2]], at: usize) -> f64 {
        let sum: f64 = values.iter().map(|value| value[at] * value[at]).sum();
        (sum / values.len() as f64).sqrt()
    }

    #[test]
    fn steady_noise_has_its_size_and_the_other_grows_with_speed() {
        let steady = drawn(WanderKind::Steady, 0.3);
        // 2500 independent values: 1.4 % of deviation, four are allowed
        assert!((deviation(&steady, 0) / 0.1 - 1.0).abs() < 0.06);
        assert!((deviation(&steady, 1) / 0.2 - 1.0).abs() < 0.06);
        let slower = drawn(WanderKind::Speed, 0.3);
        assert!((deviation(&slower, 0) / 0.03 - 1.0).abs() < 0.06);
    }

    #[test]
    fn gusts_are_rare() {
        let gusts = drawn(WanderKind::Gusts, 1.0);
        let acts = gusts.iter().filter(|value| value[0] != 0.0).count();
        // one in 10 s of 0.1 s: 1 %; of 50 in 500 s four deviations are allowed
        assert!((200..1800).contains(&acts), "{acts}");
    }
}
