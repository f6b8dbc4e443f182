//! A robot's stream assembled from messages that arrive one by one.

use super::sample::{MessageSelector, NoSample, Sample};
use crate::bag::{Undecodable, VisitResult};
use crate::recording::{Recording, Robot, UnknownColumn};
use crate::ros2::cdr::decode;
use crate::ros2::messages as ros;
use crate::table::{Cells, ColumnSet, StreamKind, Table, finite_or_nan};

/// A robot's stream being assembled.
#[derive(Debug)]
pub(crate) struct StreamBuilder {
    /// Name of the robot.
    pub(crate) robot: String,
    /// The stream.
    pub(crate) kind: StreamKind,
    /// Which part of a message to read.
    pub(crate) selector: MessageSelector,
    table: Table,
}

impl StreamBuilder {
    /// An empty stream with these columns.
    ///
    /// # Errors
    /// The problem, if the format does not define such a set of columns for the stream.
    pub(crate) fn new(
        robot: &str,
        kind: StreamKind,
        columns: &[String],
        unknown: &[String],
    ) -> Result<Self, String> {
        let mut known = Vec::new();
        for name in columns {
            let column = kind.column(name);
            let column = column.ok_or_else(|| format!("{} has no column {name}", kind.name()))?;
            if known.contains(&column) {
                return Err(format!("column {column} occurs twice"));
            }
            known.push(column);
        }
        ColumnSet::choose(kind, &known).map_err(|(problem, _)| problem)?;
        let unknown = unknown.iter().map(UnknownColumn::named).collect();
        Ok(Self {
            robot: robot.to_owned(),
            kind,
            selector: MessageSelector::default(),
            table: Table::new(&known, unknown),
        })
    }

    /// Appends a row from a standard message. `t_s` converts the message's stamp (ns), if it has
    /// one, to the time of the row (s).
    pub(crate) fn push_message(
        &mut self,
        schema: &str,
        data: &[u8],
        t_s: impl FnOnce(Option<i64>) -> f64,
    ) -> VisitResult {
        let sample = match Sample::decode(schema, &self.selector, data) {
            Ok(sample) => sample,
            Err(NoSample::NotSelected) => return Ok(()),
            Err(NoSample::Undecodable) => return Err(Undecodable),
        };
        self.table.t_s.push(t_s(sample.t_ns));
        for (name, cells) in &mut self.table.columns {
            match cells {
                Cells::Numbers(cells) => cells.push(finite_or_nan(sample.number(name))),
                Cells::Counts(cells) => {
                    cells.push(sample.ticks[usize::from(*name == "ticks_left")]);
                }
            }
        }
        Ok(())
    }

    /// Appends a row from a lossless row message.
    pub(crate) fn push_row(&mut self, data: &[u8]) -> VisitResult {
        let row: ros::Row<Vec<f64>, Vec<String>> = decode(data).map_err(|_| Undecodable)?;
        let is_number = |(_, cells): &&(&str, Cells)| matches!(cells, Cells::Numbers(_));
        let numbers = self.table.columns.iter().filter(is_number).count();
        let texts = self.table.columns.len() - numbers + self.table.unknown.len();
        let shape = (row.numbers.len(), row.texts.len());
        if !row.t_s.is_finite() || shape != (numbers, texts) {
            return Err(Undecodable);
        }
        let (mut numbers, mut texts) = (row.numbers.into_iter(), row.texts.into_iter());
        self.table.t_s.push(row.t_s);
        for (_, cells) in &mut self.table.columns {
            match cells {
                Cells::Numbers(cells) => {
                    cells.push(finite_or_nan(numbers.next().unwrap_or(f64::NAN)));
                }
                Cells::Counts(cells) => cells.push(texts.next().and_then(|t| t.parse().ok())),
            }
        }
        for (column, cell) in self.table.unknown.iter_mut().zip(texts) {
            column.cells.push(cell);
        }
        Ok(())
    }

    /// Stores the stream in its robot, which is added if it is new. Sorts rows that are out of
    /// order, with a warning.
    pub(crate) fn finish(mut self, recording: &mut Recording, warnings: &mut Vec<String>) {
        if !self.table.t_s.is_sorted() {
            warnings.push(format!(
                "{}/{}: messages are out of order; sorted by time",
                self.robot,
                self.kind.name()
            ));
            sort_by_time(&mut self.table);
        }
        let index = recording.robots.iter().position(|r| r.name == self.robot);
        let index = index.unwrap_or_else(|| {
            recording.robots.push(Robot::named(self.robot.as_str()));
            recording.robots.len() - 1
        });
        if let Some(robot) = recording.robots.get_mut(index) {
            self.table.store_in(robot, self.kind);
        }
    }
}

/// Sorts rows by time; rows with equal times keep their order.
fn sort_by_time(table: &mut Table) {
    let mut order: Vec<usize> = (0..table.t_s.len()).collect();
    order.sort_by(|a, b| {
        let time = |row: &usize| table.t_s.get(*row).copied().unwrap_or(f64::NAN);
        time(a).total_cmp(&time(b))
    });
    fn sorted<T: Clone>(cells: &[T], order: &[usize]) -> Vec<T> {
        let cells = order.iter().filter_map(|row| cells.get(*row));
        cells.cloned().collect()
    }
    table.t_s = sorted(&table.t_s, &order);
    for (_, cells) in &mut table.columns {
        match cells {
            Cells::Numbers(cells) => *cells = sorted(cells, &order),
            Cells::Counts(cells) => *cells = sorted(cells, &order),
        }
    }
    for column in &mut table.unknown {
        column.cells = sorted(&column.cells, &order);
    }
}
