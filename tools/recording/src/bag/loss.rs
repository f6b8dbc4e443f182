//! What of an MCAP file could not be read.

/// What of a file could not be read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Loss {
    /// The file breaks off, or is damaged so that nothing behind can be found.
    pub broken_off: bool,
    /// Bytes behind the last record that was read.
    pub bytes_at_end: u64,
    /// Chunks whose checksum or content is wrong; their messages are left out.
    pub damaged_chunks: u64,
    /// Messages in those chunks, as far as their index tells.
    pub messages_in_damaged_chunks: u64,
    /// Messages that cannot be decoded or whose topic was lost.
    pub undecodable_messages: u64,
    /// Attachments and other records that are damaged.
    pub damaged_records: u64,
    /// Messages that were read.
    pub messages_read: u64,
    /// It broke off in the index at the end: the data is complete.
    pub index_only: bool,
}

impl Loss {
    /// Whether anything was lost, be it only the index.
    pub fn any(&self) -> bool {
        self.broken_off
            || self.damaged_chunks > 0
            || self.undecodable_messages > 0
            || self.damaged_records > 0
    }
}

impl std::fmt::Display for Loss {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} messages recovered", self.messages_read)?;
        if self.damaged_chunks > 0 {
            let (chunks, messages) = (self.damaged_chunks, self.messages_in_damaged_chunks);
            write!(
                f,
                "; {chunks} damaged chunks with at least {messages} messages left out"
            )?;
        }
        if self.undecodable_messages > 0 {
            write!(
                f,
                "; {} messages could not be decoded",
                self.undecodable_messages
            )?;
        }
        if self.damaged_records > 0 {
            write!(f, "; {} damaged records left out", self.damaged_records)?;
        }
        if self.index_only {
            write!(
                f,
                "; the index at the end is damaged, no message is missing there"
            )?;
        } else if self.broken_off {
            let bytes = self.bytes_at_end;
            write!(
                f,
                "; the file breaks off, its last {bytes} bytes are no whole chunk and lost"
            )?;
        }
        Ok(())
    }
}
