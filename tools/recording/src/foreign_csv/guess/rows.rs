//! Files without names of columns, told by what their rows have: trajectories of TUM and KITTI, and what
//! `ros2 topic echo --csv` writes.

use super::called::{COMMANDS, REFERENCES};
use super::guessed::{Guessed, OF_ODOMETRY};
use super::times;
use super::units::words;
use crate::foreign_csv::entry::{Column, ColumnEntry, Source, TimeEntry};
use crate::foreign_csv::layout::Sample;
use crate::sides::{Side, side_of};
use crate::table::StreamKind;

/// Rows each second of the sequences of KITTI.
const KITTI_PERIOD_S: f64 = 0.1;
const OF_KITTI: &str = "poses of a camera (z forwards, x to the right) without times: correct period_s, the time from row to row";

/// The streams that the rows suggest. `file` is the file's name, which may tell what they are.
pub(super) fn guess(sample: &Sample, file: &str) -> Vec<Guessed> {
    let Some(row) = sample.rows.first() else {
        return Vec::new();
    };
    let numbers: Vec<Option<f64>> = row.iter().map(|cell| cell.parse().ok()).collect();
    let rows = UnnamedRows(sample);
    match numbers.as_slice() {
        [Some(_), Some(_), Some(_), Some(_), quaternion @ ..] if is_unit(quaternion) => {
            let times = sample.rows.iter().filter_map(|row| row.first());
            let time = ColumnEntry {
                factor: times::unit_of(times),
                ..rows.at(1)
            };
            vec![rows.pose(TimeEntry::Column(time), 2, 5)]
        }
        numbers if is_transform(numbers) => vec![rows.kitti()],
        [Some(s), Some(ns), None, ..] if is_stamp(*s, *ns) => rows.message(row.len(), &words(file)),
        _ => Vec::new(),
    }
}

/// Whether the four cells are a rotation.
fn is_unit(cells: &[Option<f64>]) -> bool {
    let squares = cells.iter().map(|cell| cell.map(|cell| cell * cell));
    let size: Option<f64> = squares.sum();
    cells.len() == 4 && size.is_some_and(|size| (size - 1.0).abs() < 0.02)
}

/// Whether twelve cells are a rotation and a translation, row by row.
fn is_transform(cells: &[Option<f64>]) -> bool {
    let row = |row: &[Option<f64>]| match row {
        [a, b, c, _] => is_unit(&[*a, *b, *c, Some(0.0)]),
        _ => false,
    };
    cells.len() == 12 && cells.iter().all(Option::is_some) && cells.chunks(4).all(row)
}

/// Whether two numbers are seconds and nanoseconds.
fn is_stamp(s: f64, ns: f64) -> bool {
    s >= 0.0 && s.fract() == 0.0 && ns.fract() == 0.0 && (0.0..1e9).contains(&ns)
}

/// Rows without names. Columns are numbered from 1.
struct UnnamedRows<'a>(&'a Sample);

impl UnnamedRows<'_> {
    fn at(&self, number: usize) -> ColumnEntry {
        ColumnEntry {
            column: Column::Number(number),
            factor: 1.0,
            offset: 0.0,
        }
    }

    fn one(&self, number: usize) -> Source<ColumnEntry> {
        Source::One(self.at(number))
    }

    /// A pose whose position and quaternion begin at these columns.
    fn pose(&self, time: TimeEntry, position: usize, quaternion: usize) -> Guessed {
        let [x, y, z, w] = [0, 1, 2, 3].map(|part| self.at(quaternion + part));
        let columns = vec![
            ("x_m", self.one(position)),
            ("y_m", self.one(position + 1)),
            ("yaw_rad", Source::Quaternion([Some(x), Some(y)], [z, w])),
        ];
        Guessed::new(StreamKind::Pose, time, columns)
    }

    /// A speed along x and a rate about z, of vectors that begin at these columns.
    fn twist(&self, kind: StreamKind, time: TimeEntry, linear: usize, angular: usize) -> Guessed {
        let columns = vec![
            ("v_m_s", self.one(linear)),
            ("w_rad_s", self.one(angular + 2)),
        ];
        Guessed::new(kind, time, columns)
    }

    fn kitti(&self) -> Guessed {
        let negative = |number| ColumnEntry {
            factor: -1.0,
            ..self.at(number)
        };
        let columns = vec![
            ("x_m", self.one(12)),
            ("y_m", Source::One(negative(4))),
            ("yaw_rad", Source::Direction([self.at(11), negative(3)])),
        ];
        let time = TimeEntry::Period(KITTI_PERIOD_S);
        Guessed::new(StreamKind::Pose, time, columns).with_note(OF_KITTI)
    }

    /// A message with a header: seconds, nanoseconds, frame. The number of its cells tells its type.
    fn message(&self, cells: usize, file: &[String]) -> Vec<Guessed> {
        let is_called = |called: &[&str]| file.iter().any(|word| called.contains(&word.as_str()));
        let time = || TimeEntry::Parts([self.at(1), self.at(2)]);
        match (self.texts(), cells) {
            // Odometry: a frame more, pose, covariance, twist, covariance.
            (1, 89) if is_called(&REFERENCES) => vec![self.pose(time(), 5, 8)],
            (1, 89) => vec![
                self.twist(StreamKind::Odometry, time(), 48, 51),
                self.pose(time(), 5, 8).with_note(OF_ODOMETRY),
            ],
            // PoseStamped, and with a covariance.
            (0, 10 | 46) => vec![self.pose(time(), 4, 7)],
            // TransformStamped: a frame more.
            (1, 11) => vec![self.pose(time(), 5, 8)],
            // TwistStamped, and with a covariance.
            (0, 9 | 45) => {
                let kind = match is_called(&COMMANDS) {
                    true => StreamKind::Command,
                    false => StreamKind::Odometry,
                };
                vec![self.twist(kind, time(), 4, 7)]
            }
            // Imu: orientation, rates, accelerations, each with a covariance.
            (0, 40) => {
                let columns = vec![
                    ("ax_m_s2", self.one(29)),
                    ("ay_m_s2", self.one(30)),
                    ("gz_rad_s", self.one(19)),
                ];
                vec![Guessed::new(StreamKind::Imu, time(), columns)]
            }
            _ => self.joint_state(time()).into_iter().collect(),
        }
    }

    /// How many cells after the header are no numbers.
    fn texts(&self) -> usize {
        let after = self.0.rows.first().and_then(|row| row.get(3..));
        let is_name = |cell: &&String| cell.parse::<f64>().is_err() && !cell.is_empty();
        let after = after.unwrap_or_default().iter();
        after.take_while(is_name).count()
    }

    /// Names of joints, then an angle each.
    fn joint_state(&self, time: TimeEntry) -> Option<Guessed> {
        let after = self.0.rows.first()?.get(3..)?;
        let names = after.get(..self.texts())?;
        if names.is_empty() || after.len() % names.len() != 0 || after.len() == names.len() {
            return None;
        }
        let place = |side| names.iter().position(|name| side_of(name) == Some(side));
        let [right, left] = Side::BOTH.map(place);
        let angle = |index: usize| self.one(4 + names.len() + index);
        let columns = vec![
            ("angle_right_rad", angle(right?)),
            ("angle_left_rad", angle(left?)),
        ];
        Some(Guessed::new(StreamKind::Wheels, time, columns))
    }
}
