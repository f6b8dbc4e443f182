//! A recording's trace.

use std::path::Path;

use slipstream_bus::message::RobotIndex;
use slipstream_bus::record::{Record, Recorder};
use slipstream_recording::{Result, Unusable, read_trace};

use crate::answer::Names;
use crate::log::Log;

/// A recording's trace, and what was lost of it.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The robots' names, by their index.
    pub robots: Vec<String>,
    /// What the records say.
    pub log: Log,
    /// One line for each thing that the reader should know.
    pub warnings: Vec<String>,
}

impl Reading {
    /// A robot's name.
    pub fn name_of(&self, robot: RobotIndex) -> String {
        Names(&self.robots).of(robot)
    }
}

/// Reads the trace of a run's MCAP file, also of a damaged one as far as it is whole.
///
/// # Errors
/// When the file cannot be read, is no MCAP file, or holds no trace that this program can read.
pub fn read(path: &Path) -> Result<Reading> {
    let mut log = Log::default();
    let mut undecodable = 0_u64;
    let file = read_trace(path, &mut |bytes| {
        let decoded = postcard::take_from_bytes::<Record>(bytes);
        match decoded {
            Ok((record, [])) => {
                log.record(&record);
                true
            }
            _ => {
                undecodable += 1;
                false
            }
        }
    })?;
    if undecodable > 0 {
        let problem = format!("{undecodable} records of its trace cannot be decoded");
        let remedy = "record it again with this program";
        return Err(Unusable::new(path, problem, remedy).into());
    }
    let loss = file.loss;
    let warnings = loss.any().then(|| format!("{}: {loss}", path.display()));
    Ok(Reading {
        robots: file.robots,
        log,
        warnings: warnings.into_iter().collect(),
    })
}
