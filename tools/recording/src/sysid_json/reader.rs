//! Reader of logs of SysId: each run is a robot folder of one machine.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use slipstream_bag::Result;
use slipstream_bus::InputError;

use super::content::{Log, Row};
use crate::import::Spooled;
use crate::recording::{Recording, is_robot_name};
use crate::rows::{Disk, Spool, SpooledRecording, sorted_by_time};
use crate::table::{StreamKind, Table, is_time, out_of_range};

/// Names of lengths in SysId, and their sizes (m).
const LENGTHS: [(&str, f64); 3] = [("Meters", 1.0), ("Feet", 0.3048), ("Inches", 0.0254)];

/// Columns of a stream, and their values in a row.
type StreamColumns<'a> = (&'a [&'static str], fn(&Row) -> Vec<f64>);

const STREAMS: [(StreamKind, StreamColumns<'static>); 3] = [
    (
        StreamKind::Command,
        (&["voltage_right_v", "voltage_left_v"], |row| {
            row.voltage_v.to_vec()
        }),
    ),
    (
        StreamKind::Wheels,
        (&["angle_right_rad", "angle_left_rad"], |row| {
            row.rotations.map(|rotations| rotations * TAU).to_vec()
        }),
    ),
    (StreamKind::Imu, (&["gz_rad_s"], |row| vec![row.rate_rad_s])),
];

/// Reads a log: voltages as commands, positions as angles of the wheels, the rate of the gyro.
///
/// # Errors
/// If the file cannot be read, is no log of a drivetrain, or has no run with rows.
pub(crate) fn read_sysid(path: &Path) -> Result<Spooled> {
    let log = Log::read(path)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy());
    let description = Recording {
        name: name.unwrap_or_default().into_owned(),
        origin: "a log of SysId".to_owned(),
        same_robot: true,
        ..Recording::default()
    };
    let disk = Disk::default();
    let mut recording = SpooledRecording::new(description, disk.clone());
    let shown = path.display();
    let mut warnings = Vec::new();
    for (run, rows) in &log.runs {
        if rows.is_empty() || !is_robot_name(run) {
            let reason = if rows.is_empty() {
                "it has no rows"
            } else {
                "its name is no name of a robot"
            };
            warnings.push(format!("{shown}: run {run}: left out, since {reason}"));
            continue;
        }
        for (kind, columns) in STREAMS {
            // A robot without gyro, and an old log.
            let has_gyro = rows
                .iter()
                .any(|row| row.rate_rad_s.is_finite() && row.rate_rad_s != 0.0);
            if kind == StreamKind::Imu && !has_gyro {
                warnings.push(format!("{shown}: run {run}: no rate of a gyro"));
                continue;
            }
            let spool = stream(path, run, rows, columns, &disk)?;
            if !spool.is_sorted() {
                warnings.push(format!(
                    "{shown}: run {run}: times run backwards; sorted by time"
                ));
            }
            recording.store(run, kind, sorted_by_time(spool));
        }
    }
    recording.disk.check()?;
    if recording.description.robots.is_empty() {
        let problem = "has no run with rows";
        return Err(InputError::file(path, problem, "give a log with its runs").into());
    }
    Ok(Spooled {
        recording,
        guesses: vec![format!(
            "{shown}: positions are taken for rotations of the wheels; their speeds and the angle of the gyro are not used"
        )],
        warnings,
        on_model: on_radius(&log).into_iter().collect(),
        loss: None,
        left_out: BTreeMap::new(),
    })
}

fn stream(
    path: &Path,
    run: &str,
    rows: &[Row],
    (names, values): StreamColumns<'_>,
    disk: &Disk,
) -> Result<Spool> {
    let mut spool = Spool::new(disk, Table::new(names, Vec::new()));
    for row in rows {
        let refuse = |name: &str, value: f64, remedy: &str| {
            let problem = format!("run {run} has {name} = {value}");
            InputError::file(path, problem, remedy)
        };
        if !is_time(row.t_s) {
            return Err(refuse("a time", row.t_s, "give seconds").into());
        }
        let values = values(row);
        for (name, value) in names.iter().zip(&values) {
            if let Some(remedy) = out_of_range(name, *value) {
                return Err(refuse(name, *value, remedy).into());
            }
        }
        spool.push_numbers(row.t_s, values);
    }
    Ok(spool)
}

/// What the log says of the wheels.
fn on_radius(log: &Log) -> Option<String> {
    let (units, per_rotation) = (&log.units, log.units_per_rotation);
    let (_, length_m) = LENGTHS.iter().find(|(name, _)| name == units)?;
    let radius_m = per_rotation * length_m / TAU;
    let warning = match per_rotation == 1.0 {
        false => "",
        true => {
            "; where positions are lengths and not rotations, this is no radius, but fits all the same"
        }
    };
    Some(format!(
        "a rotation of a wheel is {per_rotation} {units}: wheel_radius_m = {radius_m}{warning}"
    ))
}
