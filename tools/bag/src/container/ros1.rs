//! Damage-tolerant sequential reader of ROS 1 bags (format 2.0).
//!
//! A bag is a sequence of records; each has a header of named fields, and data. The index at the end is not used, so
//! that a bag without one (a recorder that was killed) is read like any other. Of a damaged chunk, the messages before
//! the damage are read.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use slipstream_bus::InputError;

use super::channels::Channels;
use super::chunk::{MAX_CHUNK_BYTES, unpack_as_far};
use super::item::{ChannelInfo, Undecodable, Visit, Wanted, ros2_name};
use super::loss::Loss;

/// First bytes of every bag of this format.
const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

/// Kinds of records (field `op`).
mod op {
    pub(super) const MESSAGE: u8 = 2;
    pub(super) const CHUNK: u8 = 5;
    pub(super) const CONNECTION: u8 = 7;
}

/// Reads all of `source`, which has `size` bytes, and calls `visit` with each item. `path` is used in errors only.
///
/// # Errors
/// If it is not a ROS 1 bag of format 2.0, or reading fails. Damage is not an error but a [`Loss`].
pub(super) fn read_ros1(
    source: &mut dyn Read,
    size: u64,
    path: &Path,
    wanted: &Wanted<'_>,
    visit: &mut Visit<'_>,
) -> Result<Loss, InputError> {
    let unreadable = |e: io::Error| InputError::unreadable(path, &e);
    let mut magic = Vec::new();
    let start = MAGIC.len() as u64;
    source
        .take(start)
        .read_to_end(&mut magic)
        .map_err(unreadable)?;
    if magic != MAGIC {
        let remedy = "convert older bags with `rosbag fix`";
        return Err(InputError::file(
            path,
            "is not a ROS 1 bag of format 2.0",
            remedy,
        ));
    }
    let mut reader = Ros1Reader {
        connections: Channels::new(wanted, visit),
        loss: Loss::default(),
        unpacked: Vec::new(),
    };
    let read = reader.records(source).map_err(unreadable)?;
    if let RecordsEnd::Damaged { bytes_read } = read {
        reader.loss.truncated = true;
        reader.loss.bytes_at_end = size.saturating_sub(start + bytes_read);
    }
    Ok(reader.loss)
}

/// How a sequence of records ended.
#[derive(Clone, Copy, PartialEq)]
enum RecordsEnd {
    Complete,
    /// After this many bytes of complete records.
    Damaged {
        bytes_read: u64,
    },
}

struct Ros1Reader<'a> {
    /// Topics by the number of their connection.
    connections: Channels<'a>,
    loss: Loss,
    /// The decompressed records of the current chunk; kept to save allocations.
    unpacked: Vec<u8>,
}

impl Ros1Reader<'_> {
    /// Reads all records of a file.
    fn records(&mut self, source: &mut dyn Read) -> io::Result<RecordsEnd> {
        let (mut header, mut data) = (Vec::new(), Vec::new());
        let mut bytes_read = 0;
        loop {
            match read_block(source, &mut header)? {
                BlockRead::Whole => {}
                BlockRead::None => return Ok(RecordsEnd::Complete),
                BlockRead::Cut => return Ok(RecordsEnd::Damaged { bytes_read }),
            }
            let is_whole = read_block(source, &mut data)? == BlockRead::Whole;
            let is_chunk = field(&header, b"op") == Some(&[op::CHUNK]);
            // A chunk whose end is missing still has messages.
            if is_chunk {
                self.chunk(&header, &data);
            } else if is_whole {
                self.record(&header, &data);
            }
            if !is_whole {
                return Ok(RecordsEnd::Damaged { bytes_read });
            }
            bytes_read += (8 + header.len() + data.len()) as u64;
        }
    }

    /// Processes a record that is no chunk.
    fn record(&mut self, header: &[u8], data: &[u8]) {
        match field(header, b"op").unwrap_or_default() {
            [op::CONNECTION] => {
                let added = self.connection(header, data);
                self.loss.damaged_records += u64::from(added.is_none());
            }
            [op::MESSAGE] => match self.message(header, data) {
                Ok(()) => self.loss.messages_read += 1,
                Err(Undecodable) => self.loss.undecodable_messages += 1,
            },
            [_] => {}
            _ => self.loss.damaged_records += 1,
        }
    }

    fn chunk(&mut self, header: &[u8], data: &[u8]) {
        let compression = field(header, b"compression").unwrap_or_default();
        let is_complete = if compression == b"none" {
            self.inner_records(data).is_some()
        } else {
            let mut unpacked = std::mem::take(&mut self.unpacked);
            unpacked.clear();
            let is_unpacked = unpack_as_far(compression, data, &mut unpacked).is_ok();
            let is_read = self.inner_records(&unpacked).is_some();
            self.unpacked = unpacked;
            is_unpacked && is_read
        };
        self.loss.damaged_chunks += u64::from(!is_complete);
    }

    /// Processes the records of a chunk. `None` if the last one is not complete.
    fn inner_records(&mut self, mut unread: &[u8]) -> Option<()> {
        while !unread.is_empty() {
            let (header, rest) = split_block(unread)?;
            let (data, rest) = split_block(rest)?;
            self.record(header, data);
            unread = rest;
        }
        Some(())
    }

    /// Registers a connection; of several with the same number, the first one.
    fn connection(&mut self, header: &[u8], data: &[u8]) -> Option<()> {
        let id = u32::from_le_bytes(field(header, b"conn")?.try_into().ok()?);
        if self.connections.has(id) {
            return Some(());
        }
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let definition = field(data, b"message_definition").unwrap_or_default();
        let channel = ChannelInfo {
            topic: text(field(header, b"topic")?),
            schema: ros2_name(&text(field(data, b"type")?)),
            encoding: "ros1".to_owned(),
            definition: Arc::new(("ros1msg".to_owned(), definition.to_owned())),
            metadata: BTreeMap::new(),
        };
        self.connections.add(id, channel).ok()
    }

    fn message(&mut self, header: &[u8], data: &[u8]) -> Result<(), Undecodable> {
        let number = |bytes: &[u8]| bytes.try_into().map(u32::from_le_bytes).ok();
        let id = field(header, b"conn").and_then(number);
        let log_time_ns = || {
            let (sec, nanosec) = field(header, b"time")?.split_at_checked(4)?;
            let (sec, nanosec) = number(sec).zip(number(nanosec))?;
            Some(u64::from(sec) * 1_000_000_000 + u64::from(nanosec))
        };
        self.connections
            .message(id.ok_or(Undecodable)?, log_time_ns, data)
    }
}

/// What [`read_block`] found.
#[derive(PartialEq)]
enum BlockRead {
    Whole,
    /// Nothing: the source is at its end.
    None,
    /// A part of the block, or a length that no block has.
    Cut,
}

/// Replaces `block` by the next bytes, whose number stands before them.
fn read_block(source: &mut dyn Read, block: &mut Vec<u8>) -> io::Result<BlockRead> {
    block.clear();
    source.take(4).read_to_end(block)?;
    if block.is_empty() {
        return Ok(BlockRead::None);
    }
    let Ok(length) = <[u8; 4]>::try_from(&block[..]) else {
        return Ok(BlockRead::Cut);
    };
    block.clear();
    let length = u64::from(u32::from_le_bytes(length));
    if length > MAX_CHUNK_BYTES {
        return Ok(BlockRead::Cut);
    }
    source.take(length).read_to_end(block)?;
    let is_whole = block.len() as u64 == length;
    Ok(if is_whole {
        BlockRead::Whole
    } else {
        BlockRead::Cut
    })
}

/// The block at the beginning, and what follows it.
fn split_block(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
}

/// The value of a field: each field is `NAME=VALUE`, with its length before it.
fn field<'a>(mut header: &'a [u8], name: &[u8]) -> Option<&'a [u8]> {
    loop {
        let (length, rest) = header.split_first_chunk()?;
        let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
        let (field, rest) = rest.split_at_checked(length)?;
        header = rest;
        let value = field.strip_prefix(name).and_then(|f| f.strip_prefix(b"="));
        if value.is_some() {
            return value;
        }
    }
}
