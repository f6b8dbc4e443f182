//! Data of a damaged MCAP file that could not be read.

/// The parts of an MCAP file that could not be read, as counts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Loss {
    /// The file is truncated, or damaged so that no later record can be found.
    pub truncated: bool,
    /// Bytes after the last record that was read.
    pub bytes_at_end: u64,
    /// Chunks with a wrong checksum or content; their messages are skipped.
    pub damaged_chunks: u64,
    /// Messages in those chunks, as far as their index is readable.
    pub messages_in_damaged_chunks: u64,
    /// Messages that cannot be decoded, or whose channel was lost.
    pub undecodable_messages: u64,
    /// Damaged attachments and other records.
    pub damaged_records: u64,
    /// Messages that were read.
    pub messages_read: u64,
    /// The damage is in the index at the end; the data is complete.
    pub index_only: bool,
}

impl Loss {
    /// Whether anything was lost, even if only the index.
    pub fn any(&self) -> bool {
        self.truncated
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
                "; {chunks} damaged chunks with at least {messages} messages skipped"
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
            write!(f, "; {} damaged records skipped", self.damaged_records)?;
        }
        if self.index_only {
            write!(
                f,
                "; the index at the end is damaged, but no message is missing"
            )?;
        } else if self.truncated {
            let bytes = self.bytes_at_end;
            write!(
                f,
                "; the file is truncated: its last {bytes} bytes are an incomplete chunk and lost"
            )?;
        }
        Ok(())
    }
}
