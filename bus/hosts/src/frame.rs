//! Frames between the two ends of a run across hosts (postcard).

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use slipstream_bus::message::{DriveCommand, Encoders, Position, RobotIndex};
use slipstream_bus::transport::BusError;
use slipstream_ipc::wake_page::DEADLINE_WORDS;

use crate::clock::{ClockReport, Stamps};

/// Largest size of a frame (bytes). A larger one is refused before it is decoded.
pub const MAX_BYTES: usize = 64 << 20;

/// From the plant's host to another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Down {
    /// A round of the lockstep.
    Round(Round),
    /// On the wall clock: what is new.
    News(News),
    /// The answer to [`Up::Time`].
    Time(Stamps),
    /// The records up to the batch with this number have arrived.
    Kept(u64),
    /// The run is over. The host reports what its agents leave.
    Over(End),
    /// The run ends at once, for this reason. The host reports nothing.
    Stop(String),
    /// What the host had to report has arrived: it may end.
    Received,
    /// Nothing new: the plant's host lives.
    Beat,
}

/// A round of the lockstep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Its number, from 1.
    pub number: u64,
    /// What the robots of the host measured.
    pub measured: Measured,
    /// Positions from other hosts for robots of this host, in the order of their sending.
    pub positions: Vec<Position>,
}

/// On the wall clock: what is new on the plant's host. It may be lost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct News {
    /// Time 0 of the run on the clock of the plant's host (ns).
    pub start_ns: i64,
    /// What the robots of the host measured last.
    pub measured: Measured,
    /// Positions from other hosts for robots of this host, in the order of their sending.
    pub positions: Vec<Position>,
}

/// The end of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// The last encoders.
    pub measured: Measured,
    /// Why the run ends early; `None` if it is complete.
    pub stopped: Option<String>,
}

/// Encoders at one instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The instant (ns).
    pub now_ns: i64,
    /// Encoders of the robots of the host.
    pub encoders: Vec<(RobotIndex, Encoders)>,
}

/// From another host to the plant's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Up {
    /// All agents of the host are connected, for the run with this number ([`crate::hello::Welcome`]).
    Ready(u64),
    /// The answer to a round.
    Answer(Answer),
    /// On the wall clock: torques and positions for robots of other hosts since the last ones. They may be lost.
    Sent(Sent),
    /// On the wall clock: records, sent again until they have arrived.
    Records(Batch),
    /// On the wall clock: asks for the time. The number is the time here (ns).
    Time(i64),
    /// On the wall clock: what is known of the clock of this host.
    Clock(ClockReport),
    /// On the wall clock: the agents of this host.
    Agents(Vec<AgentState>),
    /// All agents of the host have ended: what they leave.
    Report(Report),
    /// The host cannot go on, for this reason.
    Failed(String),
    /// The host knows that its report has arrived, and ends.
    Bye,
    /// Nothing new: the host lives.
    Beat,
}

/// The answer to a round.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The round.
    pub number: u64,
    /// Torques of all robots of the host.
    pub commands: Vec<DriveCommand>,
    /// Positions for robots of other hosts.
    pub positions: Vec<Position>,
    /// Chunks of records since the last answer.
    pub records: Vec<Vec<u8>>,
}

/// On the wall clock: what the agents of a host have sent.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Sent {
    /// Torques, in the order of their sending.
    pub commands: Vec<DriveCommand>,
    /// Positions for robots of other hosts.
    pub positions: Vec<Position>,
}

/// On the wall clock: what is known of an agent even if it dies, or its host is lost.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AgentState {
    /// Its robot.
    pub robot: RobotIndex,
    /// How often it has died.
    pub deaths: u32,
    /// Deadline counts of its loops so far, as on the wake-up page.
    pub deadlines: Vec<[i64; DEADLINE_WORDS]>,
}

/// On the wall clock: records of the agents of a host.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Batch {
    /// Its number, from 1.
    pub number: u64,
    /// Chunks of records since the last batch.
    pub records: Vec<Vec<u8>>,
}

/// What the agents of a host leave.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Report {
    /// The files that they left in the run directory.
    pub files: Vec<LeftFile>,
    /// Chunks of records since the last answer.
    pub records: Vec<Vec<u8>>,
    /// What went wrong on the host although the run went on.
    pub failure: Option<String>,
}

/// A file that an agent left.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftFile {
    /// Its name.
    pub name: String,
    /// Its content.
    pub content: Vec<u8>,
}

/// Encodes a frame.
///
/// # Errors
/// It is larger than [`MAX_BYTES`].
pub fn encode(frame: &impl Serialize) -> Result<Vec<u8>, BusError> {
    let bytes = postcard::to_allocvec(frame).map_err(|e| BusError::failed("frame", e))?;
    check_size(&bytes)?;
    Ok(bytes)
}

/// Decodes a frame.
///
/// # Errors
/// It is larger than [`MAX_BYTES`], damaged, or has bytes behind its end.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, BusError> {
    check_size(bytes)?;
    let damaged = |reason: &str| BusError::Failed {
        what: "network".to_owned(),
        reason: format!("a frame of {} bytes {reason}", bytes.len()),
    };
    match postcard::take_from_bytes(bytes) {
        Ok((frame, [])) => Ok(frame),
        Ok(_) => Err(damaged("has bytes behind its end")),
        Err(_) => Err(damaged("does not decode")),
    }
}

fn check_size(bytes: &[u8]) -> Result<(), BusError> {
    if bytes.len() <= MAX_BYTES {
        return Ok(());
    }
    Err(BusError::Failed {
        what: "network".to_owned(),
        reason: format!("a frame of {} bytes; {MAX_BYTES} are allowed", bytes.len()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_that_is_cut_or_too_long_is_refused() {
        let answer = Up::Answer(Answer {
            number: 7,
            commands: vec![DriveCommand::default(); 2],
            positions: vec![Position::default()],
            records: vec![vec![1, 2, 3]],
        });
        let bytes = encode(&answer).unwrap();
        assert_eq!(decode::<Up>(&bytes), Ok(answer));
        for cut in 0..bytes.len() {
            assert!(decode::<Up>(&bytes[..cut]).is_err(), "{cut}");
        }
        let longer = [&bytes[..], &[0]].concat();
        let error = decode::<Up>(&longer).unwrap_err().to_string();
        assert!(error.contains("behind its end"), "{error}");
    }
}
