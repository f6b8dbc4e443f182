//! Damage-tolerant sequential MCAP reader: returns everything intact and counts what is lost.
//!
//! Memory is bounded by the largest chunk (at most [`MAX_CHUNK_BYTES`]), never by what a damaged
//! length field claims. A chunk is used only if its checksum is right; of a chunk whose end is missing, which has none, the
//! records before the end of the file.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use slipstream_bus::InputError;

use super::chunk::{MAX_CHUNK_BYTES, unpack, unpack_as_far};
use super::item::{ChannelInfo, Item, Undecodable, Visit};
use super::lengths;
use super::loss::Loss;

/// A schema: the name of a type, and its definition with its encoding.
type Schema = (String, Arc<(String, Vec<u8>)>);

/// Reads all of `source`, which has `size` bytes, and calls `visit` with each item.
///
/// # Errors
/// If it is not an MCAP file, or reading fails. Damage is not an error but a [`Loss`].
pub(crate) fn read_bag(
    source: impl Read,
    size: u64,
    path: &Path,
    visit: &mut Visit<'_>,
) -> Result<Loss, InputError> {
    let limit = usize::try_from(size.clamp(64, MAX_CHUNK_BYTES)).unwrap_or(usize::MAX);
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_record_length_limit(limit);
    BagReader {
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

/// The state of reading one file.
struct BagReader<'a> {
    path: &'a Path,
    visit: &'a mut Visit<'a>,
    loss: Loss,
    /// Names of the message types, by schema id.
    schemas: BTreeMap<u16, Schema>,
    /// Channels, by channel id.
    channels: Vec<Option<Arc<ChannelInfo>>>,
    /// The decompressed records of the current chunk; kept to save allocations.
    unpacked: Vec<u8>,
    /// The last chunk was damaged; the message indexes after it say how many messages it had.
    in_damaged_chunk: bool,
}

/// Size of the pieces in which a chunk is passed to the parser (bytes).
const FEED_BYTES: usize = 16 << 10;

impl BagReader<'_> {
    fn run(
        mut self,
        mut source: impl Read,
        size: u64,
        mut reader: LinearReader,
    ) -> Result<Loss, InputError> {
        // Bytes of all complete records, including the magic bytes at the start.
        let mut bytes_done = mcap::MAGIC.len() as u64;
        let mut started = false;
        let mut data_ended = false;
        // What was read of the record that is not complete yet.
        let mut unread = Vec::new();
        while let Some(event) = reader.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(need)) => {
                    let room = reader.insert(need);
                    let read = source
                        .read(room)
                        .map_err(|e| InputError::unreadable(self.path, &e))?;
                    unread.extend_from_slice(room.get(..read).unwrap_or_default());
                    reader.notify_read(read);
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    let magic = if started { 0 } else { mcap::MAGIC.len() };
                    unread.drain(..(magic + 9 + data.len()).min(unread.len()));
                    started = true;
                    bytes_done += 9 + data.len() as u64;
                    data_ended |= opcode == op::DATA_END;
                    self.record(opcode, data);
                }
                Err(error) => {
                    if !started {
                        return Err(self.not_a_bag(size, &error));
                    }
                    self.loss.truncated = true;
                    self.loss.index_only = data_ended;
                    self.loss.bytes_at_end = size.saturating_sub(bytes_done);
                    // A record that claims more than the file has is not read by the parser.
                    let _ = source
                        .by_ref()
                        .take(MAX_CHUNK_BYTES)
                        .read_to_end(&mut unread);
                    self.cut_chunk(&unread);
                    break;
                }
            }
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
        // Opcode and length of the record; times and size of the chunk, its checksum, the name of its compression with
        // its length, the length of the records.
        let rest = record
            .strip_prefix(&[op::CHUNK])
            .and_then(|r| r.get(8 + 28..));
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
                    let (now, later) = unread.split_at(need.max(FEED_BYTES).min(unread.len()));
                    reader.insert(now.len()).copy_from_slice(now);
                    reader.notify_read(now.len());
                    unread = later;
                }
            }
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
                    Some(channel) => (self.visit)(Item::Message {
                        id: header.channel_id.into(),
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

    /// Registers a channel; of several with the same id, the first one.
    fn channel(&mut self, channel: mcap::records::Channel) {
        let id = usize::from(channel.id);
        if self.channels.len() <= id {
            self.channels.resize(id + 1, None);
        }
        if let Some(place @ None) = self.channels.get_mut(id) {
            let schema = self.schemas.get(&channel.schema_id).cloned();
            let (schema, definition) = schema.unwrap_or_default();
            let info = place.insert(Arc::new(ChannelInfo {
                topic: channel.topic,
                schema,
                definition,
                encoding: channel.message_encoding,
                metadata: channel.metadata,
            }));
            let item = Item::Channel {
                id: channel.id.into(),
                channel: info,
            };
            self.loss.damaged_records += u64::from((self.visit)(item).is_err());
        }
    }
}
