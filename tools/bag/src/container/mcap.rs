//! Damage-tolerant sequential MCAP reader: returns everything intact and counts what is lost.
//!
//! Chunks that have no message of a wanted topic are passed over where the index at the end tells so.
//! Memory is bounded by the largest chunk (at most `MAX_CHUNK_BYTES`), never by what a damaged
//! length field claims. A chunk is used only if its checksum is right; of a chunk whose end is missing, which has none, the
//! records before the end of the file.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek};
use std::path::Path;
use std::sync::Arc;

use mcap::McapError;
use mcap::records::{Record, op};
use slipstream_bus::InputError;

use super::chunk::{unpack, unpack_as_far};
use super::file::open_file;
use super::item::{ChannelInfo, Item, Schema, Undecodable, Visit, Wanted};
use super::lengths;
use super::loss::Loss;
use super::records::{Next, Records, split_record};
use super::summary::Summary;

/// Reads all of `source`, which has `size` bytes, and calls `visit` with each item.
///
/// # Errors
/// If it is not an MCAP file, or reading fails. Damage is not an error but a [`Loss`].
pub fn read_bag(
    source: impl Read,
    size: u64,
    path: &Path,
    visit: &mut Visit<'_>,
) -> Result<Loss, InputError> {
    read_wanted(source, size, path, &|_| true, visit)
}

/// As [`read_bag`]; of topics that are not wanted, the messages are only counted.
///
/// # Errors
/// As [`read_bag`].
pub(super) fn read_wanted(
    source: impl Read,
    size: u64,
    path: &Path,
    wanted: &Wanted<'_>,
    visit: &mut Visit<'_>,
) -> Result<Loss, InputError> {
    let reader = BagReader::new(path, wanted, visit);
    reader.run(Records::new(source, size, |source, bytes| {
        std::io::copy(&mut source.by_ref().take(bytes), &mut std::io::sink()).map(drop)
    }))
}

/// As [`read_wanted`], from a file: chunks without wanted messages are not read, where its index tells.
///
/// # Errors
/// As [`read_bag`].
pub(super) fn read_file(
    path: &Path,
    wanted: &Wanted<'_>,
    visit: &mut Visit<'_>,
) -> Result<Loss, InputError> {
    let (mut file, size) = open_file(path)?;
    let summary = Summary::read(&mut file);
    file.rewind()
        .map_err(|e| InputError::unreadable(path, &e))?;
    let mut reader = BagReader::new(path, wanted, visit);
    if let Some(summary) = summary {
        reader.use_summary(summary);
    }
    reader.run(Records::new(file, size, |file, bytes| {
        file.seek_relative(i64::try_from(bytes).unwrap_or(i64::MAX))
    }))
}

/// The state of reading one file.
struct BagReader<'a> {
    path: &'a Path,
    wanted: &'a Wanted<'a>,
    visit: &'a mut Visit<'a>,
    loss: Loss,
    /// Names of the message types, by schema id.
    schemas: BTreeMap<u16, Schema>,
    /// Channels, by channel id.
    channels: Vec<Option<KnownChannel>>,
    /// Where chunks begin that have no wanted message.
    unwanted_chunks: BTreeSet<u64>,
    /// The decompressed records of the current chunk; kept to save allocations.
    unpacked: Vec<u8>,
    /// What became of the last chunk: the message indexes after it say how many messages it had.
    last_chunk: LastChunk,
}

/// A channel, and whether its messages are wanted.
#[derive(Clone)]
struct KnownChannel {
    channel: Arc<ChannelInfo>,
    is_wanted: bool,
}

/// What became of a chunk.
#[derive(Clone, Copy, PartialEq)]
enum LastChunk {
    Read,
    Damaged,
    PassedOver,
}

impl<'a> BagReader<'a> {
    fn new(path: &'a Path, wanted: &'a Wanted<'a>, visit: &'a mut Visit<'a>) -> Self {
        Self {
            path,
            wanted,
            visit,
            loss: Loss::default(),
            schemas: BTreeMap::new(),
            channels: Vec::new(),
            unwanted_chunks: BTreeSet::new(),
            unpacked: Vec::new(),
            last_chunk: LastChunk::Read,
        }
    }

    /// Takes the channels of the index, whose own records may stand in a chunk that is passed over.
    fn use_summary(&mut self, summary: Summary) {
        for (id, channel) in summary.channels {
            self.add_channel(id, channel);
        }
        for (start, ids) in summary.chunks {
            let is_unwanted = |id: &u16| {
                let known = self.channels.get(usize::from(*id));
                known
                    .and_then(Option::as_ref)
                    .is_some_and(|known| !known.is_wanted)
            };
            if ids.iter().all(is_unwanted) {
                self.unwanted_chunks.insert(start);
            }
        }
    }

    fn run<S: Read>(mut self, mut records: Records<S>) -> Result<Loss, InputError> {
        let mut data_ended = false;
        let mut started = false;
        let unreadable = |e| InputError::unreadable(self.path, &e);
        let error = loop {
            let start = records.offset();
            let (opcode, length) = match records.next_head().map_err(unreadable)? {
                Next::Record { opcode, length } => (opcode, length),
                Next::End => return Ok(self.loss),
                Next::Damage(error) => break error,
            };
            if opcode == op::CHUNK && self.unwanted_chunks.contains(&start) {
                records.pass_over(length).map_err(unreadable)?;
                self.last_chunk = LastChunk::PassedOver;
                continue;
            }
            if !records.read(length).map_err(unreadable)? {
                break McapError::UnexpectedEof;
            }
            started = true;
            data_ended |= opcode == op::DATA_END;
            self.record(opcode, records.record());
        };
        if !started {
            return Err(self.not_a_bag(records.size(), &error));
        }
        self.loss.truncated = true;
        self.loss.index_only = data_ended;
        self.loss.bytes_at_end = records.size().saturating_sub(records.offset());
        if records.last_opcode() == op::CHUNK {
            self.cut_chunk(records.record());
        }
        Ok(self.loss)
    }

    fn not_a_bag(&self, size: u64, error: &McapError) -> InputError {
        let remedy = "give a bag (MCAP, SQLite or ROS 1) or a folder with recording.toml";
        if size == 0 {
            return InputError::file(self.path, "the file is empty", remedy);
        }
        match error {
            McapError::BadMagic => {
                InputError::file(self.path, "is not a bag of a known kind", remedy)
            }
            other => {
                let problem = format!("is not a complete MCAP file ({other})");
                InputError::file(self.path, problem, remedy)
            }
        }
    }

    /// Processes a record outside of chunks, or a whole chunk.
    fn record(&mut self, opcode: u8, data: &[u8]) {
        match opcode {
            op::CHUNK => {
                self.last_chunk = match self.read_chunk(data) {
                    Ok(()) => LastChunk::Read,
                    Err(_) => LastChunk::Damaged,
                };
                self.loss.damaged_chunks += u64::from(self.last_chunk == LastChunk::Damaged);
            }
            op::MESSAGE_INDEX if self.last_chunk != LastChunk::Read => {
                if let Ok(Record::MessageIndex(index)) = mcap::parse_record(opcode, data) {
                    self.not_read(index.channel_id, index.records.len() as u64);
                }
            }
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::ATTACHMENT | op::METADATA => {
                self.inner_record(opcode, data);
            }
            _ => {}
        }
    }

    /// Counts messages of a chunk that was not read.
    fn not_read(&mut self, channel_id: u16, messages: u64) {
        if self.last_chunk == LastChunk::Damaged {
            self.loss.messages_in_damaged_chunks += messages;
            return;
        }
        let known = self.channels.get(usize::from(channel_id));
        if let Some(known) = known.and_then(Option::as_ref) {
            self.loss.messages_read += messages;
            let channel = &known.channel;
            // Nothing is decoded.
            let _ = (self.visit)(Item::Unwanted { channel, messages });
        }
    }

    /// Processes all records of a chunk, or none if its compression or checksum is wrong.
    fn read_chunk(&mut self, data: &[u8]) -> Result<(), McapError> {
        if !lengths::are_valid(op::CHUNK, data) {
            return Err(McapError::UnexpectedEoc);
        }
        let Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, data)? else {
            return Err(McapError::UnexpectedEoc);
        };
        let mut unpacked = std::mem::take(&mut self.unpacked);
        let read = unpack(&header, &data, &mut unpacked).and_then(|()| self.records(&unpacked));
        self.unpacked = unpacked;
        read
    }

    /// Processes the records of a chunk whose end is missing, as far as they can be decompressed.
    fn cut_chunk(&mut self, record: &[u8]) {
        // Times and size of the chunk, its checksum, the name of its compression with its length, the length of the
        // records.
        let rest = record.get(28..);
        let named = rest.and_then(|rest| {
            let (length, rest) = rest.split_first_chunk()?;
            rest.split_at_checked(u32::from_le_bytes(*length) as usize)
        });
        let Some((compression, Some(data))) = named.map(|(name, rest)| (name, rest.get(8..)))
        else {
            return;
        };
        let mut unpacked = Vec::new();
        // Both end with an error, since the chunk and its last record are not complete.
        let _ = unpack_as_far(compression, data, &mut unpacked);
        let _ = self.records(&unpacked);
    }

    /// Processes the records of a decompressed chunk.
    fn records(&mut self, mut unread: &[u8]) -> Result<(), McapError> {
        while !unread.is_empty() {
            let (opcode, data, rest) = split_record(unread)?;
            self.inner_record(opcode, data);
            unread = rest;
        }
        Ok(())
    }

    /// Processes a record that may also occur inside a chunk.
    fn inner_record(&mut self, opcode: u8, data: &[u8]) {
        let record = lengths::are_valid(opcode, data).then(|| mcap::parse_record(opcode, data));
        let Some(Ok(record)) = record else {
            self.loss.damaged_records += 1;
            return;
        };
        match record {
            Record::Schema { header, data } => {
                let definition = Arc::new((header.encoding, data.into_owned()));
                let schema = (header.name, definition);
                self.schemas.entry(header.id).or_insert(schema);
            }
            Record::Channel(channel) => self.channel(channel),
            Record::Message { header, data } => {
                let known = self.channels.get(usize::from(header.channel_id));
                let visited = match known.and_then(Option::as_ref) {
                    Some(KnownChannel { channel, is_wanted }) => (self.visit)(match is_wanted {
                        true => Item::Message {
                            id: header.channel_id.into(),
                            channel,
                            log_time_ns: header.log_time,
                            data: &data,
                        },
                        false => Item::Unwanted {
                            channel,
                            messages: 1,
                        },
                    }),
                    None => Err(Undecodable),
                };
                match visited {
                    Ok(()) => self.loss.messages_read += 1,
                    Err(Undecodable) => self.loss.undecodable_messages += 1,
                }
            }
            Record::Attachment { header, data, .. } => {
                let item = Item::Attachment {
                    name: &header.name,
                    data: &data,
                };
                self.loss.damaged_records += u64::from((self.visit)(item).is_err());
            }
            Record::Metadata(metadata) => {
                let item = Item::Metadata {
                    name: &metadata.name,
                };
                self.loss.damaged_records += u64::from((self.visit)(item).is_err());
            }
            _ => {}
        }
    }

    /// Registers a channel; of several with the same id, the first one.
    fn channel(&mut self, channel: mcap::records::Channel) {
        let id = channel.id;
        let known = self.channels.get(usize::from(id));
        if known.is_none_or(Option::is_none) {
            let schema = self.schemas.get(&channel.schema_id).cloned();
            let info = ChannelInfo::new(channel, schema.unwrap_or_default());
            self.add_channel(id, Arc::new(info));
        }
    }

    fn add_channel(&mut self, id: u16, channel: Arc<ChannelInfo>) {
        let place = usize::from(id);
        if self.channels.len() <= place {
            self.channels.resize(place + 1, None);
        }
        let item = Item::Channel {
            id: id.into(),
            channel: &channel,
        };
        self.loss.damaged_records += u64::from((self.visit)(item).is_err());
        let is_wanted = (self.wanted)(&channel);
        if let Some(slot) = self.channels.get_mut(place) {
            *slot = Some(KnownChannel { channel, is_wanted });
        }
    }
}
