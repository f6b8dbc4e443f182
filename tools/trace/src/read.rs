//! Reads the trace of a recording.

use std::path::Path;

use slipstream_bus::message::RobotIndex;
use slipstream_bus::trace::{self, TraceError, TraceRecord, Value};
use slipstream_recording::{InputError, Result, read_trace};

use crate::log::{Log, Note};
use crate::names::Names;
use crate::step::Step;

/// A recording's trace, and warnings about what could not be read.
#[derive(Debug, Clone)]
pub struct TraceReading {
    /// The robots' names, by their index.
    pub robots: Vec<String>,
    /// The trace.
    pub log: Log,
    /// Warnings for the user, one line each.
    pub warnings: Vec<String>,
}

impl TraceReading {
    /// The name of a robot.
    pub fn name_of(&self, robot: RobotIndex) -> String {
        Names(&self.robots).of(robot)
    }
}

/// Reads the trace of a run's MCAP file; of a damaged file it reads what is intact.
///
/// # Errors
/// The file cannot be read, is not an MCAP file, or holds no trace in a format known here.
pub fn read(path: &Path) -> Result<TraceReading> {
    let mut rejected = None;
    let file = read_trace(path, &mut |bytes| match trace::read(bytes, |_| {}) {
        Ok(()) => true,
        Err(why) => {
            rejected.get_or_insert(why);
            false
        }
    })?;
    if let Some(why) = rejected {
        let remedy = match why {
            TraceError::OtherFormat => "record it again, or read it with the version that wrote it",
            TraceError::Damaged => "record it again",
        };
        return Err(InputError::file(path, why.to_string(), remedy).into());
    }
    // The names of the robots, which may stand at the end, are known now.
    let mut log = Log::default();
    read_trace(path, &mut |bytes| {
        trace::read(bytes, |record| add(&mut log, &record, &file.robots)).is_ok()
    })?;
    log.check()?;
    if log.is_empty() {
        let remedy = "record with RUST_LOG=slipstream=debug, or without RUST_LOG";
        let problem = "the trace holds neither ticks nor messages".to_owned();
        return Err(InputError::file(path, problem, remedy).into());
    }
    let loss = file.loss;
    let warnings = loss.any().then(|| format!("{}: {loss}", path.display()));
    let hosts = log.hosts.clocks().filter(|(_, clock)| clock.windows == 0);
    let unknown = hosts.map(|(host, _)| {
        format!(
            "{}: holds no estimate of the clock of host {host}: how wrong its time stamps are is unknown",
            path.display()
        )
    });
    Ok(TraceReading {
        warnings: warnings.into_iter().chain(unknown).collect(),
        robots: file.robots,
        log,
    })
}

fn add(log: &mut Log, record: &TraceRecord<'_>, robots: &[String]) {
    let robot_of = |process: &str| {
        let index = robots.iter().position(|robot| robot == process)?;
        RobotIndex::try_from(index).ok()
    };
    if let Some(step) = Step::of(record, robot_of) {
        log.take(step);
    } else {
        let field = |(name, value): &(std::borrow::Cow<'_, str>, Value<'_>)| {
            (name.to_string(), json(value))
        };
        log.note(Note {
            process: record.process.to_string(),
            name: record.name.to_string(),
            begin_ns: record.begin_ns,
            end_ns: record.end_ns,
            fields: record.fields.iter().map(field).collect(),
        });
    }
}

fn json(value: &Value<'_>) -> serde_json::Value {
    match value {
        Value::Int(value) => (*value).into(),
        Value::Float(value) => (*value).into(),
        Value::Bool(value) => (*value).into(),
        Value::Text(value) => value.as_ref().into(),
    }
}
