//! Reader of a folder of CSV files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use slipstream_bag::{Result, read_text};
use slipstream_bus::InputError;

use super::csv_file::CsvFile;
use crate::import::{Import, Spooled};
use crate::recording::{ReadFrom, Recording, Robot, is_robot_name};
use crate::rows::{Disk, Spool, SpooledRecording};
use crate::table::{
    Cells, ColumnSet, LINK_COLUMNS, LINK_POSE_COLUMNS, ROUND_TRIP_COLUMNS, StreamKind, Table,
};
use crate::toml_files::{recording_toml, robot_toml};

/// Reads a folder of CSV files with `recording.toml`.
///
/// # Errors
/// The first violation of the format, with file and line; or a file that cannot be read.
pub fn read_folder(folder: &Path) -> Result<Import> {
    spool_folder(folder)?.load()
}

/// As [`read_folder`]; the rows stay in a temporary file.
pub(crate) fn spool_folder(folder: &Path) -> Result<Spooled> {
    let path = folder.join("recording.toml");
    let name = folder.file_name().map(|name| name.to_string_lossy());
    let text = read_text(&path)?;
    let mut description = recording_toml::parse(&text, &path, &name.unwrap_or_default())?;
    description.read_from = ReadFrom::Folder;
    let mut warnings = Vec::new();
    let model = folder.join("robot.toml");
    if model.exists() {
        description.model = Some(robot_toml::read(&model)?);
    }
    let mut recording = SpooledRecording::new(description, Disk::default());
    for entry in sorted_entries(folder)? {
        read_entry(&entry, &mut recording, &mut warnings)?;
    }
    recording.disk.check()?;
    Ok(Spooled {
        recording,
        guesses: Vec::new(),
        warnings,
        on_model: Vec::new(),
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
fn read_entry(
    path: &Path,
    recording: &mut SpooledRecording,
    warnings: &mut Vec<String>,
) -> Result<()> {
    let name = file_name(path);
    match name.as_str() {
        "recording.toml" | "robot.toml" => {}
        "links.csv" => read_links(path, recording, warnings)?,
        "rtt.csv" => read_round_trips(path, recording, warnings)?,
        _ if path.is_dir() => {
            if !is_folder_of_robot(path, &name, &mut recording.description, warnings) {
                return Ok(());
            }
            for file in sorted_entries(path)? {
                read_stream(&file, &name, recording, warnings)?;
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

/// Whether this is the folder of a robot, which is added if it is new. A folder without a table in
/// `recording.toml` is a robot's if it contains a stream.
fn is_folder_of_robot(
    path: &Path,
    name: &str,
    description: &mut Recording,
    warnings: &mut Vec<String>,
) -> bool {
    if description.robot(name).is_some() {
        return true;
    }
    let has_stream = |kind: &StreamKind| path.join(format!("{}.csv", kind.name())).exists();
    let is_robot = StreamKind::ALL.iter().any(has_stream);
    if !is_robot || !is_robot_name(name) {
        warnings.push(format!(
            "{}: is not a robot's folder; ignored",
            path.display()
        ));
        return false;
    }
    warnings.push(format!(
        "{}: recording.toml has no [robots.{name}]; read as a robot without description",
        path.display()
    ));
    description.robots.push(Robot::named(name));
    true
}

/// Reads one file of a robot's folder.
fn read_stream(
    path: &Path,
    robot: &str,
    recording: &mut SpooledRecording,
    warnings: &mut Vec<String>,
) -> Result<()> {
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
    let set = ColumnSet::choose(kind, &present)
        .map_err(|(problem, remedy)| InputError::file(path, problem, remedy).at(1))?;
    file.warn_of_unknown(1, &known, warnings);

    let columns = set.present(&present);
    let place = |name: &Option<&str>| columns.iter().position(|column| Some(*column) == *name);
    let places: Vec<Option<usize>> = known.iter().map(place).collect();
    let unknown = file.unknown_columns(1, &known);
    let mut spool = Spool::new(&recording.disk, Table::new(&columns, unknown));
    while file.next_row()? {
        let t_s = file.time(0, spool.last_t_s())?;
        spool.tail().t_s.push(t_s);
        push_cells(&file, &places, spool.tail())?;
        spool.end_row();
    }
    recording.store(robot, kind, spool);
    Ok(())
}

/// Appends the cells of the current row after its time. `places` says for each of these columns which
/// column of the table it is; `None` for an unknown one.
fn push_cells(file: &CsvFile<'_>, places: &[Option<usize>], table: &mut Table) -> Result<()> {
    let mut unknown = table.unknown.iter_mut();
    for (i, place) in places.iter().enumerate() {
        let column = place.and_then(|place| table.columns.get_mut(place));
        match column {
            Some((_, Cells::Numbers(cells))) => cells.push(file.number_or_nan(i + 1)?),
            Some((_, Cells::Counts(cells))) => cells.push(file.count(i + 1)?),
            Some((_, Cells::Texts(cells))) => cells.push(file.text(i + 1)?.to_owned()),
            None => {
                if let Some(column) = unknown.next() {
                    column.cells.push(file.text(i + 1)?.to_owned());
                }
            }
        }
    }
    Ok(())
}

fn read_links(
    path: &Path,
    recording: &mut SpooledRecording,
    warnings: &mut Vec<String>,
) -> Result<()> {
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
    let empty = Table::of_links(&file.unknown_columns(0, &known));
    let mut spool = Spool::new(&recording.disk, empty);
    let [sent, columns @ ..] = indices;
    while file.next_row()? {
        let t_sent_s = file.time(sent.unwrap_or_default(), spool.last_t_s())?;
        let table = spool.tail();
        table.t_s.push(t_sent_s);
        for ((_, cells), index) in table.columns.iter_mut().zip(columns) {
            match (cells, index) {
                (Cells::Numbers(cells), Some(index)) => cells.push(file.number_or_nan(index)?),
                (Cells::Numbers(cells), None) => cells.push(f64::NAN),
                (Cells::Texts(cells), index) => {
                    cells.push(file.name(index.unwrap_or_default())?.to_owned());
                }
                (Cells::Counts(_), _) => {}
            }
        }
        file.keep_unknown(0, &known, &mut table.unknown)?;
        spool.end_row();
    }
    recording.store_links(spool, v.is_some());
    Ok(())
}

fn read_round_trips(
    path: &Path,
    recording: &mut SpooledRecording,
    warnings: &mut Vec<String>,
) -> Result<()> {
    let mut file = CsvFile::open(path)?;
    let [Some(seq), Some(rtt)] = file.find(&ROUND_TRIP_COLUMNS) else {
        return Err(file.header_error("seq or rtt_ms is missing").into());
    };
    let known = file.known(&ROUND_TRIP_COLUMNS);
    file.warn_of_unknown(0, &known, warnings);
    let empty = Table::of_round_trips(&file.unknown_columns(0, &known));
    let mut spool = Spool::new(&recording.disk, empty);
    while file.next_row()? {
        let Some(seq) = file.count(seq)? else {
            return Err(file
                .row_error("seq is empty", "number the round trips")
                .into());
        };
        let rtt_ms = file.number_or_nan(rtt)?;
        let table = spool.tail();
        table.push_round_trip(seq, rtt_ms);
        file.keep_unknown(0, &known, &mut table.unknown)?;
        spool.end_row();
    }
    recording.store_round_trips(spool);
    Ok(())
}
