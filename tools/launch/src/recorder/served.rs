//! Viewers of a run: what is recorded is sent to them as it happens.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use slipstream_bag::{Announced, Listener};
use slipstream_bus::transport::BusError;
use slipstream_ipc::join::JoinedRun;
use slipstream_live::Server;

use super::mcap_sink::McapSink;

/// How often it is looked for viewers.
const LOOKING: Duration = Duration::from_millis(20);

/// A server that has every message of a sink.
pub(super) struct Served(Arc<Mutex<Server>>);

impl Served {
    /// Starts the server; with `waits`, returns once a viewer has subscribed.
    pub(super) fn start(
        joined: &JoinedRun,
        sink: &mut McapSink,
        address: &str,
        waits: bool,
    ) -> Result<Self, BusError> {
        let name = &joined.experiment.settings.name;
        let server = Server::start(address, name).map_err(|error| BusError::Failed {
            what: "viewers".to_owned(),
            reason: error.to_string(),
        })?;
        let served = Self(Arc::new(Mutex::new(server)));
        sink.listen(Box::new(Self(Arc::clone(&served.0))));
        while waits && served.with(|server| server.subscriptions()) == 0 {
            joined.presence.show();
            std::thread::sleep(LOOKING);
        }
        Ok(served)
    }

    /// Ends the server, after viewers had time to take the last messages.
    pub(super) fn stop(self) {
        self.with(|server| server.end());
    }

    fn with<T>(&self, work: impl FnOnce(&mut Server) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Listener for Served {
    fn announced(&mut self, channel: &Announced<'_>) {
        self.with(|server| server.announced(channel));
    }

    fn described(&mut self, name: &str, text: &str) {
        self.with(|server| server.described(name, text));
    }

    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]) {
        self.with(|server| server.message(topic, t_ns, data));
    }
}
