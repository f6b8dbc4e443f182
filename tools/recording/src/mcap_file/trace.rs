//! The trace of a run: the steps of its positions' ways, as their processes told them.

use std::path::Path;

use crate::bag::{self, Item, Loss, Undecodable, read_bag};
use crate::error::{Result, Unusable};
use crate::ros2::cdr::decode;
use crate::ros2::messages::TraceEvent;
use crate::toml_files::recording_toml;
use crate::topics;

/// What goes along with a trace.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceFile {
    /// The robots' names, by their index.
    pub robots: Vec<String>,
    /// What of the file could not be read.
    pub loss: Loss,
}

/// Shows `each` all trace records (postcard) of a run's MCAP file, in the file's order; `each` says
/// whether it could decode one. What cannot be decoded counts in [`Loss::undecodable_messages`].
///
/// # Errors
/// When the file cannot be read, is no MCAP file, or holds no trace.
pub fn read_trace(path: &Path, each: &mut dyn FnMut(&[u8]) -> bool) -> Result<TraceFile> {
    let unreadable = |e: std::io::Error| Unusable::unreadable(path, &e);
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    let no_trace = |problem: &str| {
        let remedy = "give an MCAP file that `slipstream run` wrote";
        Unusable::new(path, problem, remedy)
    };
    if metadata.is_dir() {
        return Err(no_trace("is a folder, which holds no trace").into());
    }
    let (source, size) = bag::open(path)?;
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
        return Err(no_trace("holds no trace").into());
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
