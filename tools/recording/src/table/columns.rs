//! Rows of a stream, as a table of columns.

use super::cells::{Cells, number_at};
use super::kind::StreamKind;
use super::links::{LINK_COLUMNS, ROUND_TRIP_COLUMNS};
use crate::recording::{Command, Imu, Motor, Odometry, Pose, Robot, Stream, UnknownColumn, Wheels};

/// Rows of a stream, a few or all: owned columns by name.
#[derive(Debug, Clone, Default)]
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

    /// Position messages without rows. Times are those of sending; all columns are present.
    pub(crate) fn of_links(unknown: &[UnknownColumn]) -> Self {
        let [_, columns @ ..] = LINK_COLUMNS;
        Self::new(&columns, names_of(unknown))
    }

    /// Round trips without rows. They have no times.
    pub(crate) fn of_round_trips(unknown: &[UnknownColumn]) -> Self {
        Self::new(&ROUND_TRIP_COLUMNS, names_of(unknown))
    }

    /// The columns, without rows.
    pub(crate) fn without_rows(&self) -> Self {
        let columns: Vec<&'static str> = self.columns.iter().map(|(name, _)| *name).collect();
        Self::new(&columns, names_of(&self.unknown))
    }

    /// Removes all rows.
    pub(crate) fn clear(&mut self) {
        self.t_s.clear();
        self.columns.iter_mut().for_each(|(_, cells)| cells.clear());
        self.unknown.iter_mut().for_each(|c| c.cells.clear());
    }

    /// Appends a row of a table with the same columns.
    pub(crate) fn push_from(&mut self, other: &Self, row: usize) {
        self.t_s.extend(other.t_s.get(row));
        for ((_, cells), (_, other)) in self.columns.iter_mut().zip(&other.columns) {
            cells.push_from(other, row);
        }
        for (column, other) in self.unknown.iter_mut().zip(&other.unknown) {
            column.cells.extend(other.cells.get(row).cloned());
        }
    }

    /// Makes room for this many rows.
    pub(crate) fn reserve(&mut self, rows: usize) {
        self.t_s.reserve_exact(rows);
        self.columns
            .iter_mut()
            .for_each(|(_, cells)| cells.reserve(rows));
        self.unknown
            .iter_mut()
            .for_each(|c| c.cells.reserve_exact(rows));
    }

    /// Appends all rows of a table with the same columns.
    pub(crate) fn extend_from(&mut self, other: &Self) {
        self.t_s.extend_from_slice(&other.t_s);
        for ((_, cells), (_, other)) in self.columns.iter_mut().zip(&other.columns) {
            cells.extend_from(other);
        }
        for (column, other) in self.unknown.iter_mut().zip(&other.unknown) {
            column.cells.extend_from_slice(&other.cells);
        }
    }

    /// Appends the cells of a round trip, without those of the unknown columns. It has no time.
    pub(crate) fn push_round_trip(&mut self, seq: i64, rtt_ms: f64) {
        self.t_s.push(0.0);
        for (_, cells) in &mut self.columns {
            match cells {
                Cells::Counts(cells) => cells.push(Some(seq)),
                Cells::Numbers(cells) => cells.push(rtt_ms),
                Cells::Texts(_) => {}
            }
        }
    }

    /// The cells of a column of numbers; empty if there is none of this name.
    pub(crate) fn numbers_of(&self, name: &str) -> &[f64] {
        match self.columns.iter().find(|(known, _)| *known == name) {
            Some((_, Cells::Numbers(cells))) => cells,
            _ => &[],
        }
    }

    /// The number in column `i`; NaN if the cell is empty or does not exist.
    pub(crate) fn number(&self, i: usize, row: usize) -> f64 {
        match self.columns.get(i) {
            Some((_, Cells::Numbers(cells))) => number_at(cells, row),
            Some((_, Cells::Counts(_))) => {
                self.count(i, row).map_or(f64::NAN, |count| count as f64)
            }
            Some((_, Cells::Texts(_))) | None => f64::NAN,
        }
    }

    /// The number in the column with this name; NaN if the cell is empty or does not exist.
    pub(crate) fn number_named(&self, name: &str, row: usize) -> f64 {
        let column = self.columns.iter().position(|(known, _)| *known == name);
        column.map_or(f64::NAN, |i| self.number(i, row))
    }

    /// The cells of a column of counts; empty if there is none of this name.
    pub(crate) fn counts_of(&self, name: &str) -> &[Option<i64>] {
        match self.columns.iter().find(|(known, _)| *known == name) {
            Some((_, Cells::Counts(cells))) => cells,
            _ => &[],
        }
    }

    /// The count in column `i`, if the cell is not empty.
    pub(crate) fn count(&self, i: usize, row: usize) -> Option<i64> {
        match self.columns.get(i) {
            Some((_, Cells::Counts(cells))) => cells.get(row).copied().flatten(),
            _ => None,
        }
    }

    /// The cells of a column of names; empty if there is none of this name.
    pub(crate) fn texts_of(&self, name: &str) -> &[String] {
        match self.columns.iter().find(|(known, _)| *known == name) {
            Some((_, Cells::Texts(cells))) => cells,
            _ => &[],
        }
    }

    /// The text in the column with this name; empty if it does not exist.
    pub(crate) fn text_named(&self, name: &str, row: usize) -> &str {
        self.texts_of(name).get(row).map_or("", String::as_str)
    }

    /// Size of the texts in the last row (bytes).
    pub(crate) fn text_bytes_of_last_row(&self) -> usize {
        let columns = self.columns.iter().filter_map(|(_, cells)| match cells {
            Cells::Texts(cells) => Some(cells),
            _ => None,
        });
        let unknown = self.unknown.iter().map(|column| &column.cells);
        let last = columns.chain(unknown).filter_map(|cells| cells.last());
        last.map(String::len).sum()
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

/// The same columns without cells.
fn names_of(unknown: &[UnknownColumn]) -> Vec<UnknownColumn> {
    let names = unknown.iter().map(|column| column.name.as_str());
    names.map(UnknownColumn::named).collect()
}
