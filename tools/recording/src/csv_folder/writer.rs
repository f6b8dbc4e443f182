//! Writer of a folder of CSV files. Numbers are written with the fewest digits that parse to the same
//! bits; NaN becomes an empty cell.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use slipstream_bag::output::OutputFolder;
use slipstream_bag::{Error, Result, write_error};

use crate::import::Spooled;
use crate::recording::{Recording, UnknownColumn};
use crate::rows::{AllRows, Disk, LinkRows, RobotRows, Rows};
use crate::table::{Cells, LINK_COLUMNS, link_columns, number_at};
use crate::toml_files::{recording_toml, robot_toml};

/// Writes a recording as a folder of CSV files. The folder must be empty or not exist. It gets its name
/// once it is complete; in a folder that exists, each file does.
///
/// # Errors
/// If the folder is not empty, or a file cannot be written.
pub fn write_folder(recording: &Recording, folder: &Path) -> Result<()> {
    write_whole(&AllRows::of(recording), &Disk::default(), folder)
}

impl Spooled {
    /// As [`write_folder`], in the memory of a few rows.
    ///
    /// # Errors
    /// As [`write_folder`], or if the temporary file cannot be read.
    pub fn write_folder(&self, folder: &Path) -> Result<()> {
        write_whole(&self.recording.rows(), &self.recording.disk, folder)
    }
}

/// Writes the rows, which lie on `disk`, into a folder that gets its name at the end.
fn write_whole(rows: &AllRows<'_>, disk: &Disk, folder: &Path) -> Result<()> {
    let output = OutputFolder::create(folder)?;
    write_files(rows, output.path())?;
    disk.check()?;
    output.finish()
}

/// Writes all files into a folder.
fn write_files(rows: &AllRows<'_>, folder: &Path) -> Result<()> {
    let recording = rows.recording;
    let path = folder.join("recording.toml");
    std::fs::write(&path, recording_toml::to_text(recording)).map_err(write_error(&path))?;
    if let Some(model) = &recording.model {
        robot_toml::write(model, &folder.join("robot.toml"))?;
    }
    for RobotRows { robot, streams } in &rows.robots {
        let folder = folder.join(&robot.name);
        for (kind, rows) in streams {
            std::fs::create_dir_all(&folder).map_err(write_error(&folder))?;
            let path = folder.join(format!("{}.csv", kind.name()));
            write_file(&path, |csv| write_rows(csv, Some("t_s"), usize::MAX, rows))?;
        }
    }
    if let Some(LinkRows {
        rows,
        with_velocity,
    }) = &rows.links
    {
        let columns = link_columns(*with_velocity);
        let path = folder.join("links.csv");
        write_file(&path, |csv| {
            write_rows(csv, Some(LINK_COLUMNS[0]), columns - 1, rows)
        })?;
    }
    if let Some(rows) = &rows.rtt {
        let path = folder.join("rtt.csv");
        write_file(&path, |csv| write_rows(csv, None, usize::MAX, rows))?;
    }
    Ok(())
}

type Csv = csv::Writer<BufWriter<File>>;

fn write_file(path: &Path, write: impl FnOnce(&mut Csv) -> csv::Result<()>) -> Result<()> {
    let file = File::create(path).map_err(write_error(path))?;
    let mut csv = csv::Writer::from_writer(BufWriter::new(file));
    let failed = |e: csv::Error| Error::Write {
        path: path.to_owned(),
        source: e.into(),
    };
    write(&mut csv).map_err(failed)?;
    csv.flush().map_err(write_error(path))
}

/// Writes the first `columns` columns of a stream, after its times if these have a name, and before
/// the unknown columns.
fn write_rows(
    csv: &mut Csv,
    time: Option<&str>,
    columns: usize,
    rows: &Rows<'_>,
) -> csv::Result<()> {
    let empty = rows.empty();
    let known = empty.columns.iter().map(|(name, _)| *name).take(columns);
    let unknown = empty.unknown.iter().map(|column| column.name.as_str());
    csv.write_record(time.into_iter().chain(known).chain(unknown))?;
    let mut cell = Vec::new();
    let mut cursor = rows.clone().cursor();
    while let Some(block) = cursor.next_block() {
        for (row, t_s) in block.t_s.iter().enumerate() {
            if time.is_some() {
                write_number(csv, &mut cell, *t_s)?;
            }
            for (_, cells) in block.columns.iter().take(columns) {
                write_cell(csv, &mut cell, cells, row)?;
            }
            write_unknown(csv, &block.unknown, row)?;
            csv.write_record(None::<&[u8]>)?;
        }
    }
    Ok(())
}

fn write_cell(csv: &mut Csv, cell: &mut Vec<u8>, cells: &Cells, row: usize) -> csv::Result<()> {
    match cells {
        Cells::Numbers(numbers) => write_number(csv, cell, number_at(numbers, row)),
        Cells::Counts(counts) => {
            cell.clear();
            if let Some(count) = counts.get(row).copied().flatten() {
                write!(cell, "{count}")?;
            }
            csv.write_field(&cell)
        }
        Cells::Texts(texts) => csv.write_field(texts.get(row).map_or("", String::as_str)),
    }
}

fn write_unknown(csv: &mut Csv, unknown: &[UnknownColumn], row: usize) -> csv::Result<()> {
    for column in unknown {
        csv.write_field(column.cells.get(row).map_or("", String::as_str))?;
    }
    Ok(())
}

/// Writes a number with the fewest digits that parse to the same bits; NaN as an empty cell.
fn write_number(csv: &mut Csv, cell: &mut Vec<u8>, number: f64) -> csv::Result<()> {
    cell.clear();
    if !number.is_nan() {
        let size = number.abs();
        if size == 0.0 || (1e-5..1e16).contains(&size) {
            write!(cell, "{number}")?;
        } else {
            write!(cell, "{number:e}")?;
        }
    }
    csv.write_field(&cell)
}
