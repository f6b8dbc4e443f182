//! Writer of a folder of CSV files. Numbers are written with the fewest digits that parse to the same
//! bits; NaN becomes an empty cell.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use slipstream_bus::InputError;

use crate::error::{Error, Result, write_error};
use crate::recording::{Links, Recording, RoundTrips, UnknownColumn};
use crate::table::{
    CellsView, LINK_COLUMNS, LINK_POSE_COLUMNS, ROUND_TRIP_COLUMNS, StreamKind, TableView,
    number_at,
};
use crate::toml_files::{recording_toml, robot_toml};

/// Writes a recording as a folder of CSV files. The folder must be empty or not exist.
///
/// # Errors
/// If the folder is not empty, or a file cannot be written.
pub fn write_folder(recording: &Recording, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(write_error(folder))?;
    let mut entries = std::fs::read_dir(folder).map_err(write_error(folder))?;
    if entries.next().is_some() {
        let problem = "the folder is not empty";
        return Err(InputError::file(folder, problem, "give a new folder").into());
    }
    let path = folder.join("recording.toml");
    std::fs::write(&path, recording_toml::to_text(recording)).map_err(write_error(&path))?;
    if let Some(model) = &recording.model {
        robot_toml::write(model, &folder.join("robot.toml"))?;
    }
    for robot in &recording.robots {
        let folder = folder.join(&robot.name);
        for kind in StreamKind::ALL {
            if let Some(table) = TableView::of(robot, kind) {
                std::fs::create_dir_all(&folder).map_err(write_error(&folder))?;
                let path = folder.join(format!("{}.csv", kind.name()));
                write_file(&path, |csv| write_stream(csv, &table))?;
            }
        }
    }
    if let Some(links) = &recording.links {
        write_file(&folder.join("links.csv"), |csv| write_links(csv, links))?;
    }
    if let Some(rtt) = &recording.rtt {
        write_file(&folder.join("rtt.csv"), |csv| write_round_trips(csv, rtt))?;
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

fn write_stream(csv: &mut Csv, table: &TableView<'_>) -> csv::Result<()> {
    let known = table.columns.iter().map(|(name, _)| *name);
    let unknown = table.unknown.iter().map(|column| column.name.as_str());
    csv.write_record(std::iter::once("t_s").chain(known).chain(unknown))?;
    let mut cell = Vec::new();
    for (i, t_s) in table.t_s.iter().enumerate() {
        write_number(csv, &mut cell, *t_s)?;
        for (_, cells) in &table.columns {
            match cells {
                CellsView::Numbers(numbers) => {
                    write_number(csv, &mut cell, number_at(numbers, i))?;
                }
                CellsView::Counts(counts) => {
                    cell.clear();
                    if let Some(count) = counts.get(i).copied().flatten() {
                        write!(cell, "{count}")?;
                    }
                    csv.write_field(&cell)?;
                }
            }
        }
        write_unknown(csv, table.unknown, i)?;
        csv.write_record(None::<&[u8]>)?;
    }
    Ok(())
}

fn write_links(csv: &mut Csv, links: &Links) -> csv::Result<()> {
    let columns = if links.with_velocity {
        LINK_COLUMNS.len()
    } else {
        LINK_POSE_COLUMNS
    };
    let columns = LINK_COLUMNS.iter().take(columns).copied();
    let unknown = links.unknown.iter().map(|column| column.name.as_str());
    csv.write_record(columns.chain(unknown))?;
    let mut cell = Vec::new();
    for (i, message) in links.messages.iter().enumerate() {
        write_number(csv, &mut cell, message.t_sent_s)?;
        write_number(csv, &mut cell, message.t_received_s.unwrap_or(f64::NAN))?;
        csv.write_field(message.from.as_bytes())?;
        csv.write_field(message.to.as_bytes())?;
        write_number(csv, &mut cell, message.x_m)?;
        write_number(csv, &mut cell, message.y_m)?;
        write_number(csv, &mut cell, message.yaw_rad)?;
        if links.with_velocity {
            write_number(csv, &mut cell, message.v_m_s)?;
            write_number(csv, &mut cell, message.w_rad_s)?;
        }
        write_unknown(csv, &links.unknown, i)?;
        csv.write_record(None::<&[u8]>)?;
    }
    Ok(())
}

fn write_round_trips(csv: &mut Csv, rtt: &RoundTrips) -> csv::Result<()> {
    let unknown = rtt.unknown.iter().map(|column| column.name.as_str());
    csv.write_record(ROUND_TRIP_COLUMNS.into_iter().chain(unknown))?;
    let mut cell = Vec::new();
    for (i, (seq, rtt_ms)) in rtt.seq.iter().zip(&rtt.rtt_ms).enumerate() {
        csv.write_field(seq.to_string())?;
        write_number(csv, &mut cell, *rtt_ms)?;
        write_unknown(csv, &rtt.unknown, i)?;
        csv.write_record(None::<&[u8]>)?;
    }
    Ok(())
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
