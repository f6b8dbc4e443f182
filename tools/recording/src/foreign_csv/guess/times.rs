//! Which column is the time, and its unit.

use super::columns::Columns;
use super::units::{Dimension, Unit, unit_after};
use crate::foreign_csv::entry::{ColumnEntry, TimeEntry};
use crate::foreign_csv::moment::{Moment, with_point};

/// Names of times, the likelier first; nothing stands for a unit alone.
const TIMES: &str = "time or zeit or timestamp or stamp or time stamp or t or elapsed or elapsed time or datetime or date time or ";
/// Words in names of times.
const WORDS: [&str; 5] = ["time", "timestamp", "stamp", "datetime", "ts"];
/// Words of seconds and of nanoseconds beside them.
const PARTS: [[&str; 2]; 5] = [
    ["secs", "nsecs"],
    ["sec", "nanosec"],
    ["sec", "nsec"],
    ["s", "ns"],
    ["seconds", "nanoseconds"],
];

/// The time of the rows of a file.
pub(super) fn of_file(columns: &Columns<'_>) -> Option<TimeEntry> {
    if let Some(parts) = parts(columns, |_| true) {
        return Some(parts);
    }
    let find = |wanted: &str| {
        let unit = |name: &Vec<String>| {
            // A name without words is no time, and `s` alone may be a length of the way.
            let is_name = !wanted.is_empty() || (!name.is_empty() && *name != ["s"]);
            is_name
                .then(|| unit_after(name, wanted, Dimension::Time))
                .flatten()
        };
        let mut units = columns.words.iter().map(unit).enumerate();
        units.find_map(|(index, unit)| column(columns, index, unit?))
    };
    // Any name with a word of time, whatever else it says.
    let others = || {
        let mut names = columns.words.iter().enumerate();
        names.find_map(|(index, name)| {
            let word = WORDS
                .iter()
                .find(|word| name.iter().any(|own| own == *word))?;
            let at = name.iter().position(|own| own == word)?;
            let unit = unit_after(name.get(at..)?, word, Dimension::Time);
            column(columns, index, unit.unwrap_or(Unit::NotSaid))
        })
    };
    let found = TIMES.split(" or ").find_map(find).or_else(others)?;
    Some(TimeEntry::Column(found))
}

/// The stamp of a message, in columns of which `is_own` is told the words before `header stamp`.
pub(super) fn of_message(
    columns: &Columns<'_>,
    is_own: impl Fn(&[String]) -> bool,
) -> Option<TimeEntry> {
    let is_stamp = |name: &[String]| match name {
        [prefix @ .., header, stamp] => header == "header" && stamp == "stamp" && is_own(prefix),
        _ => false,
    };
    if let Some(parts) = parts(columns, is_stamp) {
        return Some(parts);
    }
    let index = columns.words.iter().position(|name| is_stamp(name))?;
    let is_set = first_moment(columns, index)? != Moment::default();
    let column = column(columns, index, Unit::NotSaid)?;
    is_set.then_some(TimeEntry::Column(column))
}

/// Seconds and nanoseconds in two columns that are called alike before these words.
fn parts(columns: &Columns<'_>, is_own: impl Fn(&[String]) -> bool) -> Option<TimeEntry> {
    let is_set = |index: usize| first_moment(columns, index).is_some_and(|own| own.whole != 0);
    let names = columns.words.iter().enumerate();
    let mut pairs = names.filter_map(|(index, name)| {
        let (last, prefix) = name.split_last()?;
        let words = PARTS.iter().filter(|[s, _]| last == s);
        let mut partners = words.filter_map(|[_, ns]| {
            let is_it = |other: &Vec<String>| {
                let other = other.split_last();
                other.is_some_and(|(last, before)| last == ns && before == prefix)
            };
            columns.words.iter().position(is_it)
        });
        let partner = partners.next()?;
        (is_own(prefix) && is_set(index)).then_some([index, partner])
    });
    let pair = pairs.next()?;
    Some(TimeEntry::Parts(
        pair.map(|index| columns.entry(index, 1.0)),
    ))
}

/// The first time of a column in the sample; `None` if it has none.
fn first_moment(columns: &Columns<'_>, index: usize) -> Option<Moment> {
    columns.cells(index).find_map(|cell| Moment::parse(cell))
}

/// A column of times with its unit; `None` if it has no times.
fn column(columns: &Columns<'_>, index: usize, unit: Unit) -> Option<ColumnEntry> {
    let mut cells = columns.cells(index);
    let moments = moments(cells.clone());
    if moments.is_empty() {
        let is_date = |cell: &String| {
            Moment::parse_date(cell)
                .or_else(|| Moment::parse_time_of_day(cell))
                .is_some()
        };
        return cells.any(is_date).then(|| columns.entry(index, 1.0));
    }
    let factor = match unit {
        Unit::Said(factor) => factor,
        Unit::NotSaid => unit_s(&moments),
    };
    Some(columns.entry(index, factor))
}

/// The times in cells.
fn moments<'a>(cells: impl Iterator<Item = &'a String>) -> Vec<Moment> {
    let parse = |cell: &String| Moment::parse(cell).or_else(|| Moment::parse(&with_point(cell)));
    cells.filter_map(parse).collect()
}

/// The unit of times in cells (s).
pub(super) fn unit_of<'a>(cells: impl Iterator<Item = &'a String>) -> f64 {
    unit_s(&moments(cells))
}

/// The unit of times (s): by their size if they are whole numbers since 1970, or else by their steps if those are whole:
/// hardly a robot writes a row every 5 s.
fn unit_s(moments: &[Moment]) -> f64 {
    let first = moments.first().map_or(0, |own| own.whole.saturating_abs());
    match first {
        100_000_000_000_000_000.. => return 1e-9,
        100_000_000_000_000.. => return 1e-6,
        100_000_000_000.. => return 1e-3,
        _ => {}
    }
    let steps = moments.windows(2).filter_map(|pair| {
        let [before, after] = pair else { return None };
        Some(after.since(*before))
    });
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    if moments.iter().any(|own| own.rest != 0.0) {
        return 1.0;
    }
    match step {
        ..5.0 => 1.0,
        ..2000.0 => 1e-3,
        ..2_000_000.0 => 1e-6,
        _ => 1e-9,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_steps_tell_units() {
        let unit = |times: &[&str]| {
            let moments = times.iter().filter_map(|time| Moment::parse(time));
            unit_s(&moments.collect::<Vec<_>>())
        };
        assert_eq!(unit(&["1700000000500000000"]), 1e-9);
        assert_eq!(unit(&["1700000000500000"]), 1e-6);
        assert_eq!(unit(&["1700000000500"]), 1e-3);
        assert_eq!(unit(&["1700000000.5", "1700000000.6"]), 1.0);
        assert_eq!(unit(&["0", "20", "40"]), 1e-3);
        assert_eq!(unit(&["0", "20000", "40000"]), 1e-6);
        assert_eq!(unit(&["0", "1", "2"]), 1.0);
        assert_eq!(unit(&["0.5", "20.5", "40.5"]), 1.0);
    }
}
