//! Merge by time, with a reorder buffer and a low watermark: the file does not depend on which process ran when.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use slipstream_bus::record::{Record, Recorder};
use slipstream_ipc::record_pipe::Entry;

use super::mcap_sink::McapSink;

/// A source that sends nothing for this long is no longer waited for.
pub(super) const SILENCE: Duration = Duration::from_millis(300);

/// Merges the records of several sources, each in order of time, into one file.
pub(super) struct Merge {
    pub(super) sink: McapSink,
    /// Time of the last record of each source (ns).
    reached_ns: Vec<i64>,
    /// Records not yet written: latest time of the source (ns), number of the source, record.
    waiting: Vec<(i64, usize, Pending)>,
    /// When records were last released.
    released: Instant,
}

/// A record or trace chunk that waits for its turn.
enum Pending {
    Record(Record),
    Trace { t_ns: i64, bytes: Box<[u8]> },
}

impl Merge {
    /// A merge of `sources` sources. With 0, every record is written as it comes.
    pub(super) fn new(sources: usize, sink: McapSink) -> Self {
        Self {
            sink,
            reached_ns: vec![-1; sources],
            waiting: Vec::new(),
            released: Instant::now(),
        }
    }

    /// Adds an entry of a source.
    pub(super) fn push(&mut self, source: usize, entry: Entry<'_>) {
        let (t_ns, pending) = match entry {
            Entry::Record(record) => (record.t_ns(), Pending::Record(record)),
            Entry::Trace { t_ns, bytes } => {
                let bytes = bytes.into();
                (t_ns, Pending::Trace { t_ns, bytes })
            }
        };
        let Some(reached_ns) = self.reached_ns.get_mut(source) else {
            self.write(&pending);
            return;
        };
        *reached_ns = t_ns.max(*reached_ns);
        self.waiting.push((*reached_ns, source, pending));
    }

    fn write(&mut self, pending: &Pending) {
        match pending {
            Pending::Record(record) => self.sink.record(record),
            Pending::Trace { t_ns, bytes } => self.sink.trace(*t_ns, bytes),
        }
    }

    /// Writes everything that is older than the last record of every source.
    pub(super) fn release(&mut self) {
        let silent = self.released.elapsed() > SILENCE;
        let all = self.reached_ns.iter().copied().min().filter(|_| !silent);
        let before_ns = all.unwrap_or(i64::MAX);
        if !self.waiting.iter().any(|&(t_ns, ..)| t_ns < before_ns) {
            return;
        }
        self.released = Instant::now();
        self.waiting
            .sort_by_key(|&(t_ns, source, _)| (t_ns, source));
        let ready = self.waiting.partition_point(|&(t_ns, ..)| t_ns < before_ns);
        let rest = self.waiting.split_off(ready);
        for (_, _, pending) in std::mem::replace(&mut self.waiting, rest) {
            self.write(&pending);
        }
    }

    /// Writes the rest and closes the file. Returns the number of records in it.
    pub(super) fn finish(mut self) -> slipstream_recording::Result<u64> {
        self.reached_ns.clear();
        self.release();
        self.sink.finish(BTreeMap::new())
    }
}
