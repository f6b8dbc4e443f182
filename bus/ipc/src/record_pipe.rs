//! Record pipe: log entries from every process to the recorder, batched into chunks of bytes.
//!
//! A chunk is the number of its source followed by entries encoded with postcard: records, and
//! chunks of the thread's trace. A source sends its chunk when it is full, and after
//! [`FLUSH_PERIOD`] at the latest.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use slipstream_bus::message::RobotIndex;
use slipstream_bus::record::{Record, Recorder};
use slipstream_bus::transport::BusError;

use crate::presence::Presence;
use crate::services::{RecordPublisher, RecordSubscriber, Services};
use crate::trace;

/// Wall time after which a chunk is sent even if it is not full.
pub const FLUSH_PERIOD: Duration = Duration::from_millis(100);
/// Pause between two attempts to send while the recorder's queue is full.
const RETRY_PERIOD: Duration = Duration::from_micros(200);
/// Time that a recorder which lives has to take what was sent last.
const TAKE_TIMEOUT: Duration = Duration::from_secs(5);
/// Size of the source number at the begin of a chunk (bytes).
const SOURCE_BYTES: usize = 4;
/// Upper bound of the size of an encoded record (bytes). The largest one, an outer tick, has 17
/// floating-point numbers and 4 integers: 168 bytes at most.
const MAX_RECORD_BYTES: usize = 256;

/// An entry of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Entry<'a> {
    /// A record.
    Record(Record),
    /// A chunk of the trace.
    Trace {
        /// Time of its first record (ns).
        t_ns: i64,
        /// The encoded trace records (`slipstream_bus::trace`).
        bytes: &'a [u8],
    },
}

/// The sending side, in plant and agents.
#[derive(Debug)]
pub struct RecordSender {
    /// `None`: nothing is recorded.
    port: Option<ChunkSender>,
    chunk: Vec<u8>,
    /// Number of bytes of the chunk in use.
    used: usize,
    /// Number of entries in the chunk.
    entries: u64,
    last_sent: Instant,
    lost: u64,
}

/// Sends whole chunks to the recorder of this host.
#[derive(Debug)]
pub struct ChunkSender {
    publisher: RecordPublisher,
    presence: Presence,
    lockstep: bool,
}

impl ChunkSender {
    /// The sender for chunks of at most `chunk_bytes`.
    ///
    /// # Errors
    /// The port cannot be created.
    pub fn new(
        services: &Services,
        presence: Presence,
        chunk_bytes: usize,
    ) -> Result<Self, BusError> {
        Ok(Self {
            publisher: services.record_publisher(chunk_bytes)?,
            presence,
            lockstep: services.lockstep(),
        })
    }

    /// Sends a chunk and returns whether the recorder received it. In lockstep it waits while the recorder's
    /// queue is full; the launcher ends a recorder that hangs.
    pub fn deliver(&self, chunk: &[u8]) -> bool {
        loop {
            let sent = self
                .publisher
                .loan_slice_uninit(chunk.len())
                .map(|sample| sample.write_from_slice(chunk))
                .map(|sample| sample.send());
            match sent {
                Ok(Ok(1..)) => return true,
                Ok(Ok(0)) | Err(_) if self.lockstep && self.recorder_lives() => {
                    self.presence.show();
                    std::thread::sleep(RETRY_PERIOD);
                }
                _ => return false,
            }
        }
    }

    /// Waits until the recorder has taken what was sent, as long as it lives. To be called before the sender is dropped:
    /// a recorder that has not looked since the sender was made never learns of it, and its chunks are lost.
    pub fn await_taken(&self) {
        let page = self.presence.wake_page();
        let (before, begin) = (page.emptied(), Instant::now());
        // The look that ends next may have begun before the last chunk was sent; the one after it has not.
        while page.emptied().wrapping_sub(before) < 2
            && self.recorder_lives()
            && begin.elapsed() < TAKE_TIMEOUT
        {
            self.presence.show();
            std::thread::sleep(RETRY_PERIOD);
        }
    }

    /// Whether there is still a recorder that may take chunks.
    pub fn recorder_lives(&self) -> bool {
        !self.presence.wake_page().recorder_gone() && self.presence.check_launcher().is_ok()
    }
}

impl RecordSender {
    /// The sender of `source` (0: the plant, i + 1: robot i), with chunks of `chunk_bytes`. Without
    /// `recording` it discards everything.
    ///
    /// # Errors
    /// The port cannot be created.
    pub fn new(
        services: &Services,
        presence: Presence,
        source: u32,
        chunk_bytes: usize,
        recording: bool,
    ) -> Result<Self, BusError> {
        let port = recording
            .then(|| ChunkSender::new(services, presence, chunk_bytes))
            .transpose()?;
        let mut chunk = vec![0; chunk_bytes];
        chunk[..SOURCE_BYTES].copy_from_slice(&source.to_le_bytes());
        Ok(Self {
            port,
            chunk,
            used: SOURCE_BYTES,
            entries: 0,
            last_sent: Instant::now(),
            lost: 0,
        })
    }

    /// Sends the chunk if [`FLUSH_PERIOD`] has passed. To be called once per tick.
    pub fn flush_if_due(&mut self) {
        trace::drain_if_long(|t_ns, bytes| self.trace(t_ns, bytes));
        if (self.entries > 0 || trace::buffered_bytes() > 0)
            && self.last_sent.elapsed() >= FLUSH_PERIOD
        {
            self.flush();
        }
    }

    /// Sends everything, including the buffered trace.
    pub fn flush(&mut self) {
        trace::drain(|t_ns, bytes| self.trace(t_ns, bytes));
        self.send();
    }

    /// Sends everything and waits until the recorder has taken it. To be called at the end of a process.
    pub fn finish(&mut self) {
        self.flush();
        if let Some(port) = &self.port {
            port.await_taken();
        }
    }

    fn send(&mut self) {
        self.last_sent = Instant::now();
        if self.entries > 0 {
            let chunk = &self.chunk[..self.used];
            let delivered = self.port.as_ref().is_none_or(|port| port.deliver(chunk));
            self.lost += if delivered { 0 } else { self.entries };
        }
        self.used = SOURCE_BYTES;
        self.entries = 0;
    }

    /// Number of entries that did not reach the recorder, because it was gone or too slow.
    pub fn lost(&self) -> u64 {
        self.lost + trace::lost()
    }

    /// Appends an entry of at most `max_bytes` to the chunk; sends the chunk first if it is too
    /// full.
    fn append(&mut self, entry: &Entry<'_>, max_bytes: usize) {
        if self.chunk.len() - self.used < max_bytes {
            self.send();
        }
        match postcard::to_slice(entry, &mut self.chunk[self.used..]) {
            Ok(written) => {
                self.used += written.len();
                self.entries += 1;
            }
            Err(_) => self.lost += 1,
        }
    }
}

impl Recorder for RecordSender {
    fn record(&mut self, record: &Record) {
        if self.port.is_none() {
            return;
        }
        trace::trace_applied(record);
        // The recording contains inner ticks in the trace only.
        if !matches!(record, Record::Inner(_)) {
            self.append(&Entry::Record(*record), MAX_RECORD_BYTES);
        }
        trace::drain_if_long(|t_ns, bytes| self.trace(t_ns, bytes));
    }

    fn trace(&mut self, t_ns: i64, bytes: &[u8]) {
        if self.port.is_some() {
            let max_bytes = bytes.len() + MAX_RECORD_BYTES;
            self.append(&Entry::Trace { t_ns, bytes }, max_bytes);
        }
    }
}

/// The receiving side, in the recorder.
#[derive(Debug)]
pub struct RecordReceiver {
    subscriber: RecordSubscriber,
    presence: Presence,
}

impl RecordReceiver {
    /// Opens the recorder's port.
    ///
    /// # Errors
    /// The port cannot be created.
    pub fn new(services: &Services, presence: Presence) -> Result<Self, BusError> {
        Ok(Self {
            subscriber: services.record_subscriber()?,
            presence,
        })
    }

    /// Receives one chunk if available, calls `each` with the source and every entry, and returns
    /// whether there was one. Never blocks.
    ///
    /// # Errors
    /// The transport failed, or the chunk does not decode.
    pub fn poll(&self, mut each: impl FnMut(u32, Entry<'_>)) -> Result<bool, BusError> {
        let decoded = self.poll_chunk(|chunk| decode_chunk(chunk, &mut each))?;
        Ok(decoded.transpose()?.is_some())
    }

    /// Receives one chunk if available and returns what `with` makes of it. Never blocks.
    ///
    /// # Errors
    /// The transport failed.
    pub fn poll_chunk<T>(&self, with: impl FnOnce(&[u8]) -> T) -> Result<Option<T>, BusError> {
        let sample = self
            .subscriber
            .receive()
            .map_err(|e| BusError::failed("records", e))?;
        if sample.is_none() {
            self.presence.wake_page().count_emptied();
        }
        Ok(sample.map(|sample| with(sample.payload())))
    }
}

/// The robot whose agent sent a chunk; `None` for a chunk of the plant, or one that is damaged.
pub fn source_of(chunk: &[u8]) -> Option<RobotIndex> {
    let source = chunk.first_chunk::<SOURCE_BYTES>()?;
    u32::from_le_bytes(*source).checked_sub(1)
}

/// Calls `each` with the source and every entry of a chunk.
///
/// # Errors
/// The chunk does not decode. `each` has then seen the entries before the damage.
pub fn decode_chunk<'a>(
    chunk: &'a [u8],
    each: &mut impl FnMut(u32, Entry<'a>),
) -> Result<(), BusError> {
    let Some((source, mut rest)) = chunk.split_first_chunk::<SOURCE_BYTES>() else {
        return Err(BusError::failed("records", "a chunk without a source"));
    };
    let source = u32::from_le_bytes(*source);
    while !rest.is_empty() {
        let (entry, after) =
            postcard::take_from_bytes(rest).map_err(|e| BusError::failed("records", e))?;
        each(source, entry);
        rest = after;
    }
    Ok(())
}
