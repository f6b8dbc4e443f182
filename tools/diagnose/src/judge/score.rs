//! Sums of the errors of predictions.

use crate::data::track::{CHANNEL_NAMES, CHANNELS};

/// How many quantities are scored: the channels, then distance and heading.
pub(crate) const QUANTITIES: usize = CHANNELS + 2;
/// The first channel of the pose, and the turn rate of the gyro.
pub(crate) const POSE: usize = 2;
pub(crate) const GYRO: usize = 9;
/// Distance from where the robot was seen (m), and error of the heading (rad).
pub(crate) const PLACE: usize = CHANNELS;
pub(crate) const HEADING: usize = CHANNELS + 1;

/// An error of a way up to so many times that of the sensor is noise of the sensor.
const SEEN: f64 = 2.0;
/// Deviations below which a normal number stays with 95 % confidence.
const CONFIDENT: f64 = 1.645;

/// What a quantity is called.
pub(crate) fn name(quantity: usize) -> &'static str {
    match quantity {
        PLACE => "position",
        HEADING => "heading",
        channel => CHANNEL_NAMES[channel],
    }
}

/// Sums over the rows of one quantity.
#[derive(Debug, Clone, Copy, Default)]
struct QuantitySums {
    /// Square errors in the quantity's unit.
    squares: f64,
    /// The same in square standard deviations of the sensor.
    levels: f64,
    /// Variance of the sensor.
    sensor: f64,
    /// Variance that sensor and process noise together predict.
    expected: f64,
    rows: f64,
    windows: f64,
}

/// How far the wheels of a robot go, and how far off they are predicted: sums of squares over the poses (m²), or over
/// the rows of the wheels (rad²) where there is none.
#[derive(Debug, Clone, Copy, Default)]
struct WheelTravel {
    off_m2: f64,
    gone_m2: f64,
    /// What noise of the sensor alone would be off.
    sensor_m2: f64,
    rows: f64,
}

/// What one or several windows score.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Score {
    sums: [QuantitySums; QUANTITIES],
    way: WheelTravel,
    /// How far the start of a window is from what it was fitted to (standard deviations).
    start: f64,
}

impl Score {
    /// Adds a row: square error, variance of the sensor, and the variance that noise predicts, all in the
    /// square of the quantity's unit.
    pub(crate) fn add(&mut self, quantity: usize, square: f64, sensor: f64, expected: f64) {
        if !square.is_finite() {
            return;
        }
        let sum = &mut self.sums[quantity];
        if sum.rows == 0.0 {
            sum.windows = 1.0;
        }
        sum.squares += square;
        sum.levels += square / sensor;
        sum.sensor += sensor;
        sum.expected += expected.max(sensor);
        sum.rows += 1.0;
    }

    /// Sets how far the start is from what it was fitted to (standard deviations).
    pub(crate) fn begin(&mut self, level: f64) {
        self.start = level;
    }

    /// How far the start of the window is from what it was fitted to (standard deviations).
    pub(super) fn start(&self) -> f64 {
        self.start
    }

    /// Adds how far the robot went since the window began, how far off that is predicted, and how far off noise of
    /// the sensor would be: square of the distance (m²) and of the turn (rad²; NaN where not measured) each.
    pub(crate) fn follow(&mut self, half_track_m: f64, squares: [[f64; 2]; 3]) {
        let [gone, off, sensor] = squares.map(|[place_m2, turn_rad2]| {
            let turn_rad2 = if turn_rad2.is_finite() {
                turn_rad2
            } else {
                0.0
            };
            place_m2 + half_track_m * half_track_m * turn_rad2
        });
        if off.is_finite() {
            self.way.gone_m2 += gone;
            self.way.off_m2 += off;
            self.way.sensor_m2 += sensor;
            self.way.rows += 1.0;
        }
    }

    /// The same of one wheel's angle or speed, where no pose was seen: squares of what it went, of what the prediction is
    /// off, and of the sensor.
    pub(crate) fn follow_wheel(&mut self, [gone, off, sensor]: [f64; 3]) {
        self.follow(0.0, [gone, off, sensor].map(|square| [square, 0.0]));
    }

    /// The share of the way of the wheels by which a prediction misses; `None` without poses, and where no more than
    /// noise of the sensor is seen.
    pub(crate) fn missed_share(&self) -> Option<f64> {
        let WheelTravel {
            off_m2,
            gone_m2,
            sensor_m2,
            ..
        } = self.way;
        (off_m2 > SEEN * SEEN * sensor_m2).then(|| (off_m2 / gone_m2).sqrt())
    }

    /// Takes back that so many rows of a sensor with this variance count: they repeat others.
    pub(crate) fn repeat(&mut self, quantity: usize, rows: f64, sensor: f64) {
        let sum = &mut self.sums[quantity];
        sum.rows -= rows;
        sum.sensor -= rows * sensor;
        sum.expected -= rows * sensor;
    }

    /// Both together.
    pub(crate) fn and(mut self, other: &Self) -> Self {
        for (own, other) in self.sums.iter_mut().zip(&other.sums) {
            own.squares += other.squares;
            own.levels += other.levels;
            own.sensor += other.sensor;
            own.expected += other.expected;
            own.rows += other.rows;
            own.windows += other.windows;
        }
        self.way.gone_m2 += other.way.gone_m2;
        self.way.off_m2 += other.way.off_m2;
        self.way.sensor_m2 += other.way.sensor_m2;
        self.way.rows += other.way.rows;
        self
    }

    /// All together.
    pub(crate) fn of_all<'a>(all: impl IntoIterator<Item = &'a Self>) -> Self {
        all.into_iter().fold(Self::default(), Self::and)
    }

    /// Whether anything was measured of a quantity.
    pub(crate) fn has(&self, quantity: usize) -> bool {
        self.sums[quantity].rows > 0.0
    }

    /// Sum of square errors.
    pub(crate) fn squares(&self, quantity: usize) -> f64 {
        self.sums[quantity].squares
    }

    /// Mean square error; `None` where nothing was measured.
    pub(crate) fn mean_square(&self, quantity: usize) -> Option<f64> {
        self.mean(quantity, self.sums[quantity].squares)
    }

    /// Mean variance of the sensor.
    pub(crate) fn sensor(&self, quantity: usize) -> Option<f64> {
        self.mean(quantity, self.sums[quantity].sensor)
    }

    /// Mean square error below which noise stays with 95 % confidence: errors within a window go together, and the
    /// mean over n independent windows has a deviation of √(2/n).
    pub(crate) fn expected(&self, quantity: usize) -> Option<f64> {
        let sum = &self.sums[quantity];
        let chance = 1.0 + CONFIDENT * (2.0 / sum.windows.max(1.0)).sqrt();
        Some(self.mean(quantity, sum.expected)? * chance)
    }

    /// Root mean square over several channels in standard deviations of their sensors.
    pub(crate) fn level(&self, quantities: &[usize]) -> Option<f64> {
        let own = || quantities.iter().map(|quantity| &self.sums[*quantity]);
        let rows: f64 = own().map(|sum| sum.rows).sum();
        let levels: f64 = own().map(|sum| sum.levels).sum();
        (rows > 0.0).then(|| (levels / rows).sqrt())
    }

    /// Adds the mean variance that process noise adds, where it is known over all windows alone.
    pub(crate) fn expect(&mut self, quantity: usize, process: f64) {
        let sum = &mut self.sums[quantity];
        sum.expected += sum.rows * process;
    }

    /// Sets that the error of another recording is expected, as it is or in proportion to a longer way; if something
    /// changed since, at least that.
    pub(crate) fn expect_as(&mut self, other: &Self, has_changed: bool) {
        let [own_m2, other_m2] = [self, other].map(|score| score.way.gone_m2 / score.way.rows);
        let longer = Some(own_m2 / other_m2).filter(|ratio| *ratio > 1.0);
        for (sum, other) in self.sums.iter_mut().zip(&other.sums) {
            if other.rows > 0.0 {
                let square = other.squares / other.rows * longer.unwrap_or(1.0);
                let least = if has_changed {
                    sum.expected
                } else {
                    sum.sensor
                };
                sum.expected = least.max(sum.rows * square);
            }
        }
    }

    fn mean(&self, quantity: usize, sum: f64) -> Option<f64> {
        let rows = self.sums[quantity].rows;
        (rows > 0.0).then(|| sum / rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_recording_misses_is_expected_in_proportion_to_the_way() {
        let of = |error_m: f64, way_m: f64| {
            let mut score = Score::default();
            let [off, gone] = [error_m, way_m].map(|own| own * own);
            score.add(PLACE, off, 1e-6, 1.0);
            score.follow(0.1, [[gone, 0.0], [off, 0.0], [1e-6, 0.0]]);
            score
        };
        let mut score = of(0.3, 4.0);
        // one window: 1 + 1.645 √2 times as much is chance
        let expected =
            |score: &Score| score.expected(PLACE).unwrap() / (1.0 + 1.645 * 2.0_f64.sqrt());
        score.expect_as(&of(0.1, 2.0), false);
        assert!((expected(&score) - 0.04).abs() < 1e-9);
        score.expect_as(&of(0.1, 8.0), false);
        assert!((expected(&score) - 0.01).abs() < 1e-9);
        // a change may bring noise of its own
        score.expect_as(&of(0.05, 8.0), true);
        assert!((expected(&score) - 0.01).abs() < 1e-9);
    }

    #[test]
    fn means_are_over_the_rows_that_were_measured() {
        let mut score = Score::default();
        score.add(PLACE, 4.0, 1.0, 2.0);
        score.add(PLACE, f64::NAN, 1.0, 2.0);
        score.add(PLACE, 0.0, 1.0, 0.5);
        assert_eq!(score.mean_square(PLACE), Some(2.0));
        // noise is at least that of the sensor, and this is one window
        let expected = score.expected(PLACE).unwrap();
        assert!((expected - 1.5 * (1.0 + 1.645 * 2.0_f64.sqrt())).abs() < 1e-12);
        assert_eq!(score.mean_square(HEADING), None);
        assert_eq!(score.level(&[PLACE]), Some(2.0_f64.sqrt()));
    }
}
