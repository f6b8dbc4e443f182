//! The time of each row of a file.

use slipstream_bus::InputError;

use super::entry::TimeEntry;
use super::moment::{DAY_S, Moment, with_point};
use super::table::{Cell, ForeignCsv};
use super::times_file::TimesFile;

/// Gives the time of each row, in the unit of the file.
pub(super) struct Clock {
    source: ClockSource,
    /// Rows before this one.
    rows: i64,
    /// The last time of day, and how often midnight passed.
    last_of_day: Option<Moment>,
    midnights: i64,
}

enum ClockSource {
    /// Numbers; dates only where there is no factor, since they are in seconds.
    Column {
        cell: Cell,
        may_be_date: bool,
    },
    Parts([Cell; 2]),
    Period,
    File(TimesFile),
}

/// What converts the unit of a file: (seconds, offset in seconds).
pub(super) fn unit_of(time: &TimeEntry) -> (f64, f64) {
    match time {
        TimeEntry::Column(column) => (column.factor, column.offset),
        TimeEntry::Parts(_) | TimeEntry::File(_) => (1.0, 0.0),
        TimeEntry::Period(period_s) => (*period_s, 0.0),
    }
}

impl Clock {
    /// The clock of a file.
    ///
    /// # Errors
    /// If the file has no such column.
    pub(super) fn new(csv: &ForeignCsv<'_>, time: &TimeEntry) -> Result<Self, InputError> {
        let source = match time {
            TimeEntry::Column(column) => ClockSource::Column {
                cell: csv.find(column)?,
                may_be_date: column.factor == 1.0,
            },
            TimeEntry::Parts([s, ns]) => ClockSource::Parts([csv.find(s)?, csv.find(ns)?]),
            TimeEntry::Period(_) => ClockSource::Period,
            TimeEntry::File(name) => ClockSource::File(TimesFile::beside(csv.path, name)?),
        };
        Ok(Self {
            source,
            rows: 0,
            last_of_day: None,
            midnights: 0,
        })
    }

    /// The time of the current row; `None` if its cell is empty. To be called once for each row.
    ///
    /// # Errors
    /// If it is no time.
    pub(super) fn moment(&mut self, csv: &ForeignCsv<'_>) -> Result<Option<Moment>, InputError> {
        let row = self.rows;
        self.rows += 1;
        let (cell, may_be_date) = match &mut self.source {
            ClockSource::File(times) => return times.next(),
            ClockSource::Period => {
                return Ok(Some(Moment {
                    whole: row,
                    rest: 0.0,
                }));
            }
            ClockSource::Parts([s, ns]) => return of_parts(csv, *s, *ns),
            ClockSource::Column { cell, may_be_date } => (*cell, *may_be_date),
        };
        let Some(text) = csv.text(cell.index)? else {
            return Ok(None);
        };
        let number = Moment::parse(text).or_else(|| Moment::parse(&with_point(text)));
        let moment = number.or_else(|| may_be_date.then(|| self.date(text)).flatten());
        let moment = moment.ok_or_else(|| csv.not_a_number(cell.index, text))?;
        Ok(Some(moment))
    }

    /// A date and time, or a time of day, in seconds. After midnight, times of day go on.
    fn date(&mut self, text: &str) -> Option<Moment> {
        if let Some(moment) = Moment::parse_date(text) {
            return Some(moment);
        }
        let of_day = Moment::parse_time_of_day(text)?;
        let jumps_back = |last: Moment| of_day.since(last) < -0.5 * DAY_S as f64;
        if self.last_of_day.is_some_and(jumps_back) {
            self.midnights += 1;
        }
        self.last_of_day = Some(of_day);
        Some(Moment {
            whole: of_day.whole + self.midnights * DAY_S,
            ..of_day
        })
    }
}

/// Seconds in one cell, nanoseconds in another one.
fn of_parts(csv: &ForeignCsv<'_>, s: Cell, ns: Cell) -> Result<Option<Moment>, InputError> {
    let Some(text) = csv.text(s.index)? else {
        return Ok(None);
    };
    let moment = Moment::parse(text).ok_or_else(|| csv.not_a_number(s.index, text))?;
    let ns = csv.number(ns)?;
    let rest = moment.rest + ns * 1e-9;
    Ok(ns.is_finite().then_some(Moment { rest, ..moment }))
}
