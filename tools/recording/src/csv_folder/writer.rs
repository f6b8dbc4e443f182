//! CSV folders out: the shortest digits that read back as the same bits, empty cells empty.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use crate::error::{Error, Result, Unusable, writing};
use crate::recording::{Links, Recording, RoundTrips, UnknownColumn};
use crate::table::{CellsView, StreamKind, TableView};
use crate::toml_files::{recording_toml, robot_toml};

/// Writes the recording as a folder of CSV files. The folder must not exist or be empty.
///
/// # Errors
/// When there is something in the folder already, or the system does not let it be written.
pub fn write_folder(recording: &Recording, folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(writing(folder))?;
    let mut entries = std::fs::read_dir(folder).map_err(writing(folder))?;
    if entries.next().is_some() {
        let problem = "the folder is not empty";
        return Err(Unusable::new(folder, problem, "name a new one").into());
    }
    let path = folder.join("recording.toml");
    std::fs::write(&path, recording_toml::to_text(recording)).map_err(writing(&path))?;
    if let Some(model) = &recording.model {
        robot_toml::write(model, &folder.join("robot.toml"))?;
    }
    for robot in &recording.robots {
        let folder = folder.join(&robot.name);
        for kind in StreamKind::ALL {
            if let Some(table) = TableView::of(robot, kind) {
                std::fs::create_dir_all(&folder).map_err(writing(&folder))?;
                let path = folder.join(format!("{}.csv", kind.name()));
                write_file(&path, |csv| write_stream(csv, &table))?;
            }
        }
    }
    if let Some(links) = &recording.links {
        write_file(&folder.join("links.csv"), |csv| write_links(csv, links))?;
    }
    if let Some(rtt) = &recording.rtt {
        write_file(&folder.join("rtt.csv"), |csv| write_rtt(csv, rtt))?;
    }
    Ok(())
}

type Csv = csv::Writer<BufWriter<File>>;

fn write_file(path: &Path, write: impl FnOnce(&mut Csv) -> csv::Result<()>) -> Result<()> {
    let file = File::create(path).map_err(writing(path))?;
    let mut csv = csv::Writer::from_writer(BufWriter::new(file));
    let failed = |e: csv::Error| Error::Write {
        path: path.to_owned(),
        source: e.into(),
    };
    write(&mut csv).map_err(failed)?;
    csv.flush().map_err(writing(path))
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
                    write_number(csv, &mut cell, numbers.get(i).copied().unwrap_or(f64::NAN))?;
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
    let heads: &[&str] = &[
        "t_sent_s",
        "t_received_s",
        "from",
        "to",
        "x_m",
        "y_m",
        "yaw_rad",
    ];
    let velocity: &[&str] = if links.with_velocity {
        &["v_m_s", "w_rad_s"]
    } else {
        &[]
    };
    let unknown = links.unknown.iter().map(|column| column.name.as_str());
    csv.write_record(heads.iter().chain(velocity).copied().chain(unknown))?;
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

fn write_rtt(csv: &mut Csv, rtt: &RoundTrips) -> csv::Result<()> {
    let unknown = rtt.unknown.iter().map(|column| column.name.as_str());
    csv.write_record(["seq", "rtt_ms"].into_iter().chain(unknown))?;
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

/// The shortest text that reads back as the same bits; nothing for NaN, which means empty.
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
