//! Two robots that write to one topic: values that jump back and forth between two courses.

use super::report::{Finding, Severity};
use crate::rows::RobotRows;
use crate::table::StreamKind;

/// Columns, and the step between two rows (in their unit) that counts as a jump.
const COLUMNS: [(StreamKind, &str, f64); 4] = [
    (StreamKind::Wheels, "angle_right_rad", std::f64::consts::PI),
    (StreamKind::Wheels, "angle_left_rad", std::f64::consts::PI),
    (StreamKind::Pose, "x_m", 0.5),
    (StreamKind::Pose, "y_m", 0.5),
];
/// So many jumps are needed, and such a share of all rows.
const FEWEST_JUMPS: u64 = 10;
const SHARE_OF_ROWS: f64 = 0.1;
/// Such a share of the jumps must go back by the last jump's size, to within this part of it.
const SHARE_BACK: f64 = 0.7;
const SAME_SIZE: f64 = 0.2;

/// Adds an error for each stream with two sources.
pub(super) fn check(robot: &RobotRows<'_>, findings: &mut Vec<Finding>) {
    for (kind, column, limit) in COLUMNS {
        let is_known = |finding: &Finding| {
            finding.id == "two_sources" && finding.robot.as_deref() == Some(&robot.robot.name)
        };
        let Some(rows) = robot.stream(kind).filter(|rows| rows.has(column)) else {
            continue;
        };
        let mut jumps = Jumps::default();
        let mut cursor = rows.clone().cursor();
        while let Some(block) = cursor.next_block() {
            let values = block.numbers_of(column).iter();
            values.for_each(|value| jumps.add(*value, limit));
        }
        if jumps.have_two_sources() && !findings.iter().any(is_known) {
            let name = kind.name();
            findings.push(Finding::new(
                Severity::Error,
                &robot.robot.name,
                "two_sources",
                format!(
                    "{column} of {name} jumps back and forth {} times, as if two robots wrote to one topic",
                    jumps.count
                ),
                "give each robot a topic of its own (a namespace), and record again",
            ));
        }
    }
}

/// Steps between rows that are too large for one robot.
#[derive(Default)]
struct Jumps {
    rows: u64,
    count: u64,
    /// Jumps that go back by the size of the last one.
    back: u64,
    last_value: Option<f64>,
    last_jump: f64,
}

impl Jumps {
    fn add(&mut self, value: f64, limit: f64) {
        if !value.is_finite() {
            return;
        }
        self.rows += 1;
        let step = self.last_value.map_or(0.0, |last| value - last);
        self.last_value = Some(value);
        if step.abs() > limit {
            self.count += 1;
            let differs = (step + self.last_jump).abs();
            self.back += u64::from(differs < SAME_SIZE * step.abs());
            self.last_jump = step;
        }
    }

    fn have_two_sources(&self) -> bool {
        self.count >= FEWEST_JUMPS
            && self.count as f64 > SHARE_OF_ROWS * self.rows as f64
            && self.back as f64 > SHARE_BACK * self.count as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn has_two(values: impl Iterator<Item = f64>) -> bool {
        let mut jumps = Jumps::default();
        values.for_each(|value| jumps.add(value, 3.0));
        jumps.have_two_sources()
    }

    #[test]
    fn two_courses_in_turn_are_told_from_one_fast_wheel() {
        let turn = |i: i32| f64::from(i) * 0.1 + if i % 3 == 0 { 100.0 } else { -40.0 };
        assert!(has_two((0..60).map(turn)));
        assert!(!has_two((0..60).map(|i| f64::from(i) * 5.0)));
        // An angle that is wrapped jumps one way only.
        assert!(!has_two((0..200).map(|i| (f64::from(i) * 2.0) % 6.0)));
    }
}
