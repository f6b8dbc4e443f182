//! Subscriber of the `tracing` crate that writes the spans and events of a thread to its buffer.

use std::cell::RefCell;

use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};

use super::buffer::{NewRecord, TraceBuffer};
use super::fields::Fields;
use crate::clock::WallClock;

/// The trace of one thread.
#[derive(Debug, Default)]
pub(super) struct ThreadTrace {
    process: String,
    pub(super) now_ns: i64,
    pub(super) clock: Option<WallClock>,
    pub(super) buffer: TraceBuffer,
    /// Open spans, the newest last.
    open: Vec<OpenSpan>,
    /// Field buffers of closed spans, for reuse.
    spare: Vec<Fields>,
    /// Number of spans so far, and so the identity of the newest.
    spans: u64,
    /// Fields of the event being recorded.
    fields: Fields,
}

#[derive(Debug)]
struct OpenSpan {
    id: u64,
    /// Number of handles to the span; it closes with the last one.
    handles: u32,
    metadata: &'static Metadata<'static>,
    begin_ns: i64,
    fields: Fields,
}

thread_local! {
    static THREAD_TRACE: RefCell<ThreadTrace> = RefCell::default();
}

/// Calls `work` with the trace of this thread. Returns `None` if the trace is in use already, or if
/// the thread is ending.
pub(super) fn with_thread_trace<T>(work: impl FnOnce(&mut ThreadTrace) -> T) -> Option<T> {
    let result = THREAD_TRACE.try_with(|trace| Some(work(&mut *trace.try_borrow_mut().ok()?)));
    result.ok().flatten()
}

impl ThreadTrace {
    pub(super) fn new(process: &str) -> Self {
        Self {
            process: process.to_owned(),
            ..Self::default()
        }
    }

    fn now_ns(&self) -> i64 {
        self.clock.map_or(self.now_ns, |clock| clock.now_ns())
    }

    fn open(&mut self, attributes: &Attributes<'_>) -> u64 {
        let mut fields = self.spare.pop().unwrap_or_default();
        fields.clear();
        attributes.record(&mut fields);
        self.spans += 1;
        self.open.push(OpenSpan {
            id: self.spans,
            handles: 1,
            metadata: attributes.metadata(),
            begin_ns: self.now_ns(),
            fields,
        });
        self.spans
    }

    fn find(&mut self, id: &Id) -> Option<&mut OpenSpan> {
        let mut open = self.open.iter_mut().rev();
        open.find(|span| span.id == id.into_u64())
    }

    fn record_event(&mut self, event: &Event<'_>) {
        self.fields.clear();
        event.record(&mut self.fields);
        let begin_ns = self.fields.t_ns.unwrap_or_else(|| self.now_ns());
        self.buffer.write(NewRecord {
            process: &self.process,
            metadata: event.metadata(),
            begin_ns,
            duration_ns: None,
            fields: &self.fields,
        });
    }

    /// Releases a handle of a span. Writes the span and returns true if it was the last one.
    fn close(&mut self, id: &Id) -> bool {
        let found = self.open.iter().rposition(|span| span.id == id.into_u64());
        let Some(index) = found else {
            return false;
        };
        self.open[index].handles -= 1;
        if self.open[index].handles > 0 {
            return false;
        }
        let span = self.open.remove(index);
        let duration_ns = self.now_ns() - span.begin_ns;
        self.buffer.write(NewRecord {
            process: &self.process,
            metadata: span.metadata,
            begin_ns: span.begin_ns,
            duration_ns: Some(duration_ns),
            fields: &span.fields,
        });
        self.spare.push(span.fields);
        true
    }
}

/// The subscriber below the filter. It ignores parents and contexts: every record is complete.
pub(super) struct TraceSubscriber;

impl Subscriber for TraceSubscriber {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn new_span(&self, attributes: &Attributes<'_>) -> Id {
        Id::from_u64(with_thread_trace(|trace| trace.open(attributes)).unwrap_or(u64::MAX))
    }

    fn record(&self, id: &Id, values: &Record<'_>) {
        with_thread_trace(|trace| trace.find(id).map(|span| values.record(&mut span.fields)));
    }

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        with_thread_trace(|trace| trace.record_event(event));
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}

    fn clone_span(&self, id: &Id) -> Id {
        with_thread_trace(|trace| trace.find(id).map(|span| span.handles += 1));
        id.clone()
    }

    fn try_close(&self, id: Id) -> bool {
        with_thread_trace(|trace| trace.close(&id)).unwrap_or(false)
    }
}
