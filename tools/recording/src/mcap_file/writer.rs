//! Writer of a recording as an MCAP file: the rows of all streams in the order of time.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::io::Write;
use std::path::Path;

use super::stream_writer::StreamWriter;
use crate::bag::BagWriter;
use crate::error::Result;
use crate::output::OutputFile;
use crate::recording::Recording;
use crate::table::{StreamKind, TableView};
use crate::toml_files::{recording_toml, robot_toml};
use crate::topics;

/// Writes a recording to an MCAP file, replacing an existing one.
///
/// # Errors
/// If the file cannot be written.
pub fn write_mcap(recording: &Recording, path: &Path) -> Result<()> {
    write(recording, BagWriter::new(OutputFile::create(path)?, path)?)?.finish()
}

/// Writes a recording as MCAP to `sink` and returns it. `path` is used in errors only.
///
/// # Errors
/// If writing to `sink` fails.
pub fn write_mcap_to<W: Write>(recording: &Recording, sink: W, path: &Path) -> Result<W> {
    write(recording, BagWriter::new(sink, path)?)
}

fn write<W: Write>(recording: &Recording, mut bag: BagWriter<W>) -> Result<W> {
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
    for robot in &recording.robots {
        for kind in StreamKind::ALL {
            if let Some(table) = TableView::of(robot, kind) {
                streams.push(StreamWriter::of_robot(&mut bag, robot, kind, table)?);
            }
        }
    }
    if let Some(links) = &recording.links {
        streams.push(StreamWriter::of_links(&mut bag, links)?);
    }
    if let Some(trips) = &recording.rtt {
        streams.push(StreamWriter::of_round_trips(&mut bag, trips)?);
    }
    write_in_time_order(&mut bag, &streams)?;
    bag.finish()
}

/// Merges the rows of all streams by time; rows with equal times keep the order of the streams.
fn write_in_time_order<W: Write>(
    bag: &mut BagWriter<W>,
    streams: &[StreamWriter<'_>],
) -> Result<()> {
    let mut next: BinaryHeap<Reverse<(i64, usize, usize)>> = BinaryHeap::new();
    for (index, stream) in streams.iter().enumerate() {
        if stream.rows() > 0 {
            next.push(Reverse((stream.t_ns(0), index, 0)));
        }
    }
    while let Some(Reverse((t_ns, index, row))) = next.pop() {
        let Some(stream) = streams.get(index) else {
            continue;
        };
        stream.write(bag, t_ns, row)?;
        if row + 1 < stream.rows() {
            next.push(Reverse((stream.t_ns(row + 1), index, row + 1)));
        }
    }
    Ok(())
}
