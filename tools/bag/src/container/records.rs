//! The records of an MCAP file, one after the other.

use std::io::{self, Read};

use mcap::McapError;
use mcap::records::op;

use super::chunk::MAX_CHUNK_BYTES;

/// Opcode and length of a record.
pub(super) const HEAD_BYTES: usize = 9;
/// Size of the footer's content (bytes).
pub(super) const FOOTER_BYTES: usize = 20;

/// What comes next in a file.
pub(super) enum Next {
    /// A record with this opcode and this many bytes, which are to be read or passed over.
    Record { opcode: u8, length: u64 },
    /// The end of a complete file.
    End,
    /// Something that is no record: what follows cannot be read.
    Damage(McapError),
}

/// Reads records. A record is in memory once, however long it is.
pub(super) struct Records<S> {
    source: S,
    /// Passes over bytes of the source.
    pass_over: fn(&mut S, u64) -> io::Result<()>,
    /// Size of the file (bytes): at least that, if it is compressed.
    size: u64,
    /// The content of the record; of one that is cut, what there is.
    record: Vec<u8>,
    last_opcode: u8,
    /// Where the next record begins (bytes).
    offset: u64,
}

impl<S: Read> Records<S> {
    pub(super) fn new(source: S, size: u64, pass_over: fn(&mut S, u64) -> io::Result<()>) -> Self {
        Self {
            source,
            pass_over,
            size,
            record: Vec::new(),
            last_opcode: 0,
            offset: 0,
        }
    }

    /// Where the next record begins (bytes): all before it is complete.
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// Size of the file (bytes): at least that, if it is compressed.
    pub(super) fn size(&self) -> u64 {
        self.size
    }

    /// The content of the last record that was read.
    pub(super) fn record(&self) -> &[u8] {
        &self.record
    }

    /// Reads the head of the next record.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn next_head(&mut self) -> io::Result<Next> {
        if self.offset == 0 {
            self.fill(mcap::MAGIC.len() as u64)?;
            if self.record.len() < mcap::MAGIC.len() {
                return Ok(Next::Damage(McapError::UnexpectedEof));
            }
            if self.record != mcap::MAGIC {
                return Ok(Next::Damage(McapError::BadMagic));
            }
            self.offset = self.record.len() as u64;
        }
        self.fill(HEAD_BYTES as u64)?;
        if self.last_opcode == op::FOOTER {
            return Ok(match self.record == mcap::MAGIC {
                true => Next::End,
                false => Next::Damage(McapError::BadMagic),
            });
        }
        let Some((&[opcode, ref length @ ..], _)) = self.record.split_first_chunk::<HEAD_BYTES>()
        else {
            self.record.clear();
            return Ok(Next::Damage(McapError::UnexpectedEof));
        };
        let length = u64::from_le_bytes(*length);
        self.last_opcode = opcode;
        if length > self.size.clamp(64, MAX_CHUNK_BYTES) {
            // A chunk whose end is missing still has messages.
            self.fill(MAX_CHUNK_BYTES)?;
            let error = McapError::RecordTooLarge {
                opcode,
                len: length,
            };
            return Ok(Next::Damage(error));
        }
        Ok(Next::Record { opcode, length })
    }

    /// Reads the content of a record. Returns whether it is complete.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn read(&mut self, length: u64) -> io::Result<bool> {
        self.fill(length)?;
        let least = match self.last_opcode {
            op::FOOTER => FOOTER_BYTES as u64,
            op::DATA_END => 4,
            _ => 0,
        };
        let is_whole = self.record.len() as u64 == length && length >= least;
        if is_whole {
            self.offset += HEAD_BYTES as u64 + length;
        }
        Ok(is_whole)
    }

    /// Passes over the content of a record, which the index says is complete.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn pass_over(&mut self, length: u64) -> io::Result<()> {
        (self.pass_over)(&mut self.source, length)?;
        self.offset += HEAD_BYTES as u64 + length;
        Ok(())
    }

    /// The opcode of the record whose head was read last.
    pub(super) fn last_opcode(&self) -> u8 {
        self.last_opcode
    }

    /// Replaces the record by the next bytes, as far as there are any.
    fn fill(&mut self, length: u64) -> io::Result<()> {
        self.record.clear();
        self.source
            .by_ref()
            .take(length)
            .read_to_end(&mut self.record)?;
        Ok(())
    }
}

/// The next of several records in memory, and what follows it: opcode, content, rest.
///
/// # Errors
/// If it is not complete.
pub(super) fn split_record(records: &[u8]) -> Result<(u8, &[u8], &[u8]), McapError> {
    let split = || {
        let (&[opcode, ref length @ ..], rest) = records.split_first_chunk::<HEAD_BYTES>()?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        let (content, rest) = rest.split_at_checked(length)?;
        Some((opcode, content, rest))
    };
    split().ok_or(McapError::UnexpectedEof)
}
