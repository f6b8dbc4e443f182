//! A stream in memory, as a table of columns.

use std::ops::Range;

use super::cells::{Cells, CellsView, part};
use super::columns::Table;
use super::kind::StreamKind;
use crate::recording::{Command, Imu, Motor, Odometry, Pose, Robot, Stream, UnknownColumn, Wheels};

/// Columns by name.
type NamedColumns<'a> = Vec<(&'static str, CellsView<'a>)>;

/// A stream in memory: borrowed columns by name.
#[derive(Debug, Clone)]
pub(crate) struct TableView<'a> {
    /// Time of each row (s).
    pub(crate) t_s: &'a [f64],
    /// The columns that the format defines.
    pub(crate) columns: NamedColumns<'a>,
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

    /// The columns, without rows.
    pub(crate) fn empty(&self) -> Table {
        let columns: Vec<&'static str> = self.columns.iter().map(|(name, _)| *name).collect();
        let unknown = self.unknown.iter().map(|column| column.name.as_str());
        Table::new(&columns, unknown.map(UnknownColumn::named).collect())
    }

    /// Replaces the rows of `block`, which has the same columns, with these rows. Returns whether
    /// there are any.
    pub(crate) fn block(&self, rows: Range<usize>, block: &mut Table) -> bool {
        block.clear();
        block.t_s.extend_from_slice(part(self.t_s, &rows));
        for ((_, cells), (_, of)) in block.columns.iter_mut().zip(&self.columns) {
            match (cells, of) {
                (Cells::Numbers(cells), CellsView::Numbers(of)) => {
                    cells.extend_from_slice(part(of, &rows));
                }
                (Cells::Counts(cells), CellsView::Counts(of)) => {
                    cells.extend_from_slice(part(of, &rows));
                }
                _ => {}
            }
        }
        for (column, of) in block.unknown.iter_mut().zip(self.unknown) {
            column.cells.extend_from_slice(part(&of.cells, &rows));
        }
        !block.t_s.is_empty()
    }

    fn new<V>(
        stream: Option<&'a Stream<V>>,
        columns: impl Fn(&'a V) -> NamedColumns<'a>,
    ) -> Option<Self> {
        stream.map(|stream| Self {
            t_s: &stream.t_s,
            columns: columns(&stream.values),
            unknown: &stream.unknown,
        })
    }
}

/// The columns that are present.
fn present<'a, const N: usize>(
    columns: [(&'static str, Option<&'a Vec<f64>>); N],
) -> NamedColumns<'a> {
    columns
        .into_iter()
        .filter_map(|(name, cells)| Some((name, CellsView::Numbers(cells?))))
        .collect()
}

fn command(command: &Command) -> NamedColumns<'_> {
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

fn wheels(wheels: &Wheels) -> NamedColumns<'_> {
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

fn odometry(Odometry { v_m_s, w_rad_s }: &Odometry) -> NamedColumns<'_> {
    present([("v_m_s", Some(v_m_s)), ("w_rad_s", w_rad_s.as_ref())])
}

fn pose(Pose { x_m, y_m, yaw_rad }: &Pose) -> NamedColumns<'_> {
    present([
        ("x_m", Some(x_m)),
        ("y_m", Some(y_m)),
        ("yaw_rad", yaw_rad.as_ref()),
    ])
}

fn imu(imu: &Imu) -> NamedColumns<'_> {
    present([
        ("ax_m_s2", imu.ax_m_s2.as_ref()),
        ("ay_m_s2", imu.ay_m_s2.as_ref()),
        ("gz_rad_s", imu.gz_rad_s.as_ref()),
    ])
}

fn motor(motor: &Motor) -> NamedColumns<'_> {
    present([
        ("current_right_a", motor.current_right_a.as_ref()),
        ("current_left_a", motor.current_left_a.as_ref()),
        ("supply_v", motor.supply_v.as_ref()),
    ])
}
