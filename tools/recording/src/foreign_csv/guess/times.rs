//! Which column is the time, and its unit.

use super::guessed::entry;
use super::units::{Dimension, Unit, unit_after, words};
use crate::foreign_csv::entry::{ColumnEntry, TimeEntry};
use crate::foreign_csv::layout::Sample;
use crate::foreign_csv::moment::Moment;

/// Names of times, the likelier first; nothing stands for a unit alone.
const TIMES: &str = "t or time or timestamp or stamp or time stamp or elapsed or elapsed time or time elapsed or datetime or date time or ";
/// Words of seconds and of nanoseconds beside them.
const PARTS: [[&str; 2]; 5] = [
    ["secs", "nsecs"],
    ["sec", "nanosec"],
    ["sec", "nsec"],
    ["s", "ns"],
    ["seconds", "nanoseconds"],
];

/// The time of the rows of a file.
pub(super) fn of_file(sample: &Sample) -> Option<TimeEntry> {
    let names: Vec<Vec<String>> = sample.layout.names.iter().map(|name| words(name)).collect();
    if let Some(parts) = parts(sample, &names, |_| true) {
        return Some(parts);
    }
    let find = |wanted: &str| {
        let unit = |name: &Vec<String>| unit_after(name, wanted, Dimension::Time);
        let mut units = names.iter().map(unit).enumerate();
        units.find_map(|(index, unit)| Some((index, unit?)))
    };
    let begins = |name: &Vec<String>| name.first().is_some_and(|word| word == "time");
    let by_beginning = || Some((names.iter().position(begins)?, Unit::NotSaid));
    let (index, unit) = TIMES.split(" or ").find_map(find).or_else(by_beginning)?;
    Some(TimeEntry::Column(column(sample, index, unit)?))
}

/// The stamp of a message, in columns of which `is_own` is told the words before `header stamp`.
pub(super) fn of_message(sample: &Sample, is_own: impl Fn(&[String]) -> bool) -> Option<TimeEntry> {
    let names: Vec<Vec<String>> = sample.layout.names.iter().map(|name| words(name)).collect();
    let is_stamp = |name: &[String]| match name {
        [prefix @ .., header, stamp] => header == "header" && stamp == "stamp" && is_own(prefix),
        _ => false,
    };
    if let Some(parts) = parts(sample, &names, is_stamp) {
        return Some(parts);
    }
    let index = names.iter().position(|name| is_stamp(name))?;
    let is_set = first_moment(sample, index)? != Moment::default();
    let column = column(sample, index, Unit::NotSaid)?;
    is_set.then_some(TimeEntry::Column(column))
}

/// Seconds and nanoseconds in two columns that are called alike before these words.
fn parts(
    sample: &Sample,
    names: &[Vec<String>],
    is_own: impl Fn(&[String]) -> bool,
) -> Option<TimeEntry> {
    let is_set = |index: usize| first_moment(sample, index).is_some_and(|own| own.whole != 0);
    let columns = names.iter().enumerate();
    let mut pairs = columns.filter_map(|(index, name)| {
        let (last, prefix) = name.split_last()?;
        let words = PARTS.iter().filter(|[s, _]| last == s);
        let mut partners = words.filter_map(|[_, ns]| {
            let is_it = |other: &Vec<String>| {
                let other = other.split_last();
                other.is_some_and(|(last, before)| last == ns && before == prefix)
            };
            names.iter().position(is_it)
        });
        let partner = partners.next()?;
        (is_own(prefix) && is_set(index)).then_some([index, partner])
    });
    let pair = pairs.next()?;
    Some(TimeEntry::Parts(
        pair.map(|index| entry(sample, index, 1.0)),
    ))
}

/// The first time of a column in the sample; `None` if it has none.
fn first_moment(sample: &Sample, index: usize) -> Option<Moment> {
    let mut cells = sample.rows.iter().filter_map(|row| row.get(index));
    cells.find_map(|cell| Moment::parse(cell))
}

/// A column of times with its unit; `None` if it has no times.
fn column(sample: &Sample, index: usize, unit: Unit) -> Option<ColumnEntry> {
    let cells = sample.rows.iter().filter_map(|row| row.get(index));
    let is_date = |cell: &String| {
        Moment::parse_date(cell)
            .or_else(|| Moment::parse_time_of_day(cell))
            .is_some()
    };
    let moments: Vec<Moment> = cells
        .clone()
        .filter_map(|cell| Moment::parse(cell))
        .collect();
    if moments.is_empty() {
        let is_dates = cells.clone().any(is_date);
        return is_dates.then(|| entry(sample, index, 1.0));
    }
    let factor = match unit {
        Unit::Said(factor) => factor,
        Unit::NotSaid => unit_s(&moments),
    };
    Some(entry(sample, index, factor))
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
