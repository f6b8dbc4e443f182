//! How far a simulation is from what was measured: sums of squares by channel.

use crate::data::track::CHANNELS;
use crate::predict::window::Window;

/// Level (deviations) below which a residual counts as noise whatever it is: the differences of two
/// integrators, and the tails of a rounding.
const FLOOR: f64 = 1.0;

/// Sums of squares and counts of each channel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SumOfSquares {
    squares: [f64; CHANNELS],
    counts: [f64; CHANNELS],
}

impl SumOfSquares {
    /// The squares of the residuals of a window.
    pub(crate) fn new(window: &Window, residuals: &[f64]) -> Self {
        let mut sum = Self::default();
        for (channel, residual) in window.channels.iter().zip(residuals) {
            if residual.is_finite() {
                sum.squares[usize::from(*channel)] += residual * residual;
                sum.counts[usize::from(*channel)] += 1.0;
            }
        }
        for (channel, more) in window.repeated(residuals) {
            sum.counts[channel] -= more;
        }
        sum
    }

    /// Mean square of a channel, in square deviations.
    pub(crate) fn mean_square(&self, channel: usize) -> f64 {
        self.squares[channel] / self.counts[channel].max(1.0)
    }

    /// The mean square where it is above the floor.
    fn floored(&self, channel: usize) -> f64 {
        self.mean_square(channel).max(FLOOR * FLOOR)
    }

    /// −2 ln L of the channels' residuals, each channel at its own level.
    pub(crate) fn deviance(&self) -> f64 {
        let own = (0..CHANNELS).map(|c| self.counts[c] * self.floored(c).ln());
        own.sum()
    }

    /// Weights of the channels in a least-squares fit.
    pub(crate) fn weights(&self) -> [f64; CHANNELS] {
        std::array::from_fn(|channel| 1.0 / self.floored(channel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::fixture;

    /// 100 rows of the pose's x, each of this residual (deviations).
    fn of(residual: f64) -> SumOfSquares {
        SumOfSquares::new(&fixture::window(vec![2; 100]), &[residual; 100])
    }

    #[test]
    fn below_the_noise_is_nothing_to_gain() {
        assert_eq!(of(0.5).deviance(), 0.0);
        assert!((of(2.0).deviance() - 100.0 * 4_f64.ln()).abs() < 1e-9);
    }

    #[test]
    fn means_are_of_what_was_measured() {
        assert!((of(3.0).mean_square(2) - 9.0).abs() < 1e-12);
        assert_eq!(of(3.0).mean_square(3), 0.0);
        let missing = SumOfSquares::new(&fixture::window(vec![0; 3]), &[2.0, f64::NAN, 2.0]);
        assert!((missing.mean_square(0) - 4.0).abs() < 1e-12);
    }
}
