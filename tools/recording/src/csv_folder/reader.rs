//! Reader of a folder of CSV files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

use super::csv_file::CsvFile;
use crate::error::Result;
use crate::import::Import;
use crate::recording::{
    LinkMessage, Links, NamePool, Recording, Robot, RoundTrips, UnknownColumn, is_robot_name,
};
use crate::table::{
    Cells, ColumnSet, LINK_COLUMNS, LINK_POSE_COLUMNS, ROUND_TRIP_COLUMNS, StreamKind, Table,
};
use crate::toml_files::{read_text, recording_toml, robot_toml};

/// Reads a folder of CSV files with `recording.toml`.
///
/// # Errors
/// The first violation of the format, with file and line; or a file that cannot be read.
pub fn read_folder(folder: &Path) -> Result<Import> {
    let path = folder.join("recording.toml");
    let name = folder.file_name().map(|name| name.to_string_lossy());
    let text = read_text(&path)?;
    let mut recording = recording_toml::parse(&text, &path, &name.unwrap_or_default())?;
    let mut warnings = Vec::new();
    let model = folder.join("robot.toml");
    if model.exists() {
        recording.model = Some(robot_toml::read(&model)?);
    }
    for entry in sorted_entries(folder)? {
        read_entry(&entry, &mut recording, &mut warnings)?;
    }
    Ok(Import {
        recording,
        warnings,
        loss: None,
        left_out: BTreeMap::new(),
    })
}

fn sorted_entries(folder: &Path) -> std::result::Result<Vec<PathBuf>, InputError> {
    let unreadable = |e| InputError::unreadable(folder, &e);
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        paths.push(entry.map_err(unreadable)?.path());
    }
    paths.sort();
    Ok(paths)
}

/// Reads one entry of the recording's folder: a robot's folder, or a file that belongs to no robot.
fn read_entry(path: &Path, recording: &mut Recording, warnings: &mut Vec<String>) -> Result<()> {
    let name = file_name(path);
    match name.as_str() {
        "recording.toml" | "robot.toml" => {}
        "links.csv" => recording.links = Some(read_links(path, warnings)?),
        "rtt.csv" => recording.rtt = Some(read_round_trips(path, warnings)?),
        _ if path.is_dir() => {
            let Some(robot) = robot_of_folder(path, &name, recording, warnings) else {
                return Ok(());
            };
            for file in sorted_entries(path)? {
                read_stream(&file, robot, warnings)?;
            }
        }
        _ => warnings.push(not_in_format(path)),
    }
    Ok(())
}

fn not_in_format(path: &Path) -> String {
    format!("{}: is not a file of the format; ignored", path.display())
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy());
    name.unwrap_or_default().into_owned()
}

/// The robot whose folder this is. A folder without a table in `recording.toml` is a robot's if it
/// contains a stream.
fn robot_of_folder<'a>(
    path: &Path,
    name: &str,
    recording: &'a mut Recording,
    warnings: &mut Vec<String>,
) -> Option<&'a mut Robot> {
    if let Some(index) = recording.robots.iter().position(|r| r.name == name) {
        return recording.robots.get_mut(index);
    }
    let has_stream = |kind: &StreamKind| path.join(format!("{}.csv", kind.name())).exists();
    let is_robot = StreamKind::ALL.iter().any(has_stream);
    if !is_robot || !is_robot_name(name) {
        warnings.push(format!(
            "{}: is not a robot's folder; ignored",
            path.display()
        ));
        return None;
    }
    warnings.push(format!(
        "{}: recording.toml has no [robots.{name}]; read as a robot without description",
        path.display()
    ));
    recording.robots.push(Robot::named(name));
    recording.robots.last_mut()
}

/// Reads one file of a robot's folder.
fn read_stream(path: &Path, robot: &mut Robot, warnings: &mut Vec<String>) -> Result<()> {
    let name = file_name(path);
    let Some(kind) = name.strip_suffix(".csv").and_then(StreamKind::from_name) else {
        warnings.push(not_in_format(path));
        return Ok(());
    };
    let mut file = CsvFile::open(path)?;
    file.expect_first("t_s")?;
    let known: Vec<Option<&'static str>> =
        file.header[1..].iter().map(|c| kind.column(c)).collect();
    let present: Vec<&'static str> = known.iter().copied().flatten().collect();
    ColumnSet::choose(kind, &present)
        .map_err(|(problem, remedy)| InputError::file(path, problem, remedy).at(1))?;
    file.warn_of_unknown(1, &known, warnings);

    let mut table = Table::new(&present, file.unknown_columns(1, &known));
    while file.next_row()? {
        let t_s = file.time(0, table.t_s.last().copied())?;
        table.t_s.push(t_s);
        push_cells(&file, &known, &mut table.columns, &mut table.unknown)?;
    }
    table.store_in(robot, kind);
    Ok(())
}

/// Appends the cells of the current row after its time.
fn push_cells(
    file: &CsvFile<'_>,
    known: &[Option<&str>],
    columns: &mut [(&str, Cells)],
    unknown: &mut [UnknownColumn],
) -> Result<()> {
    let (mut columns, mut unknown) = (columns.iter_mut(), unknown.iter_mut());
    for (i, name) in known.iter().enumerate() {
        match name {
            Some(_) => match columns.next() {
                Some((_, Cells::Numbers(cells))) => cells.push(file.number_or_nan(i + 1)?),
                Some((_, Cells::Counts(cells))) => cells.push(file.count(i + 1)?),
                None => {}
            },
            None => {
                if let Some(column) = unknown.next() {
                    column.cells.push(file.text(i + 1)?.to_owned());
                }
            }
        }
    }
    Ok(())
}

fn read_links(path: &Path, warnings: &mut Vec<String>) -> Result<Links> {
    let mut file = CsvFile::open(path)?;
    file.expect_first(LINK_COLUMNS[0])?;
    let indices = file.find(&LINK_COLUMNS);
    for (name, index) in LINK_COLUMNS.iter().zip(indices).take(LINK_POSE_COLUMNS) {
        if index.is_none() {
            return Err(file
                .header_error(&format!("column {name} is missing"))
                .into());
        }
    }
    let [.., v, w] = indices;
    if v.is_some() != w.is_some() {
        return Err(file.header_error("only one of v_m_s, w_rad_s").into());
    }
    let known = file.known(&LINK_COLUMNS);
    file.warn_of_unknown(0, &known, warnings);
    let mut links = Links {
        with_velocity: v.is_some(),
        unknown: file.unknown_columns(0, &known),
        ..Links::default()
    };
    let mut names = NamePool::default();
    let [sent, received, from, to, x, y, yaw, ..] = indices.map(Option::unwrap_or_default);
    while file.next_row()? {
        let previous = links.messages.last().map(|message| message.t_sent_s);
        let velocity = |index: Option<usize>| index.map_or(Ok(f64::NAN), |i| file.number_or_nan(i));
        let message = LinkMessage {
            t_sent_s: file.time(sent, previous)?,
            t_received_s: Some(file.number_or_nan(received)?).filter(|t| !t.is_nan()),
            from: file.name(from, &mut names)?,
            to: file.name(to, &mut names)?,
            x_m: file.number_or_nan(x)?,
            y_m: file.number_or_nan(y)?,
            yaw_rad: file.number_or_nan(yaw)?,
            v_m_s: velocity(v)?,
            w_rad_s: velocity(w)?,
        };
        links.messages.push(message);
        file.keep_unknown(0, &known, &mut links.unknown)?;
    }
    Ok(links)
}

fn read_round_trips(path: &Path, warnings: &mut Vec<String>) -> Result<RoundTrips> {
    let mut file = CsvFile::open(path)?;
    let [Some(seq), Some(rtt)] = file.find(&ROUND_TRIP_COLUMNS) else {
        return Err(file.header_error("seq or rtt_ms is missing").into());
    };
    let known = file.known(&ROUND_TRIP_COLUMNS);
    file.warn_of_unknown(0, &known, warnings);
    let mut trips = RoundTrips {
        unknown: file.unknown_columns(0, &known),
        ..RoundTrips::default()
    };
    while file.next_row()? {
        let Some(seq) = file.count(seq)? else {
            return Err(file
                .row_error("seq is empty", "number the round trips")
                .into());
        };
        trips.seq.push(seq);
        trips.rtt_ms.push(file.number_or_nan(rtt)?);
        file.keep_unknown(0, &known, &mut trips.unknown)?;
    }
    Ok(trips)
}
