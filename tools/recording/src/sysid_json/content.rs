//! What a log of SysId has.
//!
//! ```json
//! {"slow-forward": [[12.5, 0.1, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]], "fast-forward": [],
//!  "sysid": true, "test": "Drivetrain", "units": "Meters", "unitsPerRotation": 0.478}
//! ```
//!
//! A row has time (s); voltages, positions (rotations) and speeds (rotations/s) of the left and the right side; angle
//! (rad) and rate (rad/s) of the gyro. Rows of frc-characterization, which came before SysId, have ten numbers: battery
//! and speed stand after the time, and there is no rate.

use std::path::Path;

use serde_json::{Map, Value};
use slipstream_bus::InputError;

/// Largest log that is read (bytes). A test of a minute has a few hundred kilobytes.
const MAX_BYTES: u64 = 64 << 20;

/// A log.
pub(super) struct Log {
    /// The runs by name, in the order of their names.
    pub(super) runs: Vec<(String, Vec<Row>)>,
    /// Size of a rotation of a wheel in `units`.
    pub(super) units_per_rotation: f64,
    /// Name of a unit.
    pub(super) units: String,
}

/// A row of a run. Pairs are [right, left].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    pub(super) t_s: f64,
    pub(super) voltage_v: [f64; 2],
    /// Rotations of the wheels.
    pub(super) rotations: [f64; 2],
    /// Rate of the gyro (rad/s); NaN in old logs.
    pub(super) rate_rad_s: f64,
}

/// Whether a text begins like JSON.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn is_json(path: &Path) -> Result<bool, InputError> {
    let unreadable = |e| InputError::unreadable(path, &e);
    let mut file = std::fs::File::open(path).map_err(unreadable)?;
    let mut head = [0; 256];
    let read = std::io::Read::read(&mut file, &mut head).map_err(unreadable)?;
    let head = head.get(..read).unwrap_or_default().trim_ascii_start();
    Ok(head.starts_with(b"{"))
}

impl Log {
    /// Reads a log.
    ///
    /// # Errors
    /// If the file cannot be read, is no log of a drivetrain, or a row is not as it should be.
    pub(super) fn read(path: &Path) -> Result<Self, InputError> {
        let remedy = "give a log of SysId, or a CSV file";
        let size = std::fs::metadata(path).map_err(|e| InputError::unreadable(path, &e))?;
        if size.len() > MAX_BYTES {
            let problem = format!(
                "is JSON of {} bytes, too many for a log of SysId",
                size.len()
            );
            return Err(InputError::file(path, problem, remedy));
        }
        let text = std::fs::read(path).map_err(|e| InputError::unreadable(path, &e))?;
        let content: Map<String, Value> = serde_json::from_slice(&text).map_err(|error| {
            let line = error.line() as u64;
            InputError::file(path, format!("is not JSON: {error}"), remedy).at(line)
        })?;
        let text_of = |key: &str| content.get(key).and_then(Value::as_str);
        let per_rotation = content.get("unitsPerRotation").and_then(Value::as_f64);
        let (Some(test), Some(units), Some(units_per_rotation)) =
            (text_of("test"), text_of("units"), per_rotation)
        else {
            let problem = "is JSON, but no log of SysId: it lacks test, units or unitsPerRotation";
            return Err(InputError::file(path, problem, remedy));
        };
        if !test.starts_with("Drive") {
            let problem = format!("is of the mechanism {test:?}, which has no two sides");
            return Err(InputError::file(
                path,
                problem,
                "give a log of a drivetrain",
            ));
        }
        let mut runs = Vec::new();
        for (name, rows) in &content {
            if let Value::Array(rows) = rows {
                runs.push((name.clone(), run(path, name, rows)?));
            }
        }
        runs.sort_by(|(a, _), (b, _)| a.cmp(b));
        Ok(Self {
            runs,
            units_per_rotation,
            units: units.to_owned(),
        })
    }
}

fn run(path: &Path, name: &str, rows: &[Value]) -> Result<Vec<Row>, InputError> {
    let rows = rows.iter().enumerate().map(|(index, row)| {
        let cells = row.as_array().map(Vec::as_slice).unwrap_or_default();
        let cells: Option<Vec<f64>> = cells.iter().map(Value::as_f64).collect();
        cells.as_deref().and_then(Row::of).ok_or_else(|| {
            let problem = format!("row {} of {name:?} is not a row of nine numbers", index + 1);
            InputError::file(path, problem, "correct the row, or delete it")
        })
    });
    rows.collect()
}

impl Row {
    /// A row by its numbers; `None` if there are too few or too many.
    fn of(cells: &[f64]) -> Option<Self> {
        let (t_s, left_v, right_v, left, right, rate_rad_s) = match *cells {
            [t_s, left_v, right_v, left, right, _, _, _, rate_rad_s] => {
                (t_s, left_v, right_v, left, right, rate_rad_s)
            }
            [t_s, _, _, left_v, right_v, left, right, _, _, _] => {
                (t_s, left_v, right_v, left, right, f64::NAN)
            }
            _ => return None,
        };
        Some(Self {
            t_s,
            voltage_v: [right_v, left_v],
            rotations: [right, left],
            rate_rad_s,
        })
    }
}
