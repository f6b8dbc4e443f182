//! CSV folders in: every stream as it is written, errors with file and line.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::rows::CsvFile;
use crate::error::{Result, Unusable};
use crate::import::Import;
use crate::recording::{LinkMessage, Links, Names, Recording, Robot, RoundTrips};
use crate::table::{Cells, ColumnSet, LINK_COLUMNS, StreamKind, Table};
use crate::toml_files::{read_text, recording_toml, robot_toml};

/// Reads a folder of CSV files.
///
/// # Errors
/// The first thing that is not as the format wants it, with file and line.
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

fn sorted_entries(folder: &Path) -> std::result::Result<Vec<PathBuf>, Unusable> {
    let unreadable = |e| Unusable::unreadable(folder, &e);
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        paths.push(entry.map_err(unreadable)?.path());
    }
    paths.sort();
    Ok(paths)
}

/// One entry of the recording's folder: a robot's folder or a file of the whole recording.
fn read_entry(path: &Path, recording: &mut Recording, warnings: &mut Vec<String>) -> Result<()> {
    let name = file_name(path);
    match name.as_str() {
        "recording.toml" | "robot.toml" => {}
        "links.csv" => recording.links = Some(read_links(path, warnings)?),
        "rtt.csv" => recording.rtt = Some(read_rtt(path, warnings)?),
        _ if path.is_dir() => {
            let Some(robot) = robot_of_folder(path, &name, recording, warnings) else {
                return Ok(());
            };
            for file in sorted_entries(path)? {
                read_stream(&file, robot, warnings)?;
            }
        }
        _ => warnings.push(format!(
            "{}: no file of the format; ignored",
            path.display()
        )),
    }
    Ok(())
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy());
    name.unwrap_or_default().into_owned()
}

/// The robot whose folder this is. A folder without a table counts if it holds a stream.
fn robot_of_folder<'a>(
    path: &Path,
    name: &str,
    recording: &'a mut Recording,
    warnings: &mut Vec<String>,
) -> Option<&'a mut Robot> {
    if let Some(at) = recording.robots.iter().position(|r| r.name == name) {
        return recording.robots.get_mut(at);
    }
    let has_stream = |kind: &StreamKind| path.join(format!("{}.csv", kind.name())).exists();
    let is_robot = StreamKind::ALL.iter().any(has_stream);
    if !is_robot || !crate::recording::is_robot_name(name) {
        warnings.push(format!("{}: no robot's folder; ignored", path.display()));
        return None;
    }
    warnings.push(format!(
        "{}: recording.toml has no [robots.{name}]; taken as a robot of which nothing is known",
        path.display()
    ));
    recording.robots.push(Robot::named(name));
    recording.robots.last_mut()
}

fn read_stream(path: &Path, robot: &mut Robot, warnings: &mut Vec<String>) -> Result<()> {
    let name = file_name(path);
    let Some(kind) = name.strip_suffix(".csv").and_then(StreamKind::from_name) else {
        warnings.push(format!(
            "{}: no file of the format; ignored",
            path.display()
        ));
        return Ok(());
    };
    let mut file = CsvFile::open(path)?;
    file.expect_first("t_s")?;
    let known: Vec<Option<&'static str>> = file.heads[1..].iter().map(|h| kind.column(h)).collect();
    let present: Vec<&'static str> = known.iter().copied().flatten().collect();
    ColumnSet::choose(kind, &present)
        .map_err(|(problem, remedy)| Unusable::new(path, problem, remedy).at(1))?;
    file.warn_of_unknown(1, &known, warnings);

    let mut table = Table::default();
    let mut columns: Vec<(&'static str, Cells)> = present
        .iter()
        .map(|name| (*name, Cells::of(name)))
        .collect();
    let mut unknown = file.unknown_columns(1, &known);
    while file.next()? {
        let t_s = file.time(0, table.t_s.last().copied())?;
        table.t_s.push(t_s);
        let (mut at_known, mut at_unknown) = (columns.iter_mut(), unknown.iter_mut());
        for (i, column) in known.iter().enumerate() {
            match column {
                Some(_) => match at_known.next() {
                    Some((_, Cells::Numbers(cells))) => cells.push(file.number_or_nan(i + 1)?),
                    Some((_, Cells::Counts(cells))) => cells.push(file.count(i + 1)?),
                    None => {}
                },
                None => {
                    if let Some(column) = at_unknown.next() {
                        column.cells.push(file.text(i + 1)?.to_owned());
                    }
                }
            }
        }
    }
    table.columns = columns;
    table.unknown = unknown;
    table.give_to(robot, kind);
    Ok(())
}

fn read_links(path: &Path, warnings: &mut Vec<String>) -> Result<Links> {
    let mut file = CsvFile::open(path)?;
    file.expect_first("t_sent_s")?;
    let [.., v, w] = file.find(&LINK_COLUMNS);
    for (head, at) in LINK_COLUMNS.iter().zip(file.find(&LINK_COLUMNS)).take(7) {
        if at.is_none() {
            return Err(file.head_error(&format!("column {head} is missing")).into());
        }
    }
    if v.is_some() != w.is_some() {
        return Err(file.head_error("only one of v_m_s, w_rad_s").into());
    }
    let known = file.known(&LINK_COLUMNS);
    file.warn_of_unknown(0, &known, warnings);
    let mut links = Links {
        with_velocity: v.is_some(),
        unknown: file.unknown_columns(0, &known),
        ..Links::default()
    };
    let mut names = Names::default();
    let [sent, received, from, to, x, y, yaw, ..] =
        file.find(&LINK_COLUMNS).map(Option::unwrap_or_default);
    while file.next()? {
        let before = links.messages.last().map(|message| message.t_sent_s);
        let velocity = |at: Option<usize>| at.map_or(Ok(f64::NAN), |at| file.number_or_nan(at));
        let message = LinkMessage {
            t_sent_s: file.time(sent, before)?,
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

const RTT_HEADS: [&str; 2] = ["seq", "rtt_ms"];

fn read_rtt(path: &Path, warnings: &mut Vec<String>) -> Result<RoundTrips> {
    let mut file = CsvFile::open(path)?;
    let [Some(seq), Some(rtt)] = file.find(&RTT_HEADS) else {
        return Err(file.head_error("not both of seq, rtt_ms").into());
    };
    let known = file.known(&RTT_HEADS);
    file.warn_of_unknown(0, &known, warnings);
    let mut trips = RoundTrips {
        unknown: file.unknown_columns(0, &known),
        ..RoundTrips::default()
    };
    while file.next()? {
        let Some(seq) = file.count(seq)? else {
            return Err(file.error("seq is empty", "number the round trips").into());
        };
        trips.seq.push(seq);
        trips.rtt_ms.push(file.number_or_nan(rtt)?);
        file.keep_unknown(0, &known, &mut trips.unknown)?;
    }
    Ok(trips)
}
