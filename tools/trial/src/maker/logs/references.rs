//! What references do: cameras, scan matchers, gyros.

use super::rows::{Quantity, Rows};
use super::stamps::within;
use crate::maker::random::RandomStream;

/// 0.2 to 3 % of the poses are far off: one row at a time, by 0.1 to 1 m.
pub(super) fn outliers(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let share = within([0.002, 0.03], size);
    let mut any = false;
    for row in &mut rows.rows {
        if random.bernoulli(share) {
            any = true;
            let distance_m = random.log_uniform(0.1, 1.0);
            shift(
                &mut row.values,
                distance_m,
                random.uniform(-0.5, 0.5),
                random,
            );
        }
    }
    any
}

/// Scan matching: errors of each row add up, 0.3 to 3 mm and 0.2 to 2 mrad for the root of a second.
pub(super) fn accumulate(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let root = rows.period_s.sqrt();
    let walk_m = root * within([3e-4, 3e-3], size);
    let walk_rad = root * within([2e-4, 2e-3], size);
    let mut error = [0.0; 3];
    for row in &mut rows.rows {
        for (i, deviation) in [walk_m, walk_m, walk_rad].into_iter().enumerate() {
            error[i] += random.normal(deviation);
            row.values[i] += error[i];
        }
    }
    true
}

/// The pose jumps by 0.1 to 0.5 m, once or twice, and stays there.
pub(super) fn jumps(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let all = rows.rows.len();
    for _ in 0..1 + usize::from(random.bernoulli(0.4)) {
        let from = (all as f64 * random.uniform(0.15, 0.85)) as usize;
        let mut jump = [0.0; 3];
        shift(
            &mut jump,
            within([0.1, 0.5], size),
            random.normal(0.03),
            random,
        );
        for row in &mut rows.rows[from..] {
            row.values = std::array::from_fn(|i| row.values[i] + jump[i]);
        }
    }
    all > 0
}

/// A gyro is off by 2 to 30 mrad/s.
pub(super) fn bias(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    if rows.quantity != Quantity::Gyro {
        return false;
    }
    let off = random.sign() * within([0.002, 0.03], size);
    rows.rows.iter_mut().for_each(|row| row.values[0] += off);
    true
}

/// Moves a pose in a random direction.
fn shift(pose: &mut [f64; 3], distance_m: f64, turn_rad: f64, random: &mut RandomStream) {
    let direction = random.uniform(-3.1, 3.1);
    pose[0] += distance_m * direction.cos();
    pose[1] += distance_m * direction.sin();
    pose[2] += turn_rad;
}

#[cfg(test)]
mod tests {
    use super::super::rows::tests::counted;
    use super::*;

    /// Differences to the rows as they were.
    fn errors(
        apply: fn(&mut Rows, f64, &mut RandomStream) -> bool,
        quantity: Quantity,
    ) -> Vec<f64> {
        let (plain, mut rows) = (counted(quantity), counted(quantity));
        assert!(apply(&mut rows, 1.0, &mut RandomStream::new(2, 0)));
        let both = rows.rows.iter().zip(&plain.rows);
        both.map(|(a, b)| a.values[0] - b.values[0]).collect()
    }

    #[test]
    fn outliers_are_rare_and_stand_alone() {
        let errors = errors(outliers, Quantity::Pose);
        let count = errors.iter().filter(|error| error.abs() > 1e-9).count();
        // 30 of 1000, deviation 5
        assert!((8..55).contains(&count), "{count}");
    }

    #[test]
    fn errors_of_scan_matching_add_up() {
        let errors = errors(accumulate, Quantity::Pose);
        let step: f64 = errors.windows(2).map(|two| (two[1] - two[0]).powi(2)).sum();
        // 3 mm for the root of a second, 1000 steps of 50 ms: 2 % of deviation
        assert!(((step / 50.0).sqrt() / 3e-3 - 1.0).abs() < 0.1);
        let largest = errors.iter().map(|error| error.abs()).fold(0.0, f64::max);
        assert!(largest > 5e-3);
    }

    #[test]
    fn a_jump_stays() {
        let errors = errors(jumps, Quantity::Pose);
        let steps = errors
            .windows(2)
            .filter(|two| (two[1] - two[0]).abs() > 1e-6)
            .count();
        assert!((1..=2).contains(&steps));
        assert!(errors.last().unwrap().abs() > 1e-6 && errors[0].abs() < 1e-9);
    }

    #[test]
    fn a_bias_is_constant() {
        let errors = errors(bias, Quantity::Gyro);
        assert!((errors[0].abs() - 0.03).abs() < 1e-9);
        assert!(errors.iter().all(|error| (error - errors[0]).abs() < 1e-9));
    }
}
