//! The index at the end of an MCAP file: its topics, and which chunk has messages of which.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

use mcap::records::{Record, op};

use super::item::ChannelInfo;
use super::lengths;
use super::records::{FOOTER_BYTES, HEAD_BYTES, split_record};

/// Largest index that is read (bytes).
const MOST_BYTES: u64 = 64 << 20;

/// What the end of a file says about it.
#[derive(Debug, Default)]
pub struct Summary {
    /// Channels by their id.
    pub channels: BTreeMap<u16, Arc<ChannelInfo>>,
    /// Names of the records of names and values.
    pub metadata: Vec<String>,
    /// Where each chunk begins, and the channels whose messages it has.
    pub(super) chunks: BTreeMap<u64, Vec<u16>>,
}

impl Summary {
    /// Reads the index of a file. `None` if it has none, or one that is damaged.
    pub(super) fn read(source: &mut (impl Read + Seek)) -> Option<Self> {
        let tail = HEAD_BYTES + FOOTER_BYTES + mcap::MAGIC.len();
        let footer_start = source
            .seek(SeekFrom::End(-i64::try_from(tail).ok()?))
            .ok()?;
        let mut end = Vec::new();
        source.read_to_end(&mut end).ok()?;
        if !end.ends_with(mcap::MAGIC) {
            return None;
        }
        let (opcode, content, _) = split_record(&end).ok()?;
        let Ok(Record::Footer(footer)) = mcap::parse_record(opcode, content) else {
            return None;
        };
        let start = footer.summary_start;
        let length = footer_start.checked_sub(start)?;
        // Without a checksum, a damaged index could hide a chunk.
        if start == 0 || length > MOST_BYTES || footer.summary_crc == 0 {
            return None;
        }
        source.seek(SeekFrom::Start(start)).ok()?;
        let mut bytes = Vec::new();
        source.take(length).read_to_end(&mut bytes).ok()?;
        let mut sum = crc32fast::Hasher::new();
        sum.update(&bytes);
        // The checksum includes the footer up to itself.
        sum.update(end.get(..HEAD_BYTES + FOOTER_BYTES - 4)?);
        if bytes.len() as u64 != length || sum.finalize() != footer.summary_crc {
            return None;
        }
        Self::parse(&bytes)
    }

    fn parse(mut records: &[u8]) -> Option<Self> {
        let mut summary = Self::default();
        let mut schemas = BTreeMap::new();
        while !records.is_empty() {
            let (opcode, content, rest) = split_record(records).ok()?;
            records = rest;
            let is_known = [op::SCHEMA, op::CHANNEL, op::CHUNK_INDEX, op::METADATA_INDEX];
            if !is_known.contains(&opcode) {
                continue;
            }
            if !lengths::are_valid(opcode, content) {
                return None;
            }
            match mcap::parse_record(opcode, content).ok()? {
                Record::Schema { header, data } => {
                    let definition = Arc::new((header.encoding, data.into_owned()));
                    schemas.insert(header.id, (header.name, definition));
                }
                Record::Channel(channel) => {
                    let schema = schemas.get(&channel.schema_id).cloned();
                    let id = channel.id;
                    let info = ChannelInfo::new(channel, schema.unwrap_or_default());
                    summary.channels.insert(id, Arc::new(info));
                }
                Record::ChunkIndex(index) => {
                    let channels: Vec<u16> = index.message_index_offsets.into_keys().collect();
                    // A chunk without an index of its messages may have any.
                    if !channels.is_empty() {
                        summary.chunks.insert(index.chunk_start_offset, channels);
                    }
                }
                Record::MetadataIndex(index) => summary.metadata.push(index.name),
                _ => {}
            }
        }
        Some(summary)
    }
}
