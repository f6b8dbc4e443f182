//! Reader of the trace in a run's MCAP file: one record per event of a position on its way.

use std::path::Path;

use slipstream_bag::ros::cdr::decode;
use slipstream_bag::ros::messages::TraceEvent;
use slipstream_bag::{Item, Loss, Result, Undecodable, open_file, read_bag};
use slipstream_bus::InputError;

use crate::toml_files::recording_toml;
use crate::topics;

/// What [`read_trace`] returns besides the records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceFile {
    /// Names of the robots, by their index.
    pub robots: Vec<String>,
    /// Parts of the file that could not be read.
    pub loss: Loss,
}

/// Calls `each` with every trace record (postcard) of a run's MCAP file, in file order. `each` returns
/// whether it could decode the record; the others are counted in [`Loss::undecodable_messages`].
///
/// # Errors
/// If the file cannot be read, is not an MCAP file, or contains no trace.
pub fn read_trace(path: &Path, each: &mut dyn FnMut(&[u8]) -> bool) -> Result<TraceFile> {
    let metadata = std::fs::metadata(path).map_err(|e| InputError::unreadable(path, &e))?;
    let no_trace = |problem: &str| {
        let remedy = "give an MCAP file that `slipstream run` wrote";
        InputError::file(path, problem, remedy)
    };
    if metadata.is_dir() {
        return Err(no_trace("is a folder, which contains no trace").into());
    }
    let (source, size) = open_file(path)?;
    let (mut description, mut records) = (None, 0_u64);
    let loss = read_bag(source, size, path, &mut |item| match item {
        Item::Message { channel, data, .. } if channel.topic == topics::TRACE => {
            let event: TraceEvent<Vec<u8>> = decode(data).map_err(|_| Undecodable)?;
            records += 1;
            each(&event.postcard).then_some(()).ok_or(Undecodable)
        }
        Item::Attachment { name, data } if name == topics::DESCRIPTION => {
            description = Some(String::from_utf8_lossy(data).into_owned());
            Ok(())
        }
        _ => Ok(()),
    })?;
    if records == 0 {
        return Err(no_trace("contains no trace").into());
    }
    let robots = match description {
        Some(text) => recording_toml::parse(&text, &path.join(topics::DESCRIPTION), "")?.robots,
        None => Vec::new(),
    };
    Ok(TraceFile {
        robots: robots.into_iter().map(|robot| robot.name).collect(),
        loss,
    })
}
