//! A stream being read, as a table of columns.

use super::cells::Cells;
use super::kind::StreamKind;
use crate::recording::{Command, Imu, Motor, Odometry, Pose, Robot, Stream, UnknownColumn, Wheels};

/// A stream being read: owned columns by name.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    /// Time of each row (s).
    pub(crate) t_s: Vec<f64>,
    /// The columns that the format defines.
    pub(crate) columns: Vec<(&'static str, Cells)>,
    /// The other columns, as text.
    pub(crate) unknown: Vec<UnknownColumn>,
}

impl Table {
    /// A table without rows, with these columns of the format and these others.
    pub(crate) fn new(columns: &[&'static str], unknown: Vec<UnknownColumn>) -> Self {
        Self {
            t_s: Vec::new(),
            columns: columns
                .iter()
                .map(|name| (*name, Cells::new(name)))
                .collect(),
            unknown,
        }
    }

    /// Removes a column.
    fn take(&mut self, name: &str) -> Option<Cells> {
        let at = self.columns.iter().position(|(known, _)| *known == name)?;
        Some(self.columns.swap_remove(at).1)
    }

    /// Removes a column of numbers.
    fn numbers(&mut self, name: &str) -> Option<Vec<f64>> {
        self.take(name).map(Cells::into_numbers)
    }

    /// Removes the columns of the right and the left wheel.
    fn pair(&mut self, right: &str, left: &str) -> Option<(Vec<f64>, Vec<f64>)> {
        let right = self.numbers(right)?;
        Some((right, self.numbers(left)?))
    }

    fn into_stream<V>(self, values: V) -> Stream<V> {
        Stream {
            t_s: self.t_s,
            values,
            unknown: self.unknown,
        }
    }

    /// Stores this table as the robot's stream of that kind. The columns must have passed
    /// [`ColumnSet::choose`](super::ColumnSet::choose).
    pub(crate) fn store_in(mut self, robot: &mut Robot, kind: StreamKind) {
        match kind {
            StreamKind::Command => {
                robot.command = self.command().map(|values| self.into_stream(values));
            }
            StreamKind::Wheels => {
                robot.wheels = self.wheels().map(|values| self.into_stream(values));
            }
            StreamKind::Odometry => {
                let values = Odometry {
                    v_m_s: self.numbers("v_m_s").unwrap_or_default(),
                    w_rad_s: self.numbers("w_rad_s"),
                };
                robot.odometry = Some(self.into_stream(values));
            }
            StreamKind::Pose => {
                let values = Pose {
                    x_m: self.numbers("x_m").unwrap_or_default(),
                    y_m: self.numbers("y_m").unwrap_or_default(),
                    yaw_rad: self.numbers("yaw_rad"),
                };
                robot.pose = Some(self.into_stream(values));
            }
            StreamKind::Imu => {
                let values = Imu {
                    ax_m_s2: self.numbers("ax_m_s2"),
                    ay_m_s2: self.numbers("ay_m_s2"),
                    gz_rad_s: self.numbers("gz_rad_s"),
                };
                robot.imu = Some(self.into_stream(values));
            }
            StreamKind::Motor => {
                let values = Motor {
                    current_right_a: self.numbers("current_right_a"),
                    current_left_a: self.numbers("current_left_a"),
                    supply_v: self.numbers("supply_v"),
                };
                robot.motor = Some(self.into_stream(values));
            }
        }
    }

    fn command(&mut self) -> Option<Command> {
        if let Some((right_nm, left_nm)) = self.pair("torque_right_nm", "torque_left_nm") {
            return Some(Command::Torque { right_nm, left_nm });
        }
        if let Some((right_v, left_v)) = self.pair("voltage_right_v", "voltage_left_v") {
            return Some(Command::Voltage { right_v, left_v });
        }
        if let Some((right_rad_s, left_rad_s)) = self.pair("speed_right_rad_s", "speed_left_rad_s")
        {
            return Some(Command::WheelSpeed {
                right_rad_s,
                left_rad_s,
            });
        }
        let (v_m_s, w_rad_s) = self.pair("v_m_s", "w_rad_s")?;
        Some(Command::Twist { v_m_s, w_rad_s })
    }

    fn wheels(&mut self) -> Option<Wheels> {
        if let Some(right) = self.take("ticks_right") {
            return Some(Wheels::Ticks {
                right: right.into_counts(),
                left: self.take("ticks_left")?.into_counts(),
            });
        }
        if let Some((right_rad, left_rad)) = self.pair("angle_right_rad", "angle_left_rad") {
            return Some(Wheels::Angle {
                right_rad,
                left_rad,
            });
        }
        let (right_rad_s, left_rad_s) = self.pair("speed_right_rad_s", "speed_left_rad_s")?;
        Some(Wheels::Speed {
            right_rad_s,
            left_rad_s,
        })
    }
}
