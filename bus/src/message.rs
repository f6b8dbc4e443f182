//! Messages between plant and agents, as plain values. Times are in ns since the start of the run.
//!
//! Pairs are always [right, left]. The memory layout is up to the transport.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Index of a robot in a run; 0 is the front robot, `r1`.
pub type RobotIndex = u32;

/// The name of robot `index`: `r1` for 0.
pub fn robot_name(index: RobotIndex) -> String {
    format!("r{}", index + 1)
}

/// Encoder reading of one robot, plant → agent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Encoders {
    /// When the counters were read (ns).
    pub sampled_ns: i64,
    /// Signed cumulative counts.
    pub counts: [i64; 2],
}

/// What a robot's drives are told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Actuation {
    /// Torque at each wheel (N m).
    Torque([f64; 2]),
    /// Forward speed v_d (m/s) and yaw rate w_d (rad/s). The robot's own speed loops follow them.
    Twist([f64; 2]),
}

impl Default for Actuation {
    fn default() -> Self {
        Self::Torque([0.0; 2])
    }
}

/// What one controller tells the drives of its robot, agent → plant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct DriveCommand {
    /// The robot.
    pub robot: RobotIndex,
    /// The lockstep round that this answers; 0 on the wall clock.
    pub epoch: u32,
    /// The inner tick that computed it (ns).
    pub tick_ns: i64,
    /// Torques or a twist.
    pub actuation: Actuation,
}

/// Largest number of numbers that a controller adds to its messages.
pub const MAX_EXTRA: usize = 8;

/// Numbers of the controller's own in a message, at most [`MAX_EXTRA`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Extra {
    /// How many there are.
    len: u32,
    /// The numbers; 0 where there is none.
    values: [f64; MAX_EXTRA],
}

impl Extra {
    /// These numbers; `None` if there are more than [`MAX_EXTRA`].
    pub fn new(numbers: &[f64]) -> Option<Self> {
        let mut values = [0.0; MAX_EXTRA];
        values.get_mut(..numbers.len())?.copy_from_slice(numbers);
        let len = u32::try_from(numbers.len()).ok()?;
        Some(Self { len, values })
    }

    /// From the memory of another process: a length beyond [`MAX_EXTRA`] counts as [`MAX_EXTRA`].
    pub fn from_parts(len: u32, values: [f64; MAX_EXTRA]) -> Self {
        let len = len.min(MAX_EXTRA as u32);
        Self { len, values }
    }

    /// The numbers.
    pub fn numbers(&self) -> &[f64] {
        self.values.get(..self.len as usize).unwrap_or(&self.values)
    }

    /// All places, 0 where there is no number.
    pub fn places(&self) -> [f64; MAX_EXTRA] {
        self.values
    }
}

impl Serialize for Extra {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.numbers())
    }
}

impl<'de> Deserialize<'de> for Extra {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let numbers = Vec::<f64>::deserialize(deserializer)?;
        let too_many = || serde::de::Error::invalid_length(numbers.len(), &"at most 8 numbers");
        Self::new(&numbers).ok_or_else(too_many)
    }
}

/// Estimated position and reference velocity of a robot, robot → those that hear it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// The sender.
    pub from: RobotIndex,
    /// Sequence number of the sender's messages, from 0.
    pub seq: u32,
    /// Number of the token round of the ring protocol, from 0; always 0 for `periodic`.
    pub token_round: u32,
    /// When the encoders behind the estimate were read (ns).
    pub sampled_ns: i64,
    /// The sender's outer tick (ns).
    pub tick_ns: i64,
    /// When the transport sent it (ns).
    pub sent_ns: i64,
    /// x of c (m), by odometry.
    pub x_m: f64,
    /// y of c (m).
    pub y_m: f64,
    /// Heading φ, not wrapped (rad).
    pub yaw_rad: f64,
    /// v_r: the sender's reference speed (m/s).
    pub v_m_s: f64,
    /// w_r: the sender's reference yaw rate (rad/s).
    pub w_rad_s: f64,
    /// What the sender's controller adds.
    pub extra: Extra,
}
