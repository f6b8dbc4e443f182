//! Measured round-trip times (rtt.csv), replayed as link delays.

use std::path::Path;

use slipstream_bus::InputError;
use slipstream_bus::range::{DELAY_S, within};
use slipstream_bus::time::ns_from_s;

/// Reads an rtt.csv: half of each round-trip time (ns), `None` for a lost message (empty cell).
///
/// # Errors
/// A file that cannot be read, has no column `rtt_ms`, no rows, or an invalid value.
pub(crate) fn read(path: &Path) -> Result<Vec<Option<i64>>, InputError> {
    let unreadable = |error: csv::Error| {
        let remedy = "give a CSV file with the columns seq and rtt_ms";
        InputError {
            line: error.position().map(csv::Position::line),
            ..InputError::file(path, error.to_string(), remedy)
        }
    };
    let mut reader = csv::Reader::from_path(path).map_err(unreadable)?;
    let head = reader.headers().map_err(unreadable)?;
    let column = head
        .iter()
        .position(|name| name.trim() == "rtt_ms")
        .ok_or_else(|| {
            InputError::file(path, "has no column rtt_ms", "name the column rtt_ms").at(1)
        })?;
    let mut rows = Vec::new();
    for row in reader.records() {
        let row = row.map_err(unreadable)?;
        let cell = row.get(column).unwrap_or_default().trim();
        let half = match cell {
            "" => None,
            cell => match cell.parse::<f64>() {
                Ok(rtt_ms) if within("rtt_ms", rtt_ms / 2e3, DELAY_S).is_ok() => {
                    Some(ns_from_s(rtt_ms / 2e3))
                }
                _ => {
                    let line = row.position().map_or(0, csv::Position::line);
                    let remedy = "give milliseconds, 0 to 2e7; leave the cell empty for a lost \
                                  message";
                    return Err(
                        InputError::file(path, format!("rtt_ms is {cell}"), remedy).at(line)
                    );
                }
            },
        };
        rows.push(half);
    }
    if rows.is_empty() {
        return Err(InputError::file(
            path,
            "has no rows",
            "give at least one measured round trip",
        ));
    }
    Ok(rows)
}
