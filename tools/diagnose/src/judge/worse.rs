//! Whether a set of findings predicts worse than the model that it replaces.

use super::score::{POSE, QUANTITIES, Score};

/// A root mean square error that grows by less is the same.
const SAME: f64 = 1.02;
/// Standard errors of the difference between windows up to which it may be chance.
const CHANCE: f64 = 2.0;
/// An error of so many times the one before, and of what noise explains, is no chance.
const MUCH: f64 = 2.0;
/// A prediction this near to the sensor's noise is as good as one can be.
const AT_NOISE: f64 = 1.2;

/// Quantities of which windows are predicted worse after than before, beyond the spread between the windows.
/// Both hold the same windows in the same order.
pub(super) fn worse(before: &[Score], after: &[Score]) -> Vec<usize> {
    // the pose is judged as position and heading: what it is along x or y says how the axes lie
    let of_pose = POSE..POSE + 3;
    let all = (0..QUANTITIES).filter(|quantity| !of_pose.contains(quantity));
    all.filter(|quantity| is_worse(before, after, *quantity))
        .collect()
}

fn is_worse(before: &[Score], after: &[Score], quantity: usize) -> bool {
    let [first, last] = [before, after].map(Score::of_all);
    let means = first
        .mean_square(quantity)
        .zip(last.mean_square(quantity))
        .zip(last.sensor(quantity));
    let Some(((before_square, after_square), sensor)) = means else {
        return false;
    };
    if after_square <= SAME * SAME * before_square || after_square < AT_NOISE * AT_NOISE * sensor {
        return false;
    }
    let seen = before.iter().zip(after);
    let differences: Vec<f64> = seen
        .filter(|(own, _)| own.has(quantity))
        .map(|(own, other)| other.squares(quantity) - own.squares(quantity))
        .collect();
    let count = differences.len() as f64;
    let sum: f64 = differences.iter().sum();
    let mean = sum / count;
    let spread: f64 = differences.iter().map(|d| (d - mean) * (d - mean)).sum();
    // standard error of a sum of independent windows; a single window has no spread
    let error = (spread * count / (count - 1.0).max(1.0)).sqrt();
    // where one window makes up the sum, the spread is as large as that
    let noise = last.expected(quantity).unwrap_or(f64::INFINITY);
    let is_far = after_square > (MUCH * MUCH) * before_square.max(noise);
    (count > 1.0 && sum > CHANCE * error) || is_far
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::score::{HEADING, PLACE};

    /// Windows of one row each with these errors of the heading, and an error of the place of 3 m.
    fn windows(errors: &[f64]) -> Vec<Score> {
        let one = |error: &f64| {
            let mut score = Score::default();
            score.add(HEADING, error * error, 0.01, 0.01);
            score.add(PLACE, 9.0, 0.01, 0.01);
            score
        };
        errors.iter().map(one).collect()
    }

    #[test]
    fn every_window_somewhat_worse_is_worse() {
        let [before, after] = [[1.0, 2.0, 1.0, 2.0], [1.5, 2.4, 1.5, 2.4]].map(|own| windows(&own));
        assert_eq!(worse(&before, &after), [HEADING]);
        assert!(worse(&after, &before).is_empty());
    }

    #[test]
    fn one_window_among_others_that_gain_is_chance() {
        let before = windows(&[1.0, 1.0, 1.0, 1.0]);
        let after = windows(&[0.9, 0.9, 0.9, 1.35]);
        assert!(worse(&before, &after).is_empty());
    }

    #[test]
    fn a_single_window_has_no_spread() {
        let before = windows(&[1.0]);
        assert!(worse(&before, &windows(&[1.2])).is_empty());
        assert_eq!(worse(&before, &windows(&[3.0])), [HEADING]);
    }

    #[test]
    fn one_window_that_is_lost_is_no_chance() {
        let before = windows(&[1.0, 1.0, 1.0, 1.0]);
        let after = windows(&[0.9, 0.9, 0.9, 300.0]);
        assert_eq!(worse(&before, &after), [HEADING]);
    }

    #[test]
    fn at_the_noise_of_the_sensor_nothing_is_worse() {
        let [before, after] = [[0.09; 4], [0.11; 4]].map(|own| windows(&own));
        assert!(worse(&before, &after).is_empty());
    }
}
