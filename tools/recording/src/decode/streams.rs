//! A robot's stream assembled from messages that arrive one by one.

use slipstream_bag::ros::cdr::decode;
use slipstream_bag::ros::messages as ros;
use slipstream_bag::{ChannelInfo, Undecodable, VisitResult};

use super::sample::{MessageSelector, NoSample, Sample};
use super::speeds::PoseSpeeds;
use crate::recording::UnknownColumn;
use crate::rows::{Disk, Spool, SpooledRecording, sorted_by_time};
use crate::table::{Cells, ColumnSet, OutOfRange, StreamKind, Table, is_time};

/// A robot's stream being assembled.
#[derive(Debug)]
pub(crate) struct StreamBuilder {
    /// Name of the robot.
    pub(crate) robot: String,
    /// The stream.
    pub(crate) kind: StreamKind,
    /// Which part of a message to read.
    pub(crate) selector: MessageSelector,
    /// Whether the signs of the right and left wheel are turned.
    pub(crate) reversed: [bool; 2],
    /// Where the speeds are those of the poses.
    pub(crate) speeds: Option<PoseSpeeds>,
    spool: Spool,
    /// For each column of the channel its place in the table.
    places: Vec<usize>,
    /// Whether a message gave a value for a column of the table.
    has_values: Vec<bool>,
    out_of_range: OutOfRange,
}

impl StreamBuilder {
    /// An empty stream with these columns.
    ///
    /// # Errors
    /// The problem, if the format does not define such a set of columns for the stream.
    pub(crate) fn new(
        disk: &Disk,
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
        let set = ColumnSet::choose(kind, &known).map_err(|(problem, _)| problem)?;
        let columns = set.present(&known);
        let place = |name| columns.iter().position(|known| known == name);
        let places = known.iter().filter_map(place).collect();
        let unknown = unknown.iter().map(UnknownColumn::named).collect();
        Ok(Self {
            robot: robot.to_owned(),
            kind,
            selector: MessageSelector::default(),
            reversed: [false; 2],
            speeds: None,
            spool: Spool::new(disk, Table::new(&columns, unknown)),
            places,
            has_values: vec![false; columns.len()],
            out_of_range: OutOfRange::default(),
        })
    }

    /// Appends a row from a standard message. `t_s` converts the message's stamp (ns), if it has
    /// one, to the time of the row (s).
    pub(crate) fn push_message(
        &mut self,
        channel: &ChannelInfo,
        data: &[u8],
        t_s: impl FnOnce(Option<i64>) -> f64,
    ) -> VisitResult {
        let mut sample = match Sample::decode(channel, &self.selector, data) {
            Ok(sample) => sample,
            Err(NoSample::NotSelected) => return Ok(()),
            Err(NoSample::Undecodable) => return Err(Undecodable),
        };
        let mut t_s = t_s(sample.t_ns);
        if let Some(speeds) = &mut self.speeds {
            let Some((middle_s, twist)) = speeds.push(t_s, sample.pose) else {
                return Ok(());
            };
            (t_s, sample.twist) = (middle_s, twist);
        }
        self.push_sample(t_s, &sample);
        Ok(())
    }

    fn push_sample(&mut self, t_s: f64, sample: &Sample) {
        let table = self.spool.tail();
        table.t_s.push(t_s);
        for ((name, cells), has_values) in table.columns.iter_mut().zip(&mut self.has_values) {
            match cells {
                Cells::Numbers(cells) => {
                    let number = sign(self.reversed, name) * sample.number(name);
                    let number = self.out_of_range.cell(name, number);
                    *has_values |= number.is_finite();
                    cells.push(number);
                }
                Cells::Counts(cells) => {
                    let count = sample.ticks[usize::from(*name == "ticks_left")];
                    let turned =
                        |count: i64| count.saturating_mul(sign(self.reversed, name) as i64);
                    let count = count.map(turned);
                    *has_values |= count.is_some();
                    cells.push(count);
                }
                Cells::Texts(_) => {}
            }
        }
        let unknown = table.unknown.iter_mut();
        unknown.for_each(|column| column.cells.push(String::new()));
        self.spool.end_row();
    }

    /// Appends a row of a pose: x (m), y (m), yaw (rad).
    pub(crate) fn push_pose(&mut self, t_s: f64, pose: [f64; 3]) {
        let mut sample = Sample::empty(None);
        sample.pose = pose;
        self.push_sample(t_s, &sample);
    }

    /// Appends a row of two wheels, right and left, in the quantity of the columns. Counts are rounded.
    pub(crate) fn push_wheels(&mut self, t_s: f64, values: [f64; 2]) {
        /// Counts up to here are exact in floating point.
        const MOST_COUNT: f64 = 9_007_199_254_740_992.0;
        let table = self.spool.tail();
        table.t_s.push(t_s);
        let columns = table.columns.iter_mut().zip(&mut self.has_values);
        for (((name, cells), has_values), value) in columns.zip(values) {
            let value = sign(self.reversed, name) * value;
            match cells {
                Cells::Numbers(cells) => {
                    let number = self.out_of_range.cell(name, value);
                    *has_values |= number.is_finite();
                    cells.push(number);
                }
                Cells::Counts(cells) => {
                    let is_count = value.abs() <= MOST_COUNT;
                    *has_values |= is_count;
                    cells.push(is_count.then(|| value.round() as i64));
                }
                Cells::Texts(_) => {}
            }
        }
        self.spool.end_row();
    }

    /// Appends a row from a lossless row message.
    pub(crate) fn push_row(&mut self, data: &[u8]) -> VisitResult {
        let row: ros::Row<Vec<f64>, Vec<String>> = decode(data).map_err(|_| Undecodable)?;
        let table = self.spool.tail();
        let is_number = |(_, cells): &&(&str, Cells)| matches!(cells, Cells::Numbers(_));
        let numbers = table.columns.iter().filter(is_number).count();
        let texts = table.columns.len() - numbers + table.unknown.len();
        let shape = (row.numbers.len(), row.texts.len());
        if !is_time(row.t_s) || shape != (numbers, texts) {
            return Err(Undecodable);
        }
        let (mut numbers, mut texts) = (row.numbers.into_iter(), row.texts.into_iter());
        table.t_s.push(row.t_s);
        for place in &self.places {
            match table.columns.get_mut(*place) {
                Some((name, Cells::Numbers(cells))) => {
                    let number = numbers.next().unwrap_or(f64::NAN);
                    cells.push(self.out_of_range.cell(name, number));
                }
                Some((_, Cells::Counts(cells))) => {
                    cells.push(texts.next().and_then(|t| t.parse().ok()));
                }
                Some((_, Cells::Texts(_))) | None => {}
            }
        }
        for (column, cell) in table.unknown.iter_mut().zip(texts) {
            column.cells.push(cell);
        }
        self.spool.end_row();
        Ok(())
    }

    /// Whether there is no row.
    pub(crate) fn is_empty(&self) -> bool {
        self.spool.len() == 0
    }

    /// The columns for which no message gave a value, and which the stream needs; if it needs none, all columns where
    /// none has a value.
    pub(crate) fn empty_columns(&self) -> Vec<&'static str> {
        let columns = self.spool.empty().columns;
        let columns = columns.iter().map(|(name, _)| *name).zip(&self.has_values);
        let empty = columns
            .filter(|(_, has_values)| !**has_values)
            .map(|(name, _)| name);
        let empty: Vec<&'static str> = empty.collect();
        if empty.len() == self.has_values.len() {
            return empty;
        }
        let needed = empty.iter().filter(|name| self.kind.needs(name));
        needed.copied().collect()
    }

    /// Stores the stream in its robot, which is added if it is new. Sorts rows that are out of
    /// order, with a warning.
    pub(crate) fn finish(mut self, recording: &mut SpooledRecording, warnings: &mut Vec<String>) {
        self.pass_on(recording, warnings, &Disk::default());
    }

    /// As [`finish`](Self::finish), with the rows so far; those that follow go to another disk.
    pub(crate) fn pass_on(
        &mut self,
        recording: &mut SpooledRecording,
        warnings: &mut Vec<String>,
        next: &Disk,
    ) {
        let stream = format!("{}/{}", self.robot, self.kind.name());
        std::mem::take(&mut self.out_of_range).warn(&stream, warnings);
        let spool = self.spool.take(next);
        if !spool.is_sorted() {
            warnings.push(format!(
                "{stream}: messages are out of order; sorted by time"
            ));
        }
        recording.store(&self.robot, self.kind, sorted_by_time(spool));
    }
}

/// The sign that a map gives a column, where the right or left wheel is turned.
fn sign([right, left]: [bool; 2], column: &str) -> f64 {
    let has = |side: &str| column.split('_').any(|word| word == side);
    match (right && has("right")) || (left && has("left")) {
        true => -1.0,
        false => 1.0,
    }
}
