//! All messages of an MCAP file, as bytes.

use std::path::Path;

use slipstream_bag::{Announced, Item, Listener, Loss, Result, open_file, read_bag};

use crate::topics;

/// Gives every topic and every message of an MCAP file to `listener`, in file order. Returns what could not be read.
///
/// # Errors
/// A file that cannot be read or is no MCAP file.
pub fn read_messages(path: &Path, listener: &mut dyn Listener) -> Result<Loss> {
    let (source, size) = open_file(path)?;
    let loss = read_bag(source, size, path, &mut |item| {
        match item {
            Item::Channel { channel, .. } => listener.announced(&Announced {
                topic: &channel.topic,
                encoding: &channel.encoding,
                schema_name: &channel.schema,
                schema_encoding: &channel.definition.0,
                schema: &channel.definition.1,
                metadata: &channel.metadata,
            }),
            Item::Message {
                channel,
                log_time_ns,
                data,
                ..
            } => listener.message(&channel.topic, log_time_ns, data),
            Item::Attachment {
                name: name @ (topics::DESCRIPTION | topics::MODEL),
                data,
            } => listener.described(name, &String::from_utf8_lossy(data)),
            Item::Unwanted { .. } | Item::Attachment { .. } | Item::Metadata { .. } => {}
        }
        Ok(())
    })?;
    Ok(loss)
}
