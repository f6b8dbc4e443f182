//! Writer of a recording as an MCAP file: the rows of all streams in the order of time.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::path::Path;

use slipstream_bag::output::OutputFile;
use slipstream_bag::{BagWriter, Result};

use super::stream_writer::StreamWriter;
use crate::import::Spooled;
use crate::recording::Recording;
use crate::rows::AllRows;
use crate::toml_files::{recording_toml, robot_toml};
use crate::topics;

/// Writes a recording to an MCAP file, replacing an existing one.
///
/// # Errors
/// If the file cannot be written.
pub fn write_mcap(recording: &Recording, path: &Path) -> Result<()> {
    let mut file = OutputFile::create(path)?;
    write(&AllRows::of(recording), BagWriter::new(&mut file, path)?)?;
    file.finish()
}

impl Spooled {
    /// As [`write_mcap`], in the memory of a few rows.
    ///
    /// # Errors
    /// If the file cannot be written, or the temporary file cannot be read.
    pub fn write_mcap(&self, path: &Path) -> Result<()> {
        let mut file = OutputFile::create(path)?;
        write(&self.recording.rows(), BagWriter::new(&mut file, path)?)?;
        self.recording.disk.check()?;
        file.finish()
    }
}

/// A recording as the bytes of an MCAP file. `path` is used in errors only.
///
/// # Errors
/// If a value cannot be encoded.
pub fn mcap_bytes(recording: &Recording, path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write(&AllRows::of(recording), BagWriter::new(&mut bytes, path)?)?;
    Ok(bytes)
}

fn write(rows: &AllRows<'_>, mut bag: BagWriter<'_>) -> Result<()> {
    let recording = rows.recording;
    let toml = "application/toml";
    let description = recording_toml::to_text(recording);
    bag.attach(topics::DESCRIPTION, toml, description.as_bytes())?;
    if let Some(model) = &recording.model {
        bag.attach(topics::MODEL, toml, robot_toml::to_text(model).as_bytes())?;
    }
    let metadata = [
        ("format", "1"),
        ("kind", "recording"),
        ("version", env!("CARGO_PKG_VERSION")),
    ];
    let metadata = metadata.map(|(key, value)| (key.to_owned(), value.to_owned()));
    bag.metadata(topics::FILE_METADATA, BTreeMap::from(metadata))?;

    let mut streams = Vec::new();
    for robot in &rows.robots {
        for (kind, rows) in &robot.streams {
            streams.push(StreamWriter::of_robot(&mut bag, robot.robot, *kind, rows)?);
        }
    }
    if let Some(links) = &rows.links {
        streams.push(StreamWriter::of_links(&mut bag, links)?);
    }
    if let Some(rows) = &rows.rtt {
        streams.push(StreamWriter::of_round_trips(&mut bag, rows)?);
    }
    write_in_time_order(&mut bag, &mut streams)?;
    bag.finish()
}

/// Merges the rows of all streams by time; rows with equal times keep the order of the streams.
fn write_in_time_order(bag: &mut BagWriter<'_>, streams: &mut [StreamWriter<'_>]) -> Result<()> {
    let mut next: BinaryHeap<Reverse<(i64, usize)>> = BinaryHeap::new();
    for (index, stream) in streams.iter().enumerate() {
        next.extend(stream.t_ns().map(|t_ns| Reverse((t_ns, index))));
    }
    while let Some(Reverse((_, index))) = next.pop() {
        if let Some(stream) = streams.get_mut(index) {
            stream.write_next(bag)?;
            next.extend(stream.t_ns().map(|t_ns| Reverse((t_ns, index))));
        }
    }
    Ok(())
}
