//! How far a simulation is from what was measured: sums of squares by channel, and how much each
//! residual says of the next.

use crate::windows::track::CHANNELS;
use crate::windows::window::Window;

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
            for rest in &window.rests {
                let seen = rest.iter().filter(|i| residuals[**i].is_finite());
                let more = seen.count().saturating_sub(1);
                misfit.counts[usize::from(window.channels[rest[0]])] -= more as f64;
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

    /// How much less `self` misses than `before` in each channel, in −2 ln L, counting residuals that
    /// repeat each other once.
    pub(crate) fn gains_over(&self, before: &Self) -> [f64; CHANNELS] {
        std::array::from_fn(|c| match self.counts[c] > 0.0 {
            true => {
                let free = self.counts[c] / self.memory[c].max(1.0);
                free * (before.floored(c) / self.floored(c)).ln()
            }
            false => 0.0,
        })
    }

    /// How much less `self` misses than `before`, in all channels.
    pub(crate) fn gain_over(&self, before: &Self) -> f64 {
        self.gains_over(before).iter().sum()
    }

    /// The same in those channels alone in which it is more than a `share` of what `before` gained over
    /// `first`.
    pub(crate) fn clear_gain_over(&self, before: &Self, first: &Self, share: f64) -> f64 {
        let gains = self.gains_over(before).into_iter();
        let so_far = before.gains_over(first);
        let clear = gains
            .zip(so_far)
            .filter(|(gain, so_far)| *gain > share * so_far);
        clear.map(|(gain, _)| gain).sum()
    }

    /// What noise alone would leave.
    pub(crate) fn perfect(&self) -> Self {
        Self {
            squares: [0.0; CHANNELS],
            memory: [1.0; CHANNELS],
            ..*self
        }
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
    inefficiency(&series)
}

/// 1 + 2 Σ of the autocorrelation over all series up to where it is gone.
pub(crate) fn inefficiency(series: &[Vec<f64>]) -> f64 {
    const LONGEST: usize = 120;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::windows::fixture;

    const ROWS: usize = 4000;
    const WINDOWS: usize = 5;

    fn window() -> Window {
        fixture::window(vec![0; ROWS])
    }

    /// Windows of a series of which each value keeps `share` of the one before and adds what is new.
    fn remembering(share: f64) -> f64 {
        let mut new = fixture::numbers(1);
        let mut value = 0.0;
        let mut next = || {
            value = share * value + new();
            value
        };
        let series: Vec<Vec<f64>> = (0..WINDOWS)
            .map(|_| (0..ROWS).map(|_| next()).collect())
            .collect();
        let series: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
        memory(&vec![window(); WINDOWS], &series, 0)
    }

    #[test]
    fn a_series_that_keeps_a_share_says_so_much_less() {
        // 20,000 values leave a correlation uncertain by 0.7 % of one; what lies below a correlation
        // of 0.05 is left out: 5 % of the sum at most for these
        for share in [0.0_f64, 0.5, 0.8, 0.9] {
            let wanted = (1.0 + share) / (1.0 - share);
            let found = remembering(share);
            assert!((found / wanted - 1.0).abs() < 0.15, "{found} for {wanted}");
        }
    }

    #[test]
    fn what_swings_to_and_fro_has_no_memory() {
        assert_eq!(remembering(-0.5), 1.0);
    }

    fn of(mean_square: f64, count: f64, memory: f64) -> Misfit {
        let mut misfit = Misfit {
            memory: [1.0; CHANNELS],
            ..Misfit::default()
        };
        misfit.squares[2] = mean_square * count;
        misfit.counts[2] = count;
        misfit.memory[2] = memory;
        misfit
    }

    #[test]
    fn a_gain_counts_what_repeats_itself_once() {
        let before = of(16.0, 600.0, 1.0);
        let gain = of(4.0, 600.0, 1.0).gain_over(&before);
        assert!((gain - 600.0 * 4_f64.ln()).abs() < 1e-9);
        let gain = of(4.0, 600.0, 3.0).gain_over(&before);
        assert!((gain - 200.0 * 4_f64.ln()).abs() < 1e-9);
    }

    /// Wheels that an effect brought from 10⁶ to 4 of a mean square, and a camera that it left at 4.
    #[test]
    fn what_is_slight_beside_what_came_before_counts_in_other_channels_alone() {
        let both = |wheels: f64, camera: f64| {
            let mut both = of(camera, 600.0, 1.0);
            (both.squares[0], both.counts[0]) = (wheels * 600.0, 600.0);
            both
        };
        let (first, before) = (both(1e6, 4.0), both(4.0, 4.0));
        let gain = 600.0 * 4_f64.ln();
        let of_wheels = both(1.0, 4.0);
        assert!((of_wheels.gain_over(&before) - gain).abs() < 1e-9);
        assert_eq!(of_wheels.clear_gain_over(&before, &first, 0.2), 0.0);
        let of_both = both(1.0, 1.0);
        assert!((of_both.clear_gain_over(&before, &first, 0.2) - gain).abs() < 1e-9);
        let left = before.perfect().clear_gain_over(&before, &first, 0.1);
        assert!((left - 2.0 * gain).abs() < 1e-9);
    }

    #[test]
    fn below_the_noise_is_nothing_to_gain() {
        let gain = of(0.01, 600.0, 1.0).gain_over(&of(0.9, 600.0, 1.0));
        assert_eq!(gain, 0.0);
        assert_eq!(of(0.5, 600.0, 1.0).deviance(), 0.0);
    }

    #[test]
    fn a_deviation_widens_by_the_root_of_the_mean_memory() {
        assert!((of(1.0, 600.0, 9.0).excess() - 3.0).abs() < 1e-12);
        let both = of(1.0, 600.0, 9.0).and(&of(3.0, 200.0, 1.0));
        assert!((both.mean_square(2) - 1.5).abs() < 1e-12);
        assert_eq!(both.memory[2], 9.0);
    }

    #[test]
    fn what_was_not_measured_counts_in_no_channel() {
        let mut residuals = vec![2.0; ROWS];
        residuals[..ROWS / 2].fill(f64::NAN);
        let misfit = Misfit::new(&[window()], &[residuals]);
        assert_eq!(misfit.counts[0], ROWS as f64 / 2.0);
        assert_eq!(misfit.worst(), (0, 2.0));
    }
}
