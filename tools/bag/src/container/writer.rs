//! Writer of an MCAP file as a ROS 2 bag: compressed chunks, index, checksums, embedded definitions.
//!
//! A chunk is written in one piece once it is complete. A writer that is killed therefore leaves
//! complete chunks and at most one truncated chunk.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{Attachment, Compression, WriteOptions};
use serde::Serialize;

use crate::error::{Error, Result, write_error};
use crate::listener::{Announced, Listener};
use crate::ros::{MessageType, cdr};

/// Size at which a chunk is closed (bytes, before compression).
const CHUNK_BYTES: u64 = 768 * 1024;

/// A channel of the file being written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Channel(u16);

/// An MCAP file being written.
pub struct BagWriter<'a> {
    path: PathBuf,
    /// One type for every sink, so that the writer is compiled once.
    file: mcap::Writer<NoSeek<Box<dyn Write + Send + 'a>>>,
    /// The encoded message; kept to save allocations.
    buffer: Vec<u8>,
    /// Number of messages written to each channel so far, by channel id.
    sequence: Vec<u32>,
    /// Topics by channel id, and who hears their messages.
    topics: Vec<String>,
    listener: Option<Box<dyn Listener + Send>>,
}

impl<'a> BagWriter<'a> {
    /// Writes to `sink`; `path` is used in errors only.
    pub fn new(sink: impl Write + Send + 'a, path: &Path) -> Result<Self> {
        let sink: Box<dyn Write + Send + 'a> = Box::new(sink);
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("slipstream ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true);
        Ok(Self {
            file: options
                .create(NoSeek::new(sink))
                .map_err(|e| mcap_error(path, e))?,
            path: path.to_owned(),
            buffer: Vec::new(),
            sequence: Vec::new(),
            topics: Vec::new(),
            listener: None,
        })
    }

    /// From now on, `listener` has every channel and every message.
    pub fn listen(&mut self, listener: Box<dyn Listener + Send>) {
        self.listener = Some(listener);
    }

    /// Adds a channel. `metadata` is for who reads it: names and values.
    pub fn channel(
        &mut self,
        topic: &str,
        message_type: MessageType,
        metadata: &BTreeMap<String, String>,
    ) -> Result<Channel> {
        let schema = message_type.schema();
        let schema = self
            .file
            .add_schema(message_type.name(), "ros2msg", schema.as_bytes())
            .map_err(|e| mcap_error(&self.path, e))?;
        let id = self
            .file
            .add_channel(schema, topic, "cdr", metadata)
            .map_err(|e| mcap_error(&self.path, e))?;
        if self.sequence.len() <= usize::from(id) {
            self.sequence.resize(usize::from(id) + 1, 0);
            self.topics.resize(usize::from(id) + 1, String::new());
        }
        topic.clone_into(&mut self.topics[usize::from(id)]);
        if let Some(listener) = &mut self.listener {
            announce(listener.as_mut(), topic, message_type, metadata);
        }
        Ok(Channel(id))
    }

    /// Writes a message with its log time (ns). Negative log times become 0; the stamp in the message
    /// is not changed.
    pub fn write<T: Serialize>(&mut self, channel: Channel, t_ns: i64, message: &T) -> Result<()> {
        cdr::encode(message, &mut self.buffer).map_err(|e| Error::WriteMcap {
            path: self.path.clone(),
            message: e.to_string(),
        })?;
        let log_time = u64::try_from(t_ns).unwrap_or(0);
        let mut header = MessageHeader {
            channel_id: channel.0,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        if let Some(sequence) = self.sequence.get_mut(usize::from(channel.0)) {
            header.sequence = *sequence;
            *sequence = sequence.wrapping_add(1);
        }
        self.file
            .write_to_known_channel(&header, &self.buffer)
            .map_err(|e| mcap_error(&self.path, e))?;
        if let (Some(listener), Some(topic)) =
            (&mut self.listener, self.topics.get(usize::from(channel.0)))
        {
            listener.message(topic, log_time, &self.buffer);
        }
        Ok(())
    }

    /// Attaches a file.
    pub fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<()> {
        let attachment = Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: data.into(),
        };
        self.file
            .attach(&attachment)
            .map_err(|e| mcap_error(&self.path, e))
    }

    /// Writes a record of names and values.
    pub fn metadata(&mut self, name: &str, values: BTreeMap<String, String>) -> Result<()> {
        let metadata = Metadata {
            name: name.to_owned(),
            metadata: values,
        };
        self.file
            .write_metadata(&metadata)
            .map_err(|e| mcap_error(&self.path, e))
    }

    /// Closes the chunk and passes it to the operating system: it survives the end of this process.
    pub fn flush(&mut self) -> Result<()> {
        self.file.flush().map_err(|e| mcap_error(&self.path, e))
    }

    /// Leaves the file as it is after a flush, without an index.
    pub fn leave(mut self) -> Result<()> {
        self.flush()?;
        // Dropped, it would write the index.
        drop(self.file.into_inner());
        Ok(())
    }

    /// Writes the index and closes the file.
    pub fn finish(mut self) -> Result<()> {
        self.file.finish().map_err(|e| mcap_error(&self.path, e))?;
        let mut sink = self.file.into_inner().into_inner();
        sink.flush().map_err(write_error(&self.path))
    }
}

/// Tells a listener of a topic that slipstream writes.
pub fn announce(
    listener: &mut dyn Listener,
    topic: &str,
    message_type: MessageType,
    metadata: &BTreeMap<String, String>,
) {
    listener.announced(&Announced {
        topic,
        encoding: "cdr",
        schema_name: message_type.name(),
        schema_encoding: "ros2msg",
        schema: message_type.schema().as_bytes(),
        metadata,
    });
}

/// Converts an error of the MCAP library.
fn mcap_error(path: &Path, error: mcap::McapError) -> Error {
    match error {
        mcap::McapError::Io(source) => write_error(path)(source),
        other => Error::WriteMcap {
            path: path.to_owned(),
            message: other.to_string(),
        },
    }
}
