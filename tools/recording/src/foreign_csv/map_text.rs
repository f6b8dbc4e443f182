//! A map of columns as text, which [`ColumnMap::parse`](super::ColumnMap::parse) reads.

use std::fmt::Write as _;

use super::entry::{Column, ColumnEntry, Source, StreamEntry, TimeEntry};
use crate::toml_files::quoted;

/// The table of a stream.
pub(super) fn table_text(stream: &StreamEntry) -> String {
    let mut text = format!("[robots.{}.{}]\n", stream.robot, stream.kind.name());
    let mut line = |key: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{key} = {value}");
    };
    if let Some(file) = &stream.file {
        line("file", quoted(file));
    }
    if let Some(separator) = stream.format.separator {
        line("separator", quoted(&char::from(separator).to_string()));
    }
    if let Some(has_header) = stream.format.has_header {
        line("header", has_header.to_string());
    }
    match &stream.time {
        TimeEntry::Column(column) => line("t_s", column_text(column)),
        TimeEntry::Parts([s, ns]) => {
            line("t_s", column_text(s));
            line("t_ns", column_text(ns));
        }
        TimeEntry::Period(period_s) => line("period_s", format!("{period_s:?}")),
        TimeEntry::File(name) => line("times", quoted(name)),
    }
    for (name, source) in &stream.columns {
        match source {
            Source::One(column) => line(name, column_text(column)),
            Source::Direction([x, y]) => {
                line("forward_x", column_text(x));
                line("forward_y", column_text(y));
            }
            Source::Quaternion([x, y], [z, w]) => {
                let parts = [
                    ("qx", x.as_ref()),
                    ("qy", y.as_ref()),
                    ("qz", Some(z)),
                    ("qw", Some(w)),
                ];
                for (key, part) in parts {
                    if let Some(part) = part {
                        line(key, column_text(part));
                    }
                }
            }
        }
    }
    text
}

fn column_text(entry: &ColumnEntry) -> String {
    let column = match &entry.column {
        Column::Name(name) => quoted(name),
        Column::Number(number) => number.to_string(),
    };
    let mut conversion = String::new();
    if entry.factor != 1.0 {
        let _ = write!(conversion, ", factor = {:?}", entry.factor);
    }
    if entry.offset != 0.0 {
        let _ = write!(conversion, ", offset = {:?}", entry.offset);
    }
    match conversion.as_str() {
        "" => column,
        conversion => format!("{{ column = {column}{conversion} }}"),
    }
}
