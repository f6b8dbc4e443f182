//! Plays a recording to viewers at the speed at which it was recorded.

use std::path::Path;
use std::time::{Duration, Instant};

use slipstream_bag::{Announced, Listener};
use slipstream_bus::InputError;
use slipstream_recording::{Error, Recording, read_messages};
use tempfile::NamedTempFile;

use crate::server::Server;

/// How often it is looked for viewers.
const LOOKING: Duration = Duration::from_millis(50);

/// How a recording is played.
#[derive(Debug, Clone, Copy)]
pub struct Playback {
    /// Times as fast as it was recorded.
    pub speed: f64,
    /// Begins again at its end.
    pub repeats: bool,
}

/// Plays an MCAP file, once a viewer has subscribed.
///
/// # Errors
/// A file that cannot be read.
pub fn play(file: &Path, playback: Playback, server: &mut Server) -> Result<(), Error> {
    read_messages(file, &mut TopicAnnouncer(server))?;
    while server.subscriptions() == 0 {
        std::thread::sleep(LOOKING);
    }
    loop {
        let mut paced = Paced {
            server,
            speed: playback.speed,
            began: Instant::now(),
            first_ns: None,
        };
        read_messages(file, &mut paced)?;
        if !playback.repeats {
            return Ok(());
        }
    }
}

/// The recording that was read from `path` as a temporary MCAP file; none if it is one.
///
/// # Errors
/// A temporary file that cannot be written.
pub fn converted(path: &Path, recording: &Recording) -> Result<Option<NamedTempFile>, Error> {
    let is_mcap = path
        .extension()
        .is_some_and(|own| own.eq_ignore_ascii_case("mcap"));
    if is_mcap && path.is_file() {
        return Ok(None);
    }
    let file = NamedTempFile::new().map_err(|error| InputError::unreadable(path, &error))?;
    slipstream_recording::write_mcap(recording, file.path())?;
    Ok(Some(file))
}

/// Announces every topic before the first message.
struct TopicAnnouncer<'a>(&'a mut Server);

impl Listener for TopicAnnouncer<'_> {
    fn announced(&mut self, channel: &Announced<'_>) {
        self.0.announced(channel);
    }

    fn described(&mut self, name: &str, text: &str) {
        self.0.described(name, text);
    }

    fn message(&mut self, _: &str, _: u64, _: &[u8]) {}
}

/// Sends each message when it is due.
struct Paced<'a> {
    server: &'a Server,
    speed: f64,
    began: Instant,
    first_ns: Option<u64>,
}

impl Listener for Paced<'_> {
    fn announced(&mut self, _: &Announced<'_>) {}

    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]) {
        let first_ns = *self.first_ns.get_or_insert(t_ns);
        let passed = Duration::from_nanos(t_ns.saturating_sub(first_ns));
        let due = passed.div_f64(self.speed);
        std::thread::sleep(due.saturating_sub(self.began.elapsed()));
        self.server.send(topic, t_ns, data);
    }
}
