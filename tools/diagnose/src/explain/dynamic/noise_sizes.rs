//! Sizes and correlation times of the disturbances, by maximum likelihood: a pattern search in their
//! logarithms, each evaluation one linear filter.
//!
//! A size and its time trade along a ridge (time up, size down) on which a search by coordinates
//! sticks, so that the ridge is one of the directions. A size may fall to its floor: the difference
//! between two integrators of one model.

use crate::filter::dynamic::Noise;

/// Largest sizes, in the units of [`Noise`].
const LARGEST: [f64; 5] = [30.0, 1.0, 1.0, 3.0, 1.0];
/// Shortest and longest correlation time (s).
const TIMES_S: [f64; 2] = [0.01, 10.0];
/// Logs of sizes and times: five and three.
const LENGTH: usize = 8;
type Logs = [f64; LENGTH];

/// How far a search goes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// First step, in logarithms.
    pub(crate) step: f64,
    /// Most evaluations.
    pub(crate) most: usize,
    /// Whether sizes at their floor are tried at others.
    pub(crate) wakes: bool,
}

pub(crate) const QUICK: Effort = Effort {
    step: 0.3,
    most: 60,
    wakes: false,
};
pub(crate) const THOROUGH: Effort = Effort {
    step: 0.9,
    most: 150,
    wakes: true,
};

/// Steps by which a size at its floor is raised (logarithms).
const RAISED: [f64; 3] = [1.5, 3.5, 5.5];
/// Gains in −2 ln L that count: of a step, of a size that wakes, and a loss for a size that falls asleep.
const GAIN: f64 = 0.05;
const WAKING_GAIN: f64 = 0.3;
const RESTING_LOSS: f64 = 0.1;
/// A round that gains less is followed by shorter steps; the search ends below the shortest.
const ROUND_GAIN: f64 = 1.0;
const SHORTER: f64 = 0.45;
const SHORTEST: f64 = 0.07;

/// A search over the noise of one model.
pub(crate) struct Search<'a> {
    pub(crate) floor: [f64; 5],
    pub(crate) of_wheels: bool,
    pub(crate) has_pose: bool,
    /// −2 ln L of a noise.
    pub(crate) deviance: &'a dyn Fn(&Noise) -> f64,
}

impl Search<'_> {
    fn noise(&self, logs: &Logs) -> Noise {
        Noise {
            size: std::array::from_fn(|i| logs[i].exp()),
            time_s: std::array::from_fn(|i| logs[5 + i].exp()),
            of_wheels: self.of_wheels,
        }
    }

    fn held(&self, mut logs: Logs) -> Logs {
        for (i, own) in logs.iter_mut().enumerate() {
            let [low, high] = if i < 5 {
                [self.floor[i], LARGEST[i]]
            } else {
                TIMES_S
            };
            *own = own.clamp(low.ln(), high.ln());
        }
        if self.of_wheels {
            logs[3] = logs[2];
        }
        logs
    }

    /// Sizes that are searched, each with its time.
    fn pairs(&self) -> &'static [(usize, usize)] {
        match (self.of_wheels, self.has_pose) {
            (false, true) => &[(0, 5), (1, 6), (2, 7), (3, 7), (4, 7)],
            (true, true) => &[(0, 5), (1, 6), (2, 7), (4, 7)],
            (false, false) => &[(0, 5), (1, 6)],
            (true, false) => &[(0, 5), (1, 6), (2, 7)],
        }
    }

    /// Improves `from`. Returns the noise and its −2 ln L.
    pub(crate) fn run(&self, from: &Noise, effort: Effort) -> (Noise, f64) {
        let mut logs = [0.0; LENGTH];
        for (own, size) in logs.iter_mut().zip(from.size) {
            *own = size.max(1e-12).ln();
        }
        for (own, time_s) in logs[5..].iter_mut().zip(from.time_s) {
            *own = time_s.ln();
        }
        let logs = self.held(logs);
        let mut at = At {
            logs,
            deviance: (self.deviance)(&self.noise(&logs)),
            evaluations: 0,
        };
        let mut step = effort.step;
        while step > SHORTEST && at.evaluations < effort.most {
            let before = at.deviance;
            for &(size, time) in self.pairs() {
                self.improve(&mut at, size, time, step, effort);
            }
            if before - at.deviance < ROUND_GAIN {
                step *= SHORTER;
            }
        }
        (self.noise(&at.logs), at.deviance)
    }

    fn improve(&self, at: &mut At, size: usize, time: usize, step: f64, effort: Effort) {
        let floor = self.floor[size].ln();
        if at.logs[size] <= floor + 0.02 {
            if effort.wakes && step > 0.25 {
                for up in RAISED {
                    let mut logs = at.logs;
                    logs[size] += up;
                    self.take(at, logs, WAKING_GAIN);
                }
            }
            return;
        }
        let mut rest = at.logs;
        rest[size] = floor;
        if self.take(at, rest, -RESTING_LOSS) {
            return;
        }
        let unit = |i: usize, by: f64| {
            let mut direction = [0.0; LENGTH];
            direction[i] = by;
            direction
        };
        let mut ridge = unit(time, 1.0);
        ridge[size] = -0.5;
        for direction in [unit(size, 1.0), ridge, unit(time, 1.0)] {
            self.along(at, &direction, step, effort.most);
        }
    }

    /// Steps along a direction, ever longer, while that helps.
    fn along(&self, at: &mut At, direction: &Logs, step: f64, most: usize) {
        for sign in [-1.0, 1.0] {
            let mut length = step * sign;
            let mut moved = false;
            while at.evaluations < most {
                let logs = std::array::from_fn(|i| at.logs[i] + length * direction[i]);
                if !self.take(at, logs, GAIN) {
                    break;
                }
                moved = true;
                length *= 1.6;
            }
            if moved {
                return;
            }
        }
    }

    /// Goes to `logs` if that gains as much.
    fn take(&self, at: &mut At, logs: Logs, gain: f64) -> bool {
        let logs = self.held(logs);
        let change = logs.iter().zip(&at.logs).map(|(a, b)| (a - b).abs());
        if change.fold(0.0, f64::max) < 1e-6 {
            return false;
        }
        at.evaluations += 1;
        let deviance = (self.deviance)(&self.noise(&logs));
        let better = deviance < at.deviance - gain;
        if better {
            (at.logs, at.deviance) = (logs, deviance);
        }
        better
    }
}

struct At {
    logs: Logs,
    deviance: f64,
    evaluations: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_search_follows_a_ridge_and_lets_what_is_idle_rest() {
        // surge known by its size times the root of its time, and weakly by itself; all else is idle
        let deviance = |noise: &Noise| {
            let along = (noise.size[0] * noise.time_s[0].sqrt()).ln() - (0.2_f64 * 0.5).ln();
            let across = noise.time_s[0].ln() - 0.25_f64.ln();
            let idle: f64 = noise.size[1..].iter().map(|size| size * size).sum();
            1e4 * along * along + 10.0 * across * across + 1e3 * idle
        };
        let search = Search {
            floor: [1e-4; 5],
            of_wheels: false,
            has_pose: true,
            deviance: &deviance,
        };
        let from = Noise {
            size: [0.01, 0.01, 0.01, 0.01, 0.01],
            time_s: [3.0; 3],
            of_wheels: false,
        };
        let (found, value) = search.run(&from, THOROUGH);
        // the last step, 0.03, leaves 1e4 (0.03 / 2)² and less
        assert!(value < 5.0, "{value} {found:?}");
        assert!((found.size[0] / 0.2).ln().abs() < 0.3, "{found:?}");
        assert!(
            found.size[1..].iter().all(|size| *size < 1.1e-4),
            "{found:?}"
        );
    }
}
