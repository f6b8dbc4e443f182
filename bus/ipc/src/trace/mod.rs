//! Trace recorder: spans and events of the `tracing` crate become compact postcard records.
//!
//! After [`begin`], the spans and events of the thread that pass the filter of `RUST_LOG` go into a
//! buffer of the thread. The buffer is drained in chunks, because delivering records one by one
//! costs more than recording them. A span becomes one record when it closes. Times are those of the
//! run: virtual time as set by [`set_virtual_time`], or the wall clock ([`use_clock`]). A field
//! `t_ns` overrides the time of an event.

mod buffer;
mod fields;
mod saved;
mod subscriber;
mod varint;

use std::path::Path;

use slipstream_bus::record::{Record, Recorder};
use tracing::subscriber::DefaultGuard;
pub use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;

use self::buffer::MAX_CHUNK;
pub use self::buffer::chunks;
pub use self::saved::read_saved;
use self::subscriber::{ThreadTrace, TraceSubscriber, with_thread_trace};
use crate::clock::WallClock;

/// Environment variable that holds the filter.
pub const VARIABLE: &str = "RUST_LOG";
/// Filter if the variable is not set: all levels except `trace`.
const DEFAULT_FILTER: &str = "slipstream=debug";

/// Guard: spans and events of the thread are recorded until it is dropped.
#[must_use]
#[derive(Debug)]
pub struct Tracing {
    _guard: DefaultGuard,
}

/// Reads the filter from the environment: levels by target, such as `info,slipstream_agents=debug`.
///
/// # Errors
/// The variable is not a valid filter; the text says why.
pub fn filter() -> Result<Targets, String> {
    let text = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty());
    let text = text.as_deref().unwrap_or(DEFAULT_FILTER);
    let parsed = text.parse::<Targets>();
    parsed.map_err(|error| format!("`{text}` is not a valid filter: {error}"))
}

/// Starts the trace of this thread; its records name `process`.
pub fn begin(process: &str, filter: Targets) -> Tracing {
    with_thread_trace(|trace| *trace = ThreadTrace::new(process));
    Tracing {
        _guard: tracing::subscriber::set_default(TraceSubscriber.with(filter)),
    }
}

/// Saves the buffered trace of this thread for the recorder, as `name`.
pub fn save(folder: &Path, name: &str) {
    saved::write(folder, name, &take_buffer());
}

/// Sets the virtual time of the thread's trace (ns).
pub fn set_virtual_time(now_ns: i64) {
    with_thread_trace(|trace| trace.now_ns = now_ns);
}

/// Takes the time of the thread's trace from a clock from now on.
pub fn use_clock(clock: WallClock) {
    with_thread_trace(|trace| trace.clock = Some(clock));
}

/// Traces a record of an applied torque. The plant's core does not depend on the trace, so it is
/// done where its records are logged.
pub(crate) fn trace_applied(record: &Record) {
    if let Record::Applied {
        taken_ns,
        robot,
        tick_ns,
        ..
    } = *record
    {
        tracing::debug!(name: "applied", t_ns = taken_ns, robot, tick_ns);
    }
}

/// Passes a record to a recorder and to the trace, then drains the buffer if it is long.
pub fn record(recorder: &mut impl Recorder, record: &Record) {
    trace_applied(record);
    recorder.record(record);
    drain_if_long(|t_ns, bytes| recorder.trace(t_ns, bytes));
}

/// Number of bytes in the buffer.
pub fn buffered_bytes() -> usize {
    with_thread_trace(|trace| trace.buffer.len()).unwrap_or(0)
}

/// [`drain`]s the buffer if it holds almost a full chunk.
pub fn drain_if_long(each: impl FnMut(i64, &[u8])) {
    if buffered_bytes() > MAX_CHUNK - MAX_CHUNK / 8 {
        drain(each);
    }
}

/// Empties the buffer: calls `each` with the time of the first record (ns) and the bytes of every
/// chunk.
pub fn drain(each: impl FnMut(i64, &[u8])) {
    // Records that `each` itself causes stay in the buffer until the next call.
    let mut bytes = take_buffer();
    chunks(&bytes, each);
    bytes.clear();
    with_thread_trace(|trace| {
        if trace.buffer.len() == 0 {
            trace.buffer.exchange(bytes);
        }
    });
}

/// Takes the content of the buffer, for [`chunks`].
pub fn take_buffer() -> Vec<u8> {
    with_thread_trace(|trace| trace.buffer.exchange(Vec::new())).unwrap_or_default()
}

/// Number of records dropped because the buffer was full.
pub fn lost() -> u64 {
    with_thread_trace(|trace| trace.buffer.lost).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use slipstream_bus::trace::{FORMAT, TraceError, TraceRecord, Value, read};

    use super::buffer::MAX_BUFFERED;
    use super::fields::MAX_TEXT;
    use super::*;

    /// A chunk as it stands in a file.
    fn with_format(chunk: &[u8]) -> Vec<u8> {
        [&[FORMAT], chunk].concat()
    }

    fn targets(text: &str) -> Targets {
        text.parse().unwrap()
    }

    fn records() -> Vec<TraceRecord<'static>> {
        let mut all = Vec::new();
        drain(|t_ns, chunk| {
            let before = all.len();
            read(Vec::leak(with_format(chunk)), |record| all.push(record)).unwrap();
            assert_eq!(all[before].begin_ns, t_ns);
        });
        all
    }

    #[test]
    fn spans_and_events_are_recorded_with_times_and_fields() {
        let _tracing = begin("r1", targets("debug"));
        set_virtual_time(100);
        let span = tracing::debug_span!("outer", robot = 0_u32, message = tracing::field::Empty);
        let entered = span.enter();
        set_virtual_time(150);
        tracing::info!(name: "sent", t_ns = 140_i64, share = 0.5, lost = false, "to {}", "r2");
        tracing::trace!(name: "fine", robot = 0_u32);
        span.record("message", 7_u32);
        set_virtual_time(200);
        drop(entered);
        drop(span);
        let all = records();
        assert_eq!(all.len(), 2);
        let [sent, outer] = [&all[0], &all[1]];
        assert_eq!(
            (&*sent.name, sent.begin_ns, sent.end_ns),
            ("sent", 140, None)
        );
        assert_eq!(sent.text("message"), Some("to r2"));
        assert_eq!(sent.field("share"), Some(&Value::Float(0.5)));
        assert_eq!(sent.field("lost"), Some(&Value::Bool(false)));
        assert_eq!((outer.begin_ns, outer.end_ns), (100, Some(200)));
        assert_eq!(
            (outer.int("robot"), outer.int("message")),
            (Some(0), Some(7))
        );
        assert_eq!((&*outer.process, outer.level), ("r1", 4));
        assert!(records().is_empty());
    }

    #[test]
    fn another_format_is_distinguished_from_damage() {
        let record = |bytes: &[u8]| read(bytes, |_| {});
        assert_eq!(record(&[5, 1, 2]), Err(TraceError::OtherFormat));
        assert_eq!(record(&[FORMAT, 200]), Err(TraceError::Damaged));
        assert_eq!(record(&[]), Err(TraceError::Damaged));
    }

    #[test]
    fn a_full_chunk_is_followed_by_another_and_a_record_larger_than_a_chunk_is_lost() {
        let _tracing = begin("r1", targets("debug"));
        for seq in 0..1000_u32 {
            tracing::debug!(name: "sent", seq);
        }
        let long = "x".repeat(MAX_TEXT);
        let long = long.as_str();
        tracing::debug!(name: "long", a = long, b = long, c = long, d = long, e = long);
        tracing::debug!(name: "too_long", a = long, b = long, c = long, d = long, e = long, f = long);
        let mut sizes = Vec::new();
        let buffer = take_buffer();
        let mut count = 0;
        chunks(&buffer, |_, chunk| {
            sizes.push(chunk.len());
            read(&with_format(chunk), |_| count += 1).unwrap();
        });
        assert_eq!((count, lost()), (1001, 1));
        assert!(
            sizes.len() > 2 && sizes.iter().all(|&size| size <= MAX_CHUNK),
            "{sizes:?}"
        );
    }

    #[test]
    fn a_thread_without_a_trace_records_nothing_and_a_full_buffer_counts_its_losses() {
        tracing::error!("not recorded");
        assert!(take_buffer().is_empty());
        let _tracing = begin("r1", targets("debug"));
        for _ in 0..100_000 {
            tracing::info!(name: "much", text = "together more than the buffer holds");
        }
        assert!(take_buffer().len() < MAX_BUFFERED + MAX_CHUNK && lost() > 0);
    }

    #[test]
    fn a_truncated_buffer_is_read_up_to_its_last_complete_chunk() {
        let _tracing = begin("r1", targets("debug"));
        tracing::info!(name: "one", robot = 1_u32);
        tracing::info!(name: "two", robot = 2_u32);
        let bytes = take_buffer();
        for cut in 0..bytes.len() {
            let mut count = 0;
            chunks(&bytes[..cut], |_, chunk| {
                read(&with_format(chunk), |_| count += 1).unwrap();
            });
            assert!(count < 2);
        }
    }
}
