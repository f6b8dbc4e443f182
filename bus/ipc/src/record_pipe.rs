//! Records on their way to the recorder: chunks of bytes over shared memory.
//!
//! A chunk is the source's number and its entries, postcard-encoded one after the other: records, and
//! what the thread's trace has told meanwhile. A source sends its chunk when it is full, and at the
//! latest after [`PERIOD`] of wall time.

use std::rc::Rc;
use std::time::{Duration, Instant};

use crate::wake_page::WakePage;
use serde::{Deserialize, Serialize};

use crate::services::{RecordPublisher, RecordSubscriber, Services};
use crate::trace;
use slipstream_bus::record::{Record, Recorder};
use slipstream_bus::transport::BusError;

/// Wall time after which a chunk goes out even when it is not full.
pub const PERIOD: Duration = Duration::from_millis(100);
/// How long a source in lockstep waits for a recorder that does not keep up.
const TIMEOUT: Duration = Duration::from_secs(2);
/// Bytes of the source's number.
const HEADER: usize = 4;
/// No record takes more bytes: sixteen varint-encoded times and numbers of ten bytes at most.
const LARGEST: usize = 256;

/// What a chunk holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Entry<'a> {
    /// A record.
    Record(Record),
    /// A piece of the trace.
    Trace {
        /// When its first record was.
        t_ns: i64,
        /// Its records (`trace.rs`).
        bytes: &'a [u8],
    },
}

/// A source's end.
#[derive(Debug)]
pub struct RecordSender {
    publisher: Option<RecordPublisher>,
    wake_page: Rc<WakePage>,
    chunk: Vec<u8>,
    used: usize,
    in_chunk: u64,
    sent: Instant,
    waits: bool,
    lost: u64,
}

impl RecordSender {
    /// The end of `source` (0: the plant, i + 1: robot i), with chunks of so many bytes. Without
    /// `recording` nothing is kept.
    ///
    /// # Errors
    /// When the port cannot be made.
    pub fn new(
        services: &Services,
        wake_page: Rc<WakePage>,
        source: u32,
        chunk: usize,
        recording: bool,
    ) -> Result<Self, BusError> {
        let publisher = recording
            .then(|| services.record_publisher(chunk))
            .transpose()?;
        let mut bytes = vec![0; chunk];
        bytes[..HEADER].copy_from_slice(&source.to_le_bytes());
        Ok(Self {
            publisher,
            wake_page,
            chunk: bytes,
            used: HEADER,
            in_chunk: 0,
            sent: Instant::now(),
            waits: services.lockstep(),
            lost: 0,
        })
    }

    /// Sends what has waited long enough. To be called once a round.
    pub fn flush_if_due(&mut self) {
        trace::drain_if_long(|t_ns, bytes| self.trace(t_ns, bytes));
        if (self.in_chunk > 0 || trace::buffered_bytes() > 0) && self.sent.elapsed() >= PERIOD {
            self.flush();
        }
    }

    /// Sends what there is.
    pub fn flush(&mut self) {
        trace::drain(|t_ns, bytes| self.trace(t_ns, bytes));
        self.send();
    }

    fn send(&mut self) {
        self.sent = Instant::now();
        if self.in_chunk > 0 && !self.deliver() {
            self.lost += self.in_chunk;
        }
        self.used = HEADER;
        self.in_chunk = 0;
    }

    /// Records that did not reach the recorder, because it was gone or did not keep up.
    pub fn lost(&self) -> u64 {
        self.lost + trace::lost()
    }

    /// Puts an entry of at most so many bytes into the chunk.
    fn put(&mut self, entry: &Entry<'_>, largest: usize) {
        if self.chunk.len() - self.used < largest {
            self.send();
        }
        match postcard::to_slice(entry, &mut self.chunk[self.used..]) {
            Ok(written) => {
                self.used += written.len();
                self.in_chunk += 1;
            }
            Err(_) => self.lost += 1,
        }
    }

    /// Hands the chunk to the recorder. In lockstep waits while its queue is full.
    fn deliver(&self) -> bool {
        let Some(publisher) = &self.publisher else {
            return true;
        };
        let begin = Instant::now();
        loop {
            let sent = publisher
                .loan_slice_uninit(self.used)
                .map(|sample| sample.write_from_slice(&self.chunk[..self.used]))
                .map(|sample| sample.send());
            match sent {
                Ok(Ok(1..)) => return true,
                Ok(Ok(0)) | Err(_) if self.waits && !self.wake_page.recorder_gone() => {
                    if begin.elapsed() > TIMEOUT {
                        return false;
                    }
                    std::thread::sleep(Duration::from_micros(200));
                }
                _ => return false,
            }
        }
    }
}

impl Recorder for RecordSender {
    fn record(&mut self, record: &Record) {
        if self.publisher.is_none() {
            return;
        }
        trace::trace_applied(record);
        // Of an inner tick the recording keeps the trace alone.
        if !matches!(record, Record::Inner(_)) {
            self.put(&Entry::Record(*record), LARGEST);
        }
        trace::drain_if_long(|t_ns, bytes| self.trace(t_ns, bytes));
    }

    fn trace(&mut self, t_ns: i64, bytes: &[u8]) {
        if self.publisher.is_some() {
            self.put(&Entry::Trace { t_ns, bytes }, bytes.len() + LARGEST);
        }
    }
}

/// The recorder's end.
#[derive(Debug)]
pub struct RecordReceiver {
    subscriber: RecordSubscriber,
}

impl RecordReceiver {
    /// The end of the run's recorder.
    ///
    /// # Errors
    /// When the port cannot be made.
    pub fn new(services: &Services) -> Result<Self, BusError> {
        Ok(Self {
            subscriber: services.record_subscriber()?,
        })
    }

    /// Takes in one chunk, if there is one: `each` hears the source and each entry.
    ///
    /// # Errors
    /// When the transport failed or a chunk is not what a source sends.
    pub fn take(&self, mut each: impl FnMut(u32, Entry<'_>)) -> Result<bool, BusError> {
        let failed = |e| BusError::failed("records", e);
        let Some(sample) = self
            .subscriber
            .receive()
            .map_err(|e| BusError::failed("records", e))?
        else {
            return Ok(false);
        };
        let bytes: &[u8] = sample.payload();
        let Some((header, mut rest)) = bytes.split_first_chunk::<HEADER>() else {
            return Err(BusError::failed("records", "a chunk without a source"));
        };
        let source = u32::from_le_bytes(*header);
        while !rest.is_empty() {
            let (entry, after) = postcard::take_from_bytes::<Entry<'_>>(rest).map_err(failed)?;
            each(source, entry);
            rest = after;
        }
        Ok(true)
    }
}
