//! Reads an MCAP file from front to back and gives what is whole, whatever happened to the rest.
//!
//! Memory is bounded by the largest chunk (at most [`LARGEST_CHUNK`]), never by what a damaged
//! length claims. A chunk counts only if its checksum is right.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::chunk::{LARGEST_CHUNK, unpack};
use super::lengths;
use super::loss::Loss;
use crate::error::Unusable;

/// A topic of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ChannelInfo {
    pub(crate) topic: String,
    /// The message type's name, such as `sensor_msgs/msg/Imu`; empty where there is none.
    pub(crate) schema: String,
    pub(crate) encoding: String,
    pub(crate) metadata: BTreeMap<String, String>,
}

/// What a file holds.
pub(crate) enum Item<'a> {
    /// A topic, before its messages.
    Channel {
        id: u16,
        channel: &'a Arc<ChannelInfo>,
    },
    /// A message of the channel with this number (numbers may be sparse).
    Message {
        id: u16,
        channel: &'a Arc<ChannelInfo>,
        log_time_ns: u64,
        data: &'a [u8],
    },
    Attachment {
        name: &'a str,
        data: &'a [u8],
    },
    Metadata {
        name: &'a str,
    },
}

/// What a visitor says of an item.
pub(crate) type Visited = Result<(), Undecodable>;

/// The visitor could make nothing of the message.
#[derive(Debug)]
pub(crate) struct Undecodable;

/// Reads all of `source`, which has `size` bytes, and shows each item to `visit`.
///
/// # Errors
/// When it is no MCAP file or the system does not let it be read. Damage is no error but a loss.
pub(crate) fn read_bag(
    source: impl Read,
    size: u64,
    path: &Path,
    visit: &mut dyn FnMut(Item<'_>) -> Visited,
) -> Result<Loss, Unusable> {
    let limit = usize::try_from(size.clamp(64, LARGEST_CHUNK)).unwrap_or(usize::MAX);
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_record_length_limit(limit);
    Reading {
        path,
        visit,
        loss: Loss::default(),
        schemas: BTreeMap::new(),
        channels: Vec::new(),
        unpacked: Vec::new(),
        in_damaged_chunk: false,
    }
    .run(source, size, LinearReader::new_with_options(options))
}

struct Reading<'a> {
    path: &'a Path,
    visit: &'a mut dyn FnMut(Item<'_>) -> Visited,
    loss: Loss,
    schemas: BTreeMap<u16, String>,
    channels: Vec<Option<Arc<ChannelInfo>>>,
    /// The records of the chunk at hand, kept to save allocations.
    unpacked: Vec<u8>,
    /// The last chunk was damaged: the indexes that follow tell how many messages it had.
    in_damaged_chunk: bool,
}

/// How much of a chunk is handed on at a time (bytes).
const FEED: usize = 16 << 10;

impl Reading<'_> {
    fn run(
        mut self,
        mut source: impl Read,
        size: u64,
        mut reader: LinearReader,
    ) -> Result<Loss, Unusable> {
        // Bytes of records that were taken whole, the magic at the start included.
        let mut done = mcap::MAGIC.len() as u64;
        let mut started = false;
        let mut data_ended = false;
        while let Some(event) = reader.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(need)) => {
                    let room = reader.insert(need);
                    let read = source
                        .read(room)
                        .map_err(|e| Unusable::unreadable(self.path, &e))?;
                    reader.notify_read(read);
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    started = true;
                    done += 9 + data.len() as u64;
                    data_ended |= opcode == op::DATA_END;
                    self.record(opcode, data);
                }
                Err(error) => {
                    if !started {
                        return Err(self.no_bag(size, &error));
                    }
                    self.loss.broken_off = true;
                    self.loss.index_only = data_ended;
                    self.loss.bytes_at_end = size.saturating_sub(done);
                    break;
                }
            }
        }
        Ok(self.loss)
    }

    fn no_bag(&self, size: u64, error: &McapError) -> Unusable {
        let remedy = "give an MCAP file or a folder with recording.toml";
        if size == 0 {
            return Unusable::new(self.path, "the file is empty", remedy);
        }
        match error {
            McapError::BadMagic => Unusable::new(self.path, "is no MCAP file", remedy),
            other => {
                let problem = format!("is no whole MCAP file ({other})");
                Unusable::new(self.path, problem, remedy)
            }
        }
    }

    /// A record outside of chunks, or a whole chunk.
    fn record(&mut self, opcode: u8, data: &[u8]) {
        match opcode {
            op::CHUNK => {
                self.in_damaged_chunk = self.read_chunk(data).is_err();
                self.loss.damaged_chunks += u64::from(self.in_damaged_chunk);
            }
            op::MESSAGE_INDEX if self.in_damaged_chunk => {
                if let Ok(Record::MessageIndex(index)) = mcap::parse_record(opcode, data) {
                    self.loss.messages_in_damaged_chunks += index.records.len() as u64;
                }
            }
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::ATTACHMENT | op::METADATA => {
                self.inner_record(opcode, data);
            }
            _ => {}
        }
    }

    /// All records of a chunk, or none where its packing or checksum is wrong.
    fn read_chunk(&mut self, data: &[u8]) -> Result<(), McapError> {
        if !lengths::fit(op::CHUNK, data) {
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

    fn records(&mut self, mut unread: &[u8]) -> Result<(), McapError> {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_emit_chunks(true)
            .with_record_length_limit(unread.len());
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::Record { opcode, data } => self.inner_record(opcode, data),
                LinearReadEvent::ReadRequest(need) => {
                    let (now, later) = unread.split_at(need.max(FEED).min(unread.len()));
                    reader.insert(now.len()).copy_from_slice(now);
                    reader.notify_read(now.len());
                    unread = later;
                }
            }
        }
        Ok(())
    }

    fn inner_record(&mut self, opcode: u8, data: &[u8]) {
        let record = lengths::fit(opcode, data).then(|| mcap::parse_record(opcode, data));
        let Some(Ok(record)) = record else {
            self.loss.damaged_records += 1;
            return;
        };
        match record {
            Record::Schema { header, .. } => {
                self.schemas.entry(header.id).or_insert(header.name);
            }
            Record::Channel(channel) => self.channel(channel),
            Record::Message { header, data } => {
                let known = self.channels.get(usize::from(header.channel_id));
                let visited = match known.and_then(Option::as_ref) {
                    Some(channel) => (self.visit)(Item::Message {
                        id: header.channel_id,
                        channel,
                        log_time_ns: header.log_time,
                        data: &data,
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

    fn channel(&mut self, channel: mcap::records::Channel) {
        let id = usize::from(channel.id);
        if self.channels.len() <= id {
            self.channels.resize(id + 1, None);
        }
        if let Some(place @ None) = self.channels.get_mut(id) {
            let schema = self.schemas.get(&channel.schema_id).cloned();
            let info = place.insert(Arc::new(ChannelInfo {
                topic: channel.topic,
                schema: schema.unwrap_or_default(),
                encoding: channel.message_encoding,
                metadata: channel.metadata,
            }));
            let item = Item::Channel {
                id: channel.id,
                channel: info,
            };
            self.loss.damaged_records += u64::from((self.visit)(item).is_err());
        }
    }
}
