//! The answer of two recordings beside each other; its JSON Schema is in `tools/cli/schemas`.

use serde::{Deserialize, Serialize};

/// The whole answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TwoRuns {
    /// Version of this format.
    pub format: u32,
    /// What differs most, in a sentence.
    pub headline: String,
    /// The recording of the real run.
    pub real: String,
    /// The recording of the simulated run.
    pub simulated: String,
    /// First and last time that both have (s).
    pub span_s: [f64; 2],
    /// The robots that are in both, in the order of the simulated run.
    pub robots: Vec<RobotPair>,
    /// The robots that are in one of them alone.
    pub left_out: Vec<String>,
    /// The links that are in the traces of both; empty if one has no trace.
    pub links: Vec<LinkPair>,
}

/// A value of each recording, where there is one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Both<T> {
    /// That of the real run.
    pub real: Option<T>,
    /// That of the simulated run.
    pub simulated: Option<T>,
}

impl<T> Both<T> {
    /// Both values, if there are both.
    pub fn pair(&self) -> Option<[&T; 2]> {
        Some([self.real.as_ref()?, self.simulated.as_ref()?])
    }

    /// Whether there is neither.
    pub fn is_empty(&self) -> bool {
        self.real.is_none() && self.simulated.is_none()
    }
}

/// One robot in both recordings. A part is `None` where the streams for it are missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotPair {
    /// Its name.
    pub robot: String,
    /// How far apart its paths are.
    pub path: Option<PathApart>,
    /// How it keeps its distance to the robot ahead; `None` for the front robot.
    pub spacing: Option<SpacingPair>,
    /// How far its wheels roll and it moves.
    pub slip: Option<SlipPair>,
    /// What is drawn of it.
    #[serde(skip)]
    pub lines: Lines,
}

/// Distance between the poses of both recordings at the same time, as measured: the noise of both is in it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PathApart {
    /// Root mean square (m).
    pub rms_m: f64,
    /// Largest (m).
    pub largest_m: f64,
    /// When it is largest (s).
    pub at_s: f64,
    /// At the first pose that both have (m).
    pub start_m: f64,
    /// Root mean square that the noise of both pose sensors alone makes (m); `None` if a recording does not tell its noise.
    pub noise_m: Option<f64>,
    /// Number of poses of the real run that were compared.
    pub poses: usize,
}

/// How many times the rms that noise alone makes the rms of a distance may be, before it counts as more than noise.
const NOISE_FACTOR: f64 = 1.5;

impl PathApart {
    /// Whether the noise of the pose sensors explains the distance, as far as it is known.
    pub fn is_noise(&self) -> bool {
        let noise_m = self.noise_m;
        noise_m.is_some_and(|noise_m| self.rms_m <= NOISE_FACTOR * noise_m)
    }
}

/// Spacing error of a follower in both recordings, over the time that both have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpacingPair {
    /// The robot ahead.
    pub ahead: String,
    /// Of each recording.
    #[serde(flatten)]
    pub errors: Both<SpacingError>,
    /// Root mean square of the real run minus that of the simulated one (m).
    pub rms_difference_m: Option<f64>,
    /// Largest error of the real run minus that of the simulated one (m).
    pub largest_difference_m: Option<f64>,
}

/// Distance to the robot ahead along the path that it drove, minus the spacing of the formation. From 3 s on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpacingError {
    /// The spacing of the formation (m).
    pub spacing_m: f64,
    /// Root mean square of the error (m).
    pub rms_m: f64,
    /// Largest size of the error (m).
    pub largest_m: f64,
    /// When it is largest (s).
    pub at_s: f64,
}

/// Slip of a robot in both recordings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SlipPair {
    /// Of each recording.
    #[serde(flatten)]
    pub slips: Both<Slip>,
    /// Slip of the real run minus that of the simulated one (percentage points).
    pub difference_percent: Option<f64>,
}

/// Distance that the wheels roll beside that which the robot moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Slip {
    /// Distance by the wheels, with the radius of the model, or by the odometry without wheels (m).
    pub wheels_m: f64,
    /// Distance by the poses (m).
    pub poses_m: f64,
    /// That by the wheels minus that by the poses (m).
    pub slip_m: f64,
    /// The same, in per cent of the distance by the wheels; `None` if they do not roll.
    pub slip_percent: Option<f64>,
}

/// One link in the traces of both recordings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LinkPair {
    /// The sender.
    pub from: String,
    /// The receiver.
    pub to: String,
    /// The stages in the order of the chain, then `end_to_end`.
    pub stages: Vec<StagePair>,
}

/// One stage of a link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StagePair {
    /// Its name.
    pub stage: String,
    /// How long it takes in each recording.
    #[serde(flatten)]
    pub delays: Both<DelayPercentiles>,
    /// Whether the means differ by more than their 95 % intervals; `None` if the traces do not say.
    pub changed: Option<bool>,
}

/// Percentiles of a duration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DelayPercentiles {
    /// Median (s).
    pub p50_s: f64,
    /// 95th percentile (s).
    pub p95_s: f64,
}

/// What is drawn of a robot.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Lines {
    /// Time (s), x and y (m) of its c: in the real run, in the simulated one.
    pub ways: [Vec<(f64, f64, f64)>; 2],
    /// Time (s) and distance between the paths (m).
    pub apart: Vec<(f64, f64)>,
    /// Time (s) and spacing error (m), positive where it is too far behind: in the real run, in the simulated one.
    pub spacing: [Vec<(f64, f64)>; 2],
}
