//! Sequential reader of WPILib data logs (version 1.0): entries are channels, named by their types.
//!
//! After a header follow records: a byte that says how many bytes each number has, the number of an entry, the length
//! of the data, a time (µs), the data. Records of entry 0 start and finish entries.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use slipstream_bus::InputError;

use super::channels::Channels;
use super::chunk::MAX_CHUNK_BYTES;
use super::item::{ChannelInfo, Undecodable, Visit, Wanted};
use super::loss::Loss;

/// First bytes of every log.
pub(super) const MAGIC: &[u8] = b"WPILOG";
/// Kinds of control records.
const START: u8 = 0;
const FINISH: u8 = 1;

/// Types with numbers, and what they have, written as definitions of ROS messages.
const DEFINITIONS: [(&str, &str); 9] = [
    ("double", "float64 data"),
    ("float", "float32 data"),
    ("int64", "int64 data"),
    ("boolean", "bool data"),
    ("struct:Rotation2d", "float64 value"),
    ("struct:Pose2d", "float64 x\nfloat64 y\nfloat64 theta"),
    (
        "struct:ChassisSpeeds",
        "float64 vx\nfloat64 vy\nfloat64 omega",
    ),
    ("struct:DifferentialDriveWheelSpeeds", SIDES),
    ("struct:DifferentialDriveWheelPositions", SIDES),
];
const SIDES: &str = "float64 left\nfloat64 right";

/// Reads all of `source`, which has `size` bytes, and calls `visit` with each item. `path` is used in errors only.
///
/// # Errors
/// If it is not a log of version 1, or reading fails. Damage is not an error but a [`Loss`].
pub(super) fn read_wpilog(
    source: &mut dyn Read,
    size: u64,
    path: &Path,
    wanted: &Wanted<'_>,
    visit: &mut Visit<'_>,
) -> Result<Loss, InputError> {
    let unreadable = |e: io::Error| InputError::unreadable(path, &e);
    let mut data = Vec::new();
    let is_whole = fill(source, &mut data, 12).map_err(unreadable)?;
    let (Some([_, 1]), Some(extra), true) = (data.get(6..8), number(&data, 8), is_whole) else {
        let problem = "is not a WPILib data log of version 1";
        return Err(InputError::file(path, problem, "convert it to MCAP"));
    };
    fill(source, &mut data, extra.min(MAX_CHUNK_BYTES)).map_err(unreadable)?;
    let mut reader = LogReader {
        entries: Channels::new(wanted, visit),
        loss: Loss::default(),
    };
    let mut bytes_read = 12 + extra;
    loop {
        match reader.record(source, &mut data).map_err(unreadable)? {
            RecordFound::Whole { bytes } => bytes_read += bytes,
            RecordFound::None => return Ok(reader.loss),
            RecordFound::Cut => break,
        }
    }
    reader.loss.truncated = true;
    reader.loss.bytes_at_end = size.saturating_sub(bytes_read);
    Ok(reader.loss)
}

/// What was found of a record.
enum RecordFound {
    Whole { bytes: u64 },
    None,
    Cut,
}

struct LogReader<'a> {
    /// Started entries.
    entries: Channels<'a>,
    loss: Loss,
}

impl LogReader<'_> {
    fn record(&mut self, source: &mut dyn Read, data: &mut Vec<u8>) -> io::Result<RecordFound> {
        if !fill(source, data, 1)? {
            return Ok(RecordFound::None);
        }
        let lengths = data.first().copied().unwrap_or_default();
        let lengths = [
            (lengths & 3) + 1,
            (lengths >> 2 & 3) + 1,
            (lengths >> 4 & 7) + 1,
        ];
        let mut numbers = [0; 3];
        for (number, length) in numbers.iter_mut().zip(lengths) {
            if !fill(source, data, u64::from(length))? {
                return Ok(RecordFound::Cut);
            }
            *number = data
                .iter()
                .rev()
                .fold(0, |sum, byte| sum << 8 | u64::from(*byte));
        }
        let [entry, length, t_us] = numbers;
        if length > MAX_CHUNK_BYTES || !fill(source, data, length)? {
            return Ok(RecordFound::Cut);
        }
        self.content(entry as u32, t_us, data);
        let head: u64 = lengths.into_iter().map(u64::from).sum();
        let bytes = 1 + head + length;
        Ok(RecordFound::Whole { bytes })
    }

    fn content(&mut self, entry: u32, t_us: u64, data: &[u8]) {
        if entry == 0 {
            let known = self.control(data);
            self.loss.damaged_records += u64::from(known.is_none());
            return;
        }
        let log_time_ns = || Some(t_us.saturating_mul(1000));
        match self.entries.message(entry, log_time_ns, data) {
            Ok(()) => self.loss.messages_read += 1,
            Err(Undecodable) => self.loss.undecodable_messages += 1,
        }
    }

    /// Starts or finishes an entry; what is said later about its metadata has no use here.
    fn control(&mut self, data: &[u8]) -> Option<()> {
        let id = number(data, 1)? as u32;
        match *data.first()? {
            START => {}
            FINISH => return self.entries.remove(id),
            _ => return Some(()),
        }
        let (topic, rest) = text(data.get(5..)?)?;
        let (schema, _) = text(rest)?;
        let mut known = DEFINITIONS.iter().filter(|(name, _)| *name == schema);
        let definition = known.next().map_or(("", ""), |(_, own)| ("ros1msg", own));
        let channel = ChannelInfo {
            topic,
            schema,
            encoding: "wpilog".to_owned(),
            definition: Arc::new((definition.0.to_owned(), definition.1.as_bytes().to_vec())),
            metadata: BTreeMap::new(),
        };
        self.entries.add(id, channel).ok()
    }
}

/// Replaces `data` by the next bytes. Returns whether there were so many.
fn fill(source: &mut dyn Read, data: &mut Vec<u8>, length: u64) -> io::Result<bool> {
    data.clear();
    source.take(length).read_to_end(data)?;
    Ok(data.len() as u64 == length)
}

/// The number of 32 bits at a place.
fn number(data: &[u8], at: usize) -> Option<u64> {
    let (number, _) = data.get(at..)?.split_first_chunk()?;
    Some(u64::from(u32::from_le_bytes(*number)))
}

/// The text at the beginning, whose length stands before it, and what follows it.
fn text(data: &[u8]) -> Option<(String, &[u8])> {
    let length = usize::try_from(number(data, 0)?).ok()?;
    let (text, rest) = data.get(4..)?.split_at_checked(length)?;
    Some((String::from_utf8_lossy(text).into_owned(), rest))
}
