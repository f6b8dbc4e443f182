//! Data of a damaged bag that could not be read.

/// The parts of a bag that could not be read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Loss {
    /// The file is truncated, or damaged so that no later record can be found.
    pub truncated: bool,
    /// Bytes after the last record that was read.
    pub bytes_at_end: u64,
    /// Chunks (of a database: stretches of rows) with a wrong checksum or content. The messages of an MCAP chunk are
    /// skipped, of a ROS 1 chunk those after the damage.
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
    /// Files of a split bag that are not there.
    pub missing_files: Vec<String>,
    /// Files of a split bag that cannot be read at all, with the reason.
    pub unreadable_files: Vec<String>,
}

impl Loss {
    /// Adds what another file of the same bag lost.
    pub(super) fn add(&mut self, other: &Self) {
        self.index_only =
            other.truncated && other.index_only || !other.truncated && self.index_only;
        self.truncated |= other.truncated;
        self.bytes_at_end += other.bytes_at_end;
        self.damaged_chunks += other.damaged_chunks;
        self.messages_in_damaged_chunks += other.messages_in_damaged_chunks;
        self.undecodable_messages += other.undecodable_messages;
        self.damaged_records += other.damaged_records;
        self.messages_read += other.messages_read;
    }

    /// Whether anything was lost, even if only the index.
    pub fn any(&self) -> bool {
        self.truncated
            || self.damaged_chunks > 0
            || self.undecodable_messages > 0
            || self.damaged_records > 0
            || !self.missing_files.is_empty()
            || !self.unreadable_files.is_empty()
    }
}

impl std::fmt::Display for Loss {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} messages recovered", self.messages_read)?;
        if self.damaged_chunks > 0 {
            write!(f, "; {} damaged chunks", self.damaged_chunks)?;
            if self.messages_in_damaged_chunks > 0 {
                let messages = self.messages_in_damaged_chunks;
                write!(f, " with at least {messages} messages")?;
            }
            write!(f, " skipped")?;
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
        } else if self.truncated && self.bytes_at_end > 0 {
            let bytes = self.bytes_at_end;
            write!(
                f,
                "; the file is truncated: its last {bytes} bytes are an incomplete chunk, of which the beginning was read"
            )?;
        } else if self.truncated {
            write!(f, "; the file is damaged: what follows is lost")?;
        }
        for name in &self.missing_files {
            write!(f, "; {name} is missing")?;
        }
        for error in &self.unreadable_files {
            write!(f, "; {error}")?;
        }
        Ok(())
    }
}
