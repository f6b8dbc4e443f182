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

/// Scan matching: the motion from row to row is off by 0.3 to 3 mm and 0.2 to 2 mrad for the root of a second, and
/// motions add up.
pub(super) fn accumulate(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let root = rows.period_s.sqrt();
    let walk_m = root * within([3e-4, 3e-3], size);
    let walk_rad = root * within([2e-4, 2e-3], size);
    let Some(first) = rows.rows.first() else {
        return false;
    };
    let (mut before, mut matched) = (first.values, first.values);
    for row in &mut rows.rows[1..] {
        let [ahead, left, turn] = motion(before, row.values);
        let wrong = [walk_m, walk_m, walk_rad].map(|deviation| random.normal(deviation));
        before = row.values;
        matched = moved(
            matched,
            [ahead + wrong[0], left + wrong[1], turn + wrong[2]],
        );
        row.values = matched;
    }
    true
}

/// The pose jumps by 0.1 to 0.5 m and turns a little, once or twice, and goes on from there.
pub(super) fn jumps(rows: &mut Rows, size: f64, random: &mut RandomStream) -> bool {
    let all = rows.rows.len();
    for _ in 0..1 + usize::from(random.bernoulli(0.4)) {
        let from = (all as f64 * random.uniform(0.15, 0.85)) as usize;
        let Some(pivot) = rows.rows.get(from).map(|row| row.values) else {
            return false;
        };
        let mut landed = pivot;
        shift(
            &mut landed,
            within([0.1, 0.5], size),
            random.normal(0.03),
            random,
        );
        for row in &mut rows.rows[from..] {
            row.values = moved(landed, motion(pivot, row.values));
        }
    }
    true
}

/// Motion from one pose to another, in the frame of the first.
fn motion([x, y, yaw]: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = yaw.sin_cos();
    let [along, across] = [to[0] - x, to[1] - y];
    [
        along * cos + across * sin,
        across * cos - along * sin,
        to[2] - yaw,
    ]
}

/// The pose after a motion in its own frame.
fn moved([x, y, yaw]: [f64; 3], [ahead, left, turn]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = yaw.sin_cos();
    [
        x + ahead * cos - left * sin,
        y + ahead * sin + left * cos,
        yaw + turn,
    ]
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

    /// Motions from row to row, before and after.
    fn motions(apply: fn(&mut Rows, f64, &mut RandomStream) -> bool) -> Vec<[[f64; 3]; 2]> {
        let (plain, mut rows) = (counted(Quantity::Pose), counted(Quantity::Pose));
        assert!(apply(&mut rows, 1.0, &mut RandomStream::new(2, 0)));
        let step = |rows: &Rows, k: usize| motion(rows.rows[k].values, rows.rows[k + 1].values);
        (0..999)
            .map(|k| [step(&plain, k), step(&rows, k)])
            .collect()
    }

    #[test]
    fn errors_of_scan_matching_add_up() {
        let square = |i: usize| -> f64 {
            let steps = motions(accumulate).into_iter();
            steps
                .map(|[plain, matched]| (matched[i] - plain[i]).powi(2))
                .sum()
        };
        // 3 mm and 2 mrad for the root of a second, 1000 steps of 50 ms: 2 % of deviation
        assert!(((square(0) / 50.0).sqrt() / 3e-3 - 1.0).abs() < 0.1);
        assert!(((square(2) / 50.0).sqrt() / 2e-3 - 1.0).abs() < 0.1);
        let errors = errors(accumulate, Quantity::Pose);
        assert!(errors.iter().any(|error| error.abs() > 0.1));
    }

    #[test]
    fn after_a_jump_the_robot_moves_on_as_before() {
        let differs = |[plain, jumped]: &[[f64; 3]; 2]| (plain[0] - jumped[0]).abs() > 1e-6;
        let steps = motions(jumps);
        let jumps_made = steps.iter().filter(|own| differs(own)).count();
        assert!((1..=2).contains(&jumps_made), "{jumps_made}");
        let errors = errors(jumps, Quantity::Pose);
        assert!(errors[999].abs() > 1e-3 && errors[0].abs() < 1e-9);
    }

    #[test]
    fn a_bias_is_constant() {
        let errors = errors(bias, Quantity::Gyro);
        assert!((errors[0].abs() - 0.03).abs() < 1e-9);
        assert!(errors.iter().all(|error| (error - errors[0]).abs() < 1e-9));
    }
}
