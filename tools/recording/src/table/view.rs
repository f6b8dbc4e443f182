//! A stream being written, as a table of columns.

use super::cells::{CellsView, number_at};
use super::kind::StreamKind;
use crate::recording::{Command, Imu, Motor, Odometry, Pose, Robot, Stream, UnknownColumn, Wheels};

/// Columns by name.
type Columns<'a> = Vec<(&'static str, CellsView<'a>)>;

/// A stream being written: borrowed columns by name.
#[derive(Debug, Clone)]
pub(crate) struct TableView<'a> {
    /// Time of each row (s).
    pub(crate) t_s: &'a [f64],
    /// The columns that the format defines.
    pub(crate) columns: Columns<'a>,
    /// The other columns, as text.
    pub(crate) unknown: &'a [UnknownColumn],
}

impl<'a> TableView<'a> {
    /// The robot's stream of this kind, if it has one.
    pub(crate) fn of(robot: &'a Robot, kind: StreamKind) -> Option<Self> {
        match kind {
            StreamKind::Command => Self::new(robot.command.as_ref(), command),
            StreamKind::Wheels => Self::new(robot.wheels.as_ref(), wheels),
            StreamKind::Odometry => Self::new(robot.odometry.as_ref(), odometry),
            StreamKind::Pose => Self::new(robot.pose.as_ref(), pose),
            StreamKind::Imu => Self::new(robot.imu.as_ref(), imu),
            StreamKind::Motor => Self::new(robot.motor.as_ref(), motor),
        }
    }

    /// The number in column `i`; NaN if the cell is empty or does not exist.
    pub(crate) fn number(&self, i: usize, row: usize) -> f64 {
        match self.columns.get(i) {
            Some((_, CellsView::Numbers(cells))) => number_at(cells, row),
            Some((_, CellsView::Counts(_))) => {
                self.count(i, row).map_or(f64::NAN, |count| count as f64)
            }
            None => f64::NAN,
        }
    }

    /// The number in the column with this name; NaN if the cell is empty or does not exist.
    pub(crate) fn number_named(&self, name: &str, row: usize) -> f64 {
        let column = self.columns.iter().position(|(known, _)| *known == name);
        column.map_or(f64::NAN, |i| self.number(i, row))
    }

    /// The count in column `i`, if the cell is not empty.
    pub(crate) fn count(&self, i: usize, row: usize) -> Option<i64> {
        match self.columns.get(i) {
            Some((_, CellsView::Counts(cells))) => cells.get(row).copied().flatten(),
            _ => None,
        }
    }

    fn new<V>(
        stream: Option<&'a Stream<V>>,
        columns: impl Fn(&'a V) -> Columns<'a>,
    ) -> Option<Self> {
        stream.map(|stream| Self {
            t_s: &stream.t_s,
            columns: columns(&stream.values),
            unknown: &stream.unknown,
        })
    }
}

/// The columns that are present.
fn present<'a, const N: usize>(columns: [(&'static str, Option<&'a Vec<f64>>); N]) -> Columns<'a> {
    columns
        .into_iter()
        .filter_map(|(name, cells)| Some((name, CellsView::Numbers(cells?))))
        .collect()
}

fn command(command: &Command) -> Columns<'_> {
    let (names, a, b) = match command {
        Command::Torque { right_nm, left_nm } => {
            (["torque_right_nm", "torque_left_nm"], right_nm, left_nm)
        }
        Command::Voltage { right_v, left_v } => {
            (["voltage_right_v", "voltage_left_v"], right_v, left_v)
        }
        Command::WheelSpeed {
            right_rad_s,
            left_rad_s,
        } => (
            ["speed_right_rad_s", "speed_left_rad_s"],
            right_rad_s,
            left_rad_s,
        ),
        Command::Twist { v_m_s, w_rad_s } => (["v_m_s", "w_rad_s"], v_m_s, w_rad_s),
    };
    present([(names[0], Some(a)), (names[1], Some(b))])
}

fn wheels(wheels: &Wheels) -> Columns<'_> {
    match wheels {
        Wheels::Ticks { right, left } => vec![
            ("ticks_right", CellsView::Counts(right)),
            ("ticks_left", CellsView::Counts(left)),
        ],
        Wheels::Angle {
            right_rad,
            left_rad,
        } => present([
            ("angle_right_rad", Some(right_rad)),
            ("angle_left_rad", Some(left_rad)),
        ]),
        Wheels::Speed {
            right_rad_s,
            left_rad_s,
        } => present([
            ("speed_right_rad_s", Some(right_rad_s)),
            ("speed_left_rad_s", Some(left_rad_s)),
        ]),
    }
}

fn odometry(Odometry { v_m_s, w_rad_s }: &Odometry) -> Columns<'_> {
    present([("v_m_s", Some(v_m_s)), ("w_rad_s", w_rad_s.as_ref())])
}

fn pose(Pose { x_m, y_m, yaw_rad }: &Pose) -> Columns<'_> {
    present([
        ("x_m", Some(x_m)),
        ("y_m", Some(y_m)),
        ("yaw_rad", yaw_rad.as_ref()),
    ])
}

fn imu(imu: &Imu) -> Columns<'_> {
    present([
        ("ax_m_s2", imu.ax_m_s2.as_ref()),
        ("ay_m_s2", imu.ay_m_s2.as_ref()),
        ("gz_rad_s", imu.gz_rad_s.as_ref()),
    ])
}

fn motor(motor: &Motor) -> Columns<'_> {
    present([
        ("current_right_a", motor.current_right_a.as_ref()),
        ("current_left_a", motor.current_left_a.as_ref()),
        ("supply_v", motor.supply_v.as_ref()),
    ])
}
