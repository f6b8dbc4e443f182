//! What a thread has told and nobody has taken in: pieces, one after the other.

use tracing::{Level, Metadata};

use super::fields::Fields;
use super::piece::{KIND, TOLD};
use super::varint;

/// Bytes that wait on a tape before records are dropped.
pub(super) const ROOM: usize = 1 << 20;
/// No piece is longer (bytes), and so no record.
pub(super) const PIECE: usize = 3 << 10;
/// Kinds that there is room for from the start.
const KINDS: usize = 32;
/// Before each piece: the time of its first record (8 bytes) and its length (4).
const PREFIX: usize = 12;

/// A record as it is told.
#[derive(Debug, Clone, Copy)]
pub(super) struct Telling<'a> {
    pub(super) process: &'a str,
    pub(super) metadata: &'static Metadata<'static>,
    pub(super) begin_ns: i64,
    /// From beginning to closing (ns); none for an event.
    pub(super) took_ns: Option<i64>,
    pub(super) fields: &'a Fields,
}

/// Pieces, of which the last is open.
#[derive(Debug, Default)]
pub(super) struct Tape {
    bytes: Vec<u8>,
    /// Where the open piece begins; none is open at the end of the bytes.
    piece: usize,
    /// The kinds that the open piece knows.
    kinds: Vec<&'static Metadata<'static>>,
    /// When the last record of the open piece began (ns).
    last_ns: i64,
    /// Records that found no room.
    pub(super) lost: u64,
}

impl Tape {
    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Gives the pieces away, and goes on in `room`.
    pub(super) fn exchange(&mut self, room: Vec<u8>) -> Vec<u8> {
        self.piece = room.len();
        std::mem::replace(&mut self.bytes, room)
    }

    /// Writes a record: into the open piece, or into a new one if that gets too long.
    pub(super) fn write(&mut self, told: Telling<'_>) {
        let open = self.piece < self.bytes.len();
        if self.bytes.len() > ROOM {
            self.lost += 1;
        } else if !(open && self.append(told)) {
            self.begin_piece(told.begin_ns);
            if !self.append(told) {
                self.bytes.truncate(self.piece);
                self.lost += 1;
            }
        }
    }

    fn begin_piece(&mut self, begin_ns: i64) {
        self.piece = self.bytes.len();
        self.kinds.clear();
        // Once: no loop tells of more kinds.
        self.kinds.reserve(KINDS);
        self.last_ns = 0;
        self.bytes.extend_from_slice(&begin_ns.to_le_bytes());
        self.bytes.extend_from_slice(&[0; PREFIX - 8]);
    }

    /// Writes a record into the open piece, if it has room for it.
    fn append(&mut self, told: Telling<'_>) -> bool {
        let (before, known) = (self.bytes.len(), self.kinds.len());
        let kind = self.kind(&told);
        let after_ns = told.begin_ns.wrapping_sub(self.last_ns);
        // As an `Entry::Told`, whose fields are encoded already.
        let bytes = &mut self.bytes;
        bytes.push(TOLD);
        varint::unsigned(kind.into(), bytes);
        varint::signed(after_ns, bytes);
        bytes.push(told.took_ns.is_some().into());
        if let Some(took_ns) = told.took_ns {
            varint::signed(took_ns, bytes);
        }
        varint::unsigned(told.fields.count.into(), bytes);
        self.bytes.extend_from_slice(&told.fields.bytes);
        let length = self.bytes.len() - self.piece - PREFIX;
        if length > PIECE {
            self.bytes.truncate(before);
            self.kinds.truncate(known);
            return false;
        }
        self.last_ns = told.begin_ns;
        // A piece is shorter than four bytes can tell.
        let length = (length as u32).to_le_bytes();
        self.bytes[self.piece + 8..self.piece + PREFIX].copy_from_slice(&length);
        true
    }

    /// The number of a record's kind, which the piece gets to know if need be.
    fn kind(&mut self, told: &Telling<'_>) -> u32 {
        let mut known = self.kinds.iter();
        let found = known.position(|&kind| std::ptr::eq(kind, told.metadata));
        let kind = found.unwrap_or_else(|| {
            self.write_kind(told);
            self.kinds.push(told.metadata);
            self.kinds.len() - 1
        });
        kind as u32
    }

    /// As an `Entry::Kind`, in parts. Writing to memory cannot fail.
    fn write_kind(&mut self, told: &Telling<'_>) {
        let (metadata, fields) = (told.metadata, told.metadata.fields());
        let head = (
            KIND,
            told.process,
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

/// Shows `each` the pieces of a tape's bytes with the time of the first record (ns), as far as they
/// are whole.
pub fn pieces(mut tape: &[u8], mut each: impl FnMut(i64, &[u8])) {
    while let Some((first_ns, piece, rest)) = split(tape) {
        each(first_ns, piece);
        tape = rest;
    }
}

/// The first piece of a tape: the time of its first record (ns) and its bytes; and the rest.
fn split(tape: &[u8]) -> Option<(i64, &[u8], &[u8])> {
    let (first_ns, rest) = tape.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
    let (piece, rest) = rest.split_at_checked(length)?;
    Some((i64::from_le_bytes(*first_ns), piece, rest))
}
