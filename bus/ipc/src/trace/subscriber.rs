//! Hears the spans and events that the filter lets through, and writes them onto the thread's buffer.

use std::cell::RefCell;

use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Metadata, Subscriber};

use super::buffer::{NewRecord, TraceBuffer};
use super::fields::Fields;
use crate::clock::WallClock;

/// What a thread is telling.
#[derive(Debug, Default)]
pub(super) struct ThreadTrace {
    process: String,
    pub(super) now_ns: i64,
    pub(super) clock: Option<WallClock>,
    pub(super) buffer: TraceBuffer,
    /// Spans that have not closed, the newest last, and room for more.
    open: Vec<Open>,
    spare: Vec<Fields>,
    spans: u64,
    /// Of the event under way.
    fields: Fields,
}

#[derive(Debug)]
struct Open {
    id: u64,
    handles: u32,
    metadata: &'static Metadata<'static>,
    begin_ns: i64,
    fields: Fields,
}

thread_local! {
    static THREAD_TRACE: RefCell<ThreadTrace> = RefCell::default();
}

/// Whoever tells something while the thread is in use is not heard.
pub(super) fn with_thread_trace<T>(work: impl FnOnce(&mut ThreadTrace) -> T) -> Option<T> {
    // A thread that is ending has no thread any more.
    let record = THREAD_TRACE.try_with(|thread| Some(work(&mut *thread.try_borrow_mut().ok()?)));
    record.ok().flatten()
}

impl ThreadTrace {
    pub(super) fn of(process: &str) -> Self {
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
        self.open.push(Open {
            id: self.spans,
            handles: 1,
            metadata: attributes.metadata(),
            begin_ns: self.now_ns(),
            fields,
        });
        self.spans
    }

    fn find(&mut self, id: &Id) -> Option<&mut Open> {
        let mut open = self.open.iter_mut().rev();
        open.find(|span| span.id == id.into_u64())
    }

    fn tell(&mut self, event: &Event<'_>) {
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

    /// Lets go of a span, and says whether nobody holds it any more.
    fn close(&mut self, id: &Id) -> bool {
        let place = self.open.iter().rposition(|span| span.id == id.into_u64());
        let Some(place) = place else {
            return false;
        };
        self.open[place].handles -= 1;
        if self.open[place].handles > 0 {
            return false;
        }
        let span = self.open.remove(place);
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

/// Below the filter. Knows no parents and no contexts: a record says all that is to be read of it.
pub(super) struct TraceSubscriber;

impl Subscriber for TraceSubscriber {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn new_span(&self, attributes: &Attributes<'_>) -> Id {
        Id::from_u64(with_thread_trace(|thread| thread.open(attributes)).unwrap_or(u64::MAX))
    }

    fn record(&self, id: &Id, values: &Record<'_>) {
        with_thread_trace(|thread| thread.find(id).map(|span| values.record(&mut span.fields)));
    }

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        with_thread_trace(|thread| thread.tell(event));
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}

    fn clone_span(&self, id: &Id) -> Id {
        with_thread_trace(|thread| thread.find(id).map(|span| span.handles += 1));
        id.clone()
    }

    fn try_close(&self, id: Id) -> bool {
        with_thread_trace(|thread| thread.close(&id)).unwrap_or(false)
    }
}
