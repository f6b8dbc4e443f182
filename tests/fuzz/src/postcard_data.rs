//! Binary data between the processes of a run: experiment, records, reports and trace.

use serde::Serialize;
use serde::de::DeserializeOwned;
use slipstream_agents::process::AgentOutcome;
use slipstream_bus::Experiment;
use slipstream_bus::trace::{self, CallSite, FORMAT, RecordData, TraceRecord};
use slipstream_hosts::frame::{Down, Up};
use slipstream_hosts::hello::{Hello, Welcome};
use slipstream_ipc::record_pipe::{Entry, decode_chunk};
use slipstream_launch::recorder::RecorderOutcome;
use slipstream_sim::run::process::PlantOutcome;
use slipstream_trace::{Log, Step, answer, follow, round_trips, timeline};

use crate::one_line::assert_one_line;

/// Decodes a value; if that succeeds, its encoding decodes to the same value.
fn round_trip<T: Serialize + DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let value: T = postcard::from_bytes(bytes).ok()?;
    let written = encode(&value);
    let again: T = postcard::from_bytes(&written).expect("what was written can be read");
    assert_eq!(encode(&again), written);
    Some(value)
}

fn encode(value: &impl Serialize) -> Vec<u8> {
    postcard::to_allocvec(value).expect("what was read can be written")
}

/// The experiment in the run directory.
pub(crate) fn experiment(bytes: &[u8]) {
    if let Some(experiment) = round_trip::<Experiment>(bytes)
        && let Err(error) = experiment.settings.validate()
    {
        assert_one_line(&error);
    }
}

/// The final report of a process. The first byte says of which.
pub(crate) fn reports(bytes: &[u8]) {
    let Some((process, bytes)) = bytes.split_first() else {
        return;
    };
    match process % 3 {
        0 => drop(round_trip::<PlantOutcome>(bytes)),
        1 => drop(round_trip::<AgentOutcome>(bytes)),
        _ => drop(round_trip::<RecorderOutcome>(bytes)),
    }
}

/// A frame between hosts, or what a host says first. The first byte says which.
pub(crate) fn host_frame(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else {
        return;
    };
    match kind % 4 {
        0 => frame::<Down>(bytes),
        1 => frame::<Up>(bytes),
        2 => frame::<Hello>(bytes),
        _ => frame::<Welcome>(bytes),
    }
}

fn frame<T: Serialize + DeserializeOwned>(bytes: &[u8]) {
    match slipstream_hosts::frame::decode::<T>(bytes) {
        Ok(value) => {
            let again = round_trip::<T>(&encode(&value));
            assert!(again.is_some());
        }
        Err(error) => assert_one_line(&error),
    }
}

/// A chunk of the record pipe.
pub(crate) fn record_chunk(bytes: &[u8]) {
    let mut entries: Vec<(u32, Entry<'_>)> = Vec::new();
    if let Err(error) = decode_chunk(bytes, &mut |source, entry| entries.push((source, entry))) {
        return assert_one_line(&error);
    }
    let mut written = bytes[..4].to_vec();
    for (_, entry) in &entries {
        written.extend(encode(entry));
    }
    let mut again = Vec::new();
    decode_chunk(&written, &mut |_, entry| again.extend(encode(&entry)))
        .expect("what was written can be read");
    assert_eq!(again, written[4..]);
}

/// Chunks of the trace, one after the other, as a process leaves them in the run directory.
pub(crate) fn trace_buffer(bytes: &[u8]) {
    let mut used = 0;
    slipstream_ipc::trace::chunks(bytes, |_, chunk| {
        used += 12 + chunk.len();
        trace_chunk(&[&[FORMAT], chunk].concat());
    });
    assert!(used <= bytes.len());
}

/// A chunk of the trace in a file, and the analysis of a trace of this chunk alone.
pub(crate) fn trace_chunk(bytes: &[u8]) {
    let mut records = Vec::new();
    if let Err(error) = trace::read(bytes, |record| records.push(record)) {
        return assert_one_line(&error);
    }
    let written = write_trace(&records);
    let mut again = Vec::new();
    trace::read(&written, |record| again.push(record)).expect("what was written can be read");
    assert_eq!(write_trace(&again), written);
    analyse(&records);
}

/// Writes records as a chunk, each with a call site of its own.
fn write_trace(records: &[TraceRecord<'_>]) -> Vec<u8> {
    let mut chunk = vec![FORMAT];
    let mut before_ns = 0_i64;
    for (call_site, record) in (0..).zip(records) {
        chunk.extend(encode(&trace::Entry::CallSite(CallSite {
            process: record.process.clone(),
            level: record.level,
            name: record.name.clone(),
            fields: record.fields.iter().map(|(name, _)| name.clone()).collect(),
        })));
        let values = record.fields.iter().map(|(_, value)| value.clone());
        chunk.extend(encode(&trace::Entry::Record(RecordData {
            call_site,
            since_previous_ns: record.begin_ns.wrapping_sub(before_ns),
            duration_ns: record.end_ns.map(|end| end.wrapping_sub(record.begin_ns)),
            fields: (0..).zip(values).collect(),
        })));
        before_ns = record.begin_ns;
    }
    chunk
}

/// Follows all messages, as `slipstream trace` does.
fn analyse(records: &[TraceRecord<'_>]) {
    let names = ["r1".to_owned(), "r2".to_owned()];
    let robot_of = |process: &str| (0..).zip(&names).find(|(_, name)| *name == process);
    let robot_of = |process: &str| robot_of(process).map(|(index, _)| index);
    let log = Log::new(
        records
            .iter()
            .filter_map(|record| Step::of(record, robot_of)),
    );
    follow(&log);
    answer(&log, &names);
    round_trips(&log);
    timeline(&log, &names);
}
