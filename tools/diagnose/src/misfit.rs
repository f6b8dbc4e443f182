//! How far a simulation is from what was measured: sums of squares by channel, and how much each
//! residual says of the next.

use crate::track::CHANNELS;
use crate::window::Window;

/// Level (deviations) below which a residual counts as noise whatever it is: the differences of two
/// integrators, and the tails of a rounding.
pub(crate) const FLOOR: f64 = 1.0;

/// Sums of squares and counts of each channel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Misfit {
    pub(crate) squares: [f64; CHANNELS],
    pub(crate) counts: [f64; CHANNELS],
    /// Residuals that say as much as one independent one, at least 1.
    pub(crate) memory: [f64; CHANNELS],
}

impl Misfit {
    /// The misfit of `residuals`, window by window.
    pub(crate) fn new(windows: &[Window], residuals: &[Vec<f64>]) -> Self {
        let mut misfit = Self::default();
        for (window, residuals) in windows.iter().zip(residuals) {
            for (channel, residual) in window.channels.iter().zip(residuals) {
                if residual.is_finite() {
                    misfit.squares[usize::from(*channel)] += residual * residual;
                    misfit.counts[usize::from(*channel)] += 1.0;
                }
            }
        }
        misfit.memory = [1.0; CHANNELS];
        misfit
    }

    /// Looks up how much each residual says of the next.
    pub(crate) fn remember(&mut self, windows: &[Window], residuals: &[&[f64]]) {
        for channel in 0..CHANNELS {
            self.memory[channel] = memory(windows, residuals, channel as u8);
        }
    }

    /// Both together.
    pub(crate) fn and(&self, other: &Self) -> Self {
        let mut both = *self;
        for channel in 0..CHANNELS {
            both.squares[channel] += other.squares[channel];
            both.counts[channel] += other.counts[channel];
            both.memory[channel] = both.memory[channel].max(other.memory[channel]);
        }
        both
    }

    /// Mean square of a channel, in square deviations.
    pub(crate) fn mean_square(&self, channel: usize) -> f64 {
        self.squares[channel] / self.counts[channel].max(1.0)
    }

    /// The same where it is above the floor.
    fn floored(&self, channel: usize) -> f64 {
        self.mean_square(channel).max(FLOOR * FLOOR)
    }

    /// −2 ln L of the channels' residuals, each channel at its own level.
    pub(crate) fn deviance(&self) -> f64 {
        let own = (0..CHANNELS).map(|c| self.counts[c] * self.floored(c).ln());
        own.sum()
    }

    /// How much less `self` misses than `before`, in −2 ln L, counting residuals that repeat each
    /// other once.
    pub(crate) fn gain_over(&self, before: &Self) -> f64 {
        let own = (0..CHANNELS).filter(|c| self.counts[*c] > 0.0).map(|c| {
            self.counts[c] / self.memory[c].max(1.0) * (before.floored(c) / self.floored(c)).ln()
        });
        own.sum()
    }

    /// How much wider than for white noise a deviation is: the root of the mean memory.
    pub(crate) fn excess(&self) -> f64 {
        let sum: f64 = (0..CHANNELS)
            .map(|c| self.counts[c] * self.memory[c].max(1.0))
            .sum();
        (sum / self.counts.iter().sum::<f64>().max(1.0))
            .sqrt()
            .max(1.0)
    }

    /// Weights of the channels in a least-squares fit.
    pub(crate) fn weights(&self) -> [f64; CHANNELS] {
        let mut weights = [0.0; CHANNELS];
        for (channel, weight) in weights.iter_mut().enumerate() {
            *weight = 1.0 / self.floored(channel);
        }
        weights
    }

    /// Root mean square of the worst channel, in deviations.
    pub(crate) fn worst(&self) -> (usize, f64) {
        let level = |c: usize| self.mean_square(c).sqrt();
        let channels = (0..CHANNELS).filter(|c| self.counts[*c] > 0.0);
        let worst = channels.max_by(|a, b| level(*a).total_cmp(&level(*b)));
        worst.map_or((0, 0.0), |channel| (channel, level(channel)))
    }
}

/// 1 + 2 Σ of the autocorrelation of a channel's residuals up to where it is gone: the statistical
/// inefficiency of a correlated series.
fn memory(windows: &[Window], residuals: &[&[f64]], channel: u8) -> f64 {
    const LONGEST: usize = 120;
    let series: Vec<Vec<f64>> = windows
        .iter()
        .zip(residuals)
        .map(|(window, residuals)| {
            let own = window.channels.iter().zip(*residuals);
            own.filter(|(c, r)| **c == channel && r.is_finite())
                .map(|(_, r)| *r)
                .collect()
        })
        .collect();
    let covariance = |lag: usize| -> f64 {
        let sums = series.iter().map(|s| {
            s.iter()
                .zip(s.iter().skip(lag))
                .map(|(a, b)| a * b)
                .sum::<f64>()
        });
        sums.sum()
    };
    let own = covariance(0);
    if own <= 0.0 {
        return 1.0;
    }
    let mut sum = 1.0;
    for lag in 1..LONGEST {
        let correlation = covariance(lag) / own;
        if correlation < 0.05 {
            break;
        }
        sum += 2.0 * correlation;
    }
    sum
}
