//! Trace buffer of one thread: encoded records in chunks, waiting to be drained.

use tracing::{Level, Metadata};

use slipstream_bus::trace::{CALL_SITE_TAG, RECORD_TAG};

use super::fields::Fields;
use super::varint;

/// Size above which new records are dropped (bytes).
pub(super) const MAX_BUFFERED: usize = 1 << 20;
/// Size of the largest chunk, and so of the largest record (bytes).
pub(super) const MAX_CHUNK: usize = 3 << 10;
/// Number of call sites for which a new chunk reserves memory.
const CALL_SITES: usize = 32;
/// Prefix of a chunk: time of its first record (8 bytes), length (4 bytes).
const PREFIX: usize = 12;

/// A record to be encoded.
#[derive(Debug, Clone, Copy)]
pub(super) struct NewRecord<'a> {
    pub(super) process: &'a str,
    pub(super) metadata: &'static Metadata<'static>,
    pub(super) begin_ns: i64,
    /// Duration of a span (ns); `None` for an event.
    pub(super) duration_ns: Option<i64>,
    pub(super) fields: &'a Fields,
}

/// Chunks one after the other; records are appended to the last one.
#[derive(Debug, Default)]
pub(super) struct TraceBuffer {
    bytes: Vec<u8>,
    /// Offset of the open chunk; the end of `bytes` if none is open.
    chunk: usize,
    /// Call sites of the open chunk.
    call_sites: Vec<&'static Metadata<'static>>,
    /// Begin of the last record of the open chunk (ns).
    last_ns: i64,
    /// Number of dropped records.
    pub(super) lost: u64,
}

impl TraceBuffer {
    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Returns the chunks and continues in `empty`.
    pub(super) fn exchange(&mut self, empty: Vec<u8>) -> Vec<u8> {
        self.chunk = empty.len();
        std::mem::replace(&mut self.bytes, empty)
    }

    /// Appends a record to the open chunk, or to a new one if it does not fit.
    pub(super) fn write(&mut self, record: NewRecord<'_>) {
        let open = self.chunk < self.bytes.len();
        if self.bytes.len() > MAX_BUFFERED {
            self.lost += 1;
        } else if !(open && self.append(record)) {
            self.begin_chunk(record.begin_ns);
            if !self.append(record) {
                self.bytes.truncate(self.chunk);
                self.lost += 1;
            }
        }
    }

    fn begin_chunk(&mut self, begin_ns: i64) {
        self.chunk = self.bytes.len();
        self.call_sites.clear();
        // Allocates only once, because no loop has more call sites.
        self.call_sites.reserve(CALL_SITES);
        self.last_ns = 0;
        self.bytes.extend_from_slice(&begin_ns.to_le_bytes());
        self.bytes.extend_from_slice(&[0; PREFIX - 8]);
    }

    /// Appends a record to the open chunk. Returns false if it does not fit.
    fn append(&mut self, record: NewRecord<'_>) -> bool {
        let (before, known) = (self.bytes.len(), self.call_sites.len());
        let call_site = self.call_site(&record);
        let since_previous_ns = record.begin_ns.wrapping_sub(self.last_ns);
        // Encoded like `Entry::Record`; the fields are encoded already.
        let bytes = &mut self.bytes;
        bytes.push(RECORD_TAG);
        varint::unsigned(call_site.into(), bytes);
        varint::signed(since_previous_ns, bytes);
        bytes.push(record.duration_ns.is_some().into());
        if let Some(duration_ns) = record.duration_ns {
            varint::signed(duration_ns, bytes);
        }
        varint::unsigned(record.fields.count.into(), bytes);
        self.bytes.extend_from_slice(&record.fields.bytes);
        let length = self.bytes.len() - self.chunk - PREFIX;
        if length > MAX_CHUNK {
            self.bytes.truncate(before);
            self.call_sites.truncate(known);
            return false;
        }
        self.last_ns = record.begin_ns;
        // `MAX_CHUNK` fits four bytes.
        let length = (length as u32).to_le_bytes();
        self.bytes[self.chunk + 8..self.chunk + PREFIX].copy_from_slice(&length);
        true
    }

    /// Number of the record's call site in the open chunk; writes the call site first if it is new.
    fn call_site(&mut self, record: &NewRecord<'_>) -> u32 {
        let mut known = self.call_sites.iter();
        let found = known.position(|&call_site| std::ptr::eq(call_site, record.metadata));
        let call_site = found.unwrap_or_else(|| {
            self.write_call_site(record);
            self.call_sites.push(record.metadata);
            self.call_sites.len() - 1
        });
        call_site as u32
    }

    /// Encodes like `Entry::CallSite`. Writing to memory cannot fail.
    fn write_call_site(&mut self, record: &NewRecord<'_>) {
        let (metadata, fields) = (record.metadata, record.metadata.fields());
        let head = (
            CALL_SITE_TAG,
            record.process,
            level(metadata),
            metadata.name(),
            fields.len() as u32,
        );
        let _ = postcard::to_io(&head, &mut self.bytes);
        for field in fields {
            let _ = postcard::to_io(field.name(), &mut self.bytes);
        }
    }
}

fn level(metadata: &Metadata<'_>) -> u8 {
    match *metadata.level() {
        Level::ERROR => 1,
        Level::WARN => 2,
        Level::INFO => 3,
        Level::DEBUG => 4,
        Level::TRACE => 5,
    }
}

/// Calls `each` with the time of the first record (ns) and the bytes of every complete chunk.
pub fn chunks(mut buffer: &[u8], mut each: impl FnMut(i64, &[u8])) {
    while let Some((first_ns, chunk, rest)) = split(buffer) {
        each(first_ns, chunk);
        buffer = rest;
    }
}

/// Splits off the first chunk: time of its first record (ns), its bytes, the rest.
fn split(buffer: &[u8]) -> Option<(i64, &[u8], &[u8])> {
    let (first_ns, rest) = buffer.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
    let (chunk, rest) = rest.split_at_checked(length)?;
    Some((i64::from_le_bytes(*first_ns), chunk, rest))
}
