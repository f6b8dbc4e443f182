//! Streams being built from messages that arrive one by one.

use std::sync::Arc;

use crate::bag::reader::{Undecodable, Visited};
use crate::recording::{LinkMessage, Links, Recording, Robot, RoundTrips, UnknownColumn};
use crate::ros2::cdr::decode;
use crate::ros2::messages as ros;
use crate::sample::{Nothing, Pick, Sample};
use crate::table::{Cells, ColumnSet, StreamKind, Table};
use crate::time::s_from_ns;

/// Keeps one copy of every name.
#[derive(Debug, Default)]
pub(crate) struct Names(Vec<Arc<str>>);

impl Names {
    pub(crate) fn get(&mut self, name: &str) -> Arc<str> {
        if let Some(known) = self.0.iter().find(|known| ***known == *name) {
            return Arc::clone(known);
        }
        let name: Arc<str> = name.into();
        self.0.push(Arc::clone(&name));
        name
    }
}

/// One robot's stream being built.
#[derive(Debug)]
pub(crate) struct StreamBuilder {
    pub(crate) robot: String,
    pub(crate) kind: StreamKind,
    /// Where to look in a message.
    pub(crate) pick: Pick,
    table: Table,
}

impl StreamBuilder {
    /// An empty stream with these columns, or what is wrong with them.
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
                return Err(format!("column {column} twice"));
            }
            known.push(column);
        }
        ColumnSet::choose(kind, &known).map_err(|(problem, _)| problem)?;
        let unknown = unknown.iter().map(|name| UnknownColumn {
            name: name.clone(),
            cells: Vec::new(),
        });
        Ok(Self {
            robot: robot.to_owned(),
            kind,
            pick: Pick::default(),
            table: Table {
                t_s: Vec::new(),
                columns: known.iter().map(|name| (*name, Cells::of(name))).collect(),
                unknown: unknown.collect(),
            },
        })
    }

    /// Adds what a standard message says. `t_s` turns the message's own stamp (ns) into seconds.
    pub(crate) fn push_message(
        &mut self,
        schema: &str,
        data: &[u8],
        t_s: impl FnOnce(Option<i64>) -> f64,
    ) -> Visited {
        let sample = match Sample::decode(schema, &self.pick, data) {
            Ok(sample) => sample,
            Err(Nothing::Elsewhere) => return Ok(()),
            Err(Nothing::Undecodable) => return Err(Undecodable),
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

    /// Adds a row that was kept to the digit.
    pub(crate) fn push_row(&mut self, data: &[u8]) -> Visited {
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

    /// Hands the stream to its robot. Rows out of order are sorted, which is said in a warning.
    pub(crate) fn finish(mut self, recording: &mut Recording, warnings: &mut Vec<String>) {
        if !self.table.t_s.is_sorted() {
            warnings.push(format!(
                "{}/{}: messages out of order, sorted by their times",
                self.robot,
                self.kind.name()
            ));
            sort_by_time(&mut self.table);
        }
        let place = recording.robots.iter().position(|r| r.name == self.robot);
        let place = place.unwrap_or_else(|| {
            recording.robots.push(Robot::named(self.robot.as_str()));
            recording.robots.len() - 1
        });
        if let Some(robot) = recording.robots.get_mut(place) {
            self.table.give_to(robot, self.kind);
        }
    }
}

/// Infinite numbers mean as little as NaN does: an empty cell.
fn finite_or_nan(number: f64) -> f64 {
    if number.is_finite() { number } else { f64::NAN }
}

/// Sorts rows by time, those at the same time as they came.
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

/// The messages between robots being built.
#[derive(Debug, Default)]
pub(crate) struct LinksBuilder {
    links: Links,
    names: Names,
}

impl LinksBuilder {
    pub(crate) fn new(with_velocity: bool, unknown: &[String]) -> Self {
        Self {
            links: Links {
                messages: Vec::new(),
                with_velocity,
                unknown: empty_columns(unknown),
            },
            names: Names::default(),
        }
    }

    pub(crate) fn push_message(&mut self, data: &[u8]) -> Visited {
        let message: ros::PositionMessage<String> = decode(data).map_err(|_| Undecodable)?;
        let arrived = message.fate == 0;
        self.links.messages.push(LinkMessage {
            t_sent_s: s_from_ns(message.t_sent_ns),
            t_received_s: arrived.then(|| s_from_ns(message.t_received_ns)),
            from: self.names.get(&message.sender),
            to: self.names.get(&message.receiver),
            x_m: finite_or_nan(message.x_m),
            y_m: finite_or_nan(message.y_m),
            yaw_rad: finite_or_nan(message.yaw_rad),
            v_m_s: finite_or_nan(message.v_m_s),
            w_rad_s: finite_or_nan(message.w_rad_s),
        });
        Ok(())
    }

    pub(crate) fn push_row(&mut self, data: &[u8]) -> Visited {
        let row: ros::Row<Vec<f64>, Vec<String>> = decode(data).map_err(|_| Undecodable)?;
        let [received, x_m, y_m, yaw_rad, v_m_s, w_rad_s] = row.numbers[..] else {
            return Err(Undecodable);
        };
        let mut texts = row.texts.into_iter();
        let (Some(from), Some(to)) = (texts.next(), texts.next()) else {
            return Err(Undecodable);
        };
        if !row.t_s.is_finite() || texts.len() != self.links.unknown.len() {
            return Err(Undecodable);
        }
        self.links.messages.push(LinkMessage {
            t_sent_s: row.t_s,
            t_received_s: Some(received).filter(|t_s| t_s.is_finite()),
            from: self.names.get(&from),
            to: self.names.get(&to),
            x_m,
            y_m,
            yaw_rad,
            v_m_s,
            w_rad_s,
        });
        for (column, cell) in self.links.unknown.iter_mut().zip(texts) {
            column.cells.push(cell);
        }
        Ok(())
    }

    /// The messages in the order of sending. (A run writes them when it knows what became of them.)
    pub(crate) fn finish(mut self) -> Links {
        let sent = |message: &LinkMessage| message.t_sent_s;
        if !self.links.messages.is_sorted_by_key(sent) && self.links.unknown.is_empty() {
            let messages = &mut self.links.messages;
            messages.sort_by(|a, b| a.t_sent_s.total_cmp(&b.t_sent_s));
        }
        self.links
    }
}

/// Round trips being built.
#[derive(Debug, Default)]
pub(crate) struct RoundTripsBuilder(pub(crate) RoundTrips);

impl RoundTripsBuilder {
    pub(crate) fn new(unknown: &[String]) -> Self {
        Self(RoundTrips {
            unknown: empty_columns(unknown),
            ..RoundTrips::default()
        })
    }

    pub(crate) fn push_message(&mut self, data: &[u8]) -> Visited {
        let trip: ros::RoundTrip = decode(data).map_err(|_| Undecodable)?;
        self.0.seq.push(trip.seq);
        self.0.rtt_ms.push(finite_or_nan(trip.rtt_ms));
        Ok(())
    }

    pub(crate) fn push_row(&mut self, data: &[u8]) -> Visited {
        let row: ros::Row<Vec<f64>, Vec<String>> = decode(data).map_err(|_| Undecodable)?;
        let mut texts = row.texts.into_iter();
        let seq = texts.next().and_then(|text| text.parse().ok());
        let (Some(seq), &[rtt_ms]) = (seq, row.numbers.as_slice()) else {
            return Err(Undecodable);
        };
        if texts.len() != self.0.unknown.len() {
            return Err(Undecodable);
        }
        self.0.seq.push(seq);
        self.0.rtt_ms.push(finite_or_nan(rtt_ms));
        for (column, cell) in self.0.unknown.iter_mut().zip(texts) {
            column.cells.push(cell);
        }
        Ok(())
    }
}

fn empty_columns(names: &[String]) -> Vec<UnknownColumn> {
    let column = |name: &String| UnknownColumn {
        name: name.clone(),
        cells: Vec::new(),
    };
    names.iter().map(column).collect()
}
