//! A stream as a table on its way out.

use super::cells::CellsView;
use super::kind::StreamKind;
use crate::recording::{Command, Imu, Motor, Odometry, Pose, Robot, Stream, UnknownColumn, Wheels};

/// A stream on its way out.
#[derive(Debug, Clone)]
pub(crate) struct TableView<'a> {
    pub(crate) t_s: &'a [f64],
    pub(crate) columns: Vec<(&'static str, CellsView<'a>)>,
    pub(crate) unknown: &'a [UnknownColumn],
}

impl<'a> TableView<'a> {
    /// The robot's stream of that kind, if it has one.
    pub(crate) fn of(robot: &'a Robot, kind: StreamKind) -> Option<Self> {
        match kind {
            StreamKind::Command => robot
                .command
                .as_ref()
                .map(|s| Self::new(s, command(&s.values))),
            StreamKind::Wheels => robot
                .wheels
                .as_ref()
                .map(|s| Self::new(s, wheels(&s.values))),
            StreamKind::Odometry => robot.odometry.as_ref().map(|s| {
                let Odometry { v_m_s, w_rad_s } = &s.values;
                Self::new(
                    s,
                    present([("v_m_s", Some(v_m_s)), ("w_rad_s", w_rad_s.as_ref())]),
                )
            }),
            StreamKind::Pose => robot.pose.as_ref().map(|s| {
                let Pose { x_m, y_m, yaw_rad } = &s.values;
                Self::new(
                    s,
                    present([
                        ("x_m", Some(x_m)),
                        ("y_m", Some(y_m)),
                        ("yaw_rad", yaw_rad.as_ref()),
                    ]),
                )
            }),
            StreamKind::Imu => robot.imu.as_ref().map(|s| {
                let Imu {
                    ax_m_s2,
                    ay_m_s2,
                    gz_rad_s,
                } = &s.values;
                Self::new(
                    s,
                    present([
                        ("ax_m_s2", ax_m_s2.as_ref()),
                        ("ay_m_s2", ay_m_s2.as_ref()),
                        ("gz_rad_s", gz_rad_s.as_ref()),
                    ]),
                )
            }),
            StreamKind::Motor => robot.motor.as_ref().map(|s| {
                let Motor {
                    current_right_a,
                    current_left_a,
                    supply_v,
                } = &s.values;
                Self::new(
                    s,
                    present([
                        ("current_right_a", current_right_a.as_ref()),
                        ("current_left_a", current_left_a.as_ref()),
                        ("supply_v", supply_v.as_ref()),
                    ]),
                )
            }),
        }
    }

    fn new<V>(stream: &'a Stream<V>, columns: Vec<(&'static str, CellsView<'a>)>) -> Self {
        Self {
            t_s: &stream.t_s,
            columns,
            unknown: &stream.unknown,
        }
    }
}

type Columns<'a> = Vec<(&'static str, CellsView<'a>)>;

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
