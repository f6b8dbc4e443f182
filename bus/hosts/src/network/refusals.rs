//! Connections that Zenoh refuses below this program, such as one with a wrong certificate. It says so in its log alone.

use std::fmt::Debug;
use std::sync::mpsc::Sender;
use std::sync::{Mutex, PoisonError};

use tracing::field::{Field, Visit};
use tracing::level_filters::LevelFilter;
use tracing::span::{Attributes, Id, Record};
use tracing::{Event as LogEvent, Level, Metadata, Subscriber};

use crate::carrier::Event;

/// Begin of the names of the modules that accept connections.
const ACCEPTING: &str = "zenoh_link";

/// Tells what Zenoh's threads say of refused connections from now on, each sentence once.
pub(super) fn tell(events: Sender<Event>) {
    let refusals = Refusals {
        events: Mutex::new((events, String::new())),
    };
    // If a log has been set up for the process, it has them.
    let _ = tracing::subscriber::set_global_default(refusals);
}

/// A subscriber for warnings of the modules that accept connections.
struct Refusals {
    /// Where they are told, and the last one: a host tries several times.
    events: Mutex<(Sender<Event>, String)>,
}

impl Subscriber for Refusals {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::WARN && metadata.target().starts_with(ACCEPTING)
    }

    fn max_level_hint(&self) -> Option<LevelFilter> {
        Some(LevelFilter::WARN)
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &LogEvent<'_>) {
        let mut message = EventText::default();
        event.record(&mut message);
        // The hint that Zenoh adds is about something else.
        let reason = message.0.split(". Hint:").next().unwrap_or_default();
        let mut told = self.events.lock().unwrap_or_else(PoisonError::into_inner);
        if told.1 != reason {
            reason.clone_into(&mut told.1);
            let reason = reason.to_owned();
            let _ = told.0.send(Event::Refused { reason });
        }
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

/// The text of an event.
#[derive(Default)]
struct EventText(String);

impl Visit for EventText {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            self.0 = format!("{value:?}");
        }
    }
}
