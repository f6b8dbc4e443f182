//! The experiment as plain data: every key that a run obeys, with its unit and default.
//!
//! The launcher reads it from TOML and hands it to the processes; nobody else interprets files.
//! The field names are the keys: `links.delay_s` is [`LinkSettings::delay_s`].

use serde::{Deserialize, Serialize};

use crate::robot::RobotModel;
use crate::sensors::{Camera, Imu, Sensors};
use crate::time::{Schedule, ns_from_s};

/// An experiment ready to run: the keys, and what the files they name contain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// The keys.
    pub settings: Settings,
    /// The robots, from the front.
    pub robots: Vec<RobotSetup>,
    /// Half of each round trip of `links.trace` (ns), `None` where the file says lost; empty
    /// without a trace.
    pub half_round_trips_ns: Vec<Option<i64>>,
}

/// One robot of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotSetup {
    /// Its name, `r1` at the front.
    pub name: String,
    /// The truth that the plant simulates.
    pub model: RobotModel,
    /// Where c stands at the beginning: x (m), y (m), yaw (rad).
    pub pose: [f64; 3],
}

/// Every key of an experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The experiment's name.
    pub name: String,
    /// How long it lasts (s).
    pub duration_s: f64,
    /// Where all chance comes from.
    pub seed: u64,
    /// Lockstep in virtual time, or the wall clock.
    pub clock: Clock,
    /// What happens when a process dies.
    pub on_death: OnDeath,
    /// How many robots, and what they are.
    pub robots: Robots,
    /// How they keep together.
    pub formation: Formation,
    /// What the front robot drives.
    pub profile: Profile,
    /// What an open-loop experiment does instead of control.
    pub open_loop: OpenLoop,
    /// The controller of each robot.
    pub control: Control,
    /// The links from robot to robot.
    pub links: LinkSettings,
    /// The simulation.
    pub plant: Plant,
    /// The sensors besides the encoders, for the recording only: no controller sees them.
    pub sensors: SensorSettings,
    /// What goes into the recording.
    pub recording: RecordingRates,
}

/// The clock of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Lockstep: as fast as the machine goes, the same bits on every machine load.
    Virtual,
    /// Every loop keeps its own deadlines on the wall clock.
    Wall,
}

/// What happens when a process dies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OnDeath {
    /// The run ends.
    Stop,
    /// The others go on (wall clock only); the run's exit code is still 1.
    Continue,
    /// As `continue`, and a dead agent is started again and rejoins.
    Restart,
}

/// How many robots, and what they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robots {
    /// How many.
    pub count: u32,
    /// A robot.toml for all; empty: the paper's robot with wheel slip.
    pub model: String,
}

/// How the robots keep together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Formation {
    /// δ: distance to the one ahead, along the path that it drove (m). The paper's value.
    pub spacing_m: f64,
    /// When coordination begins (s); until then every robot follows the profile by itself.
    pub start_s: f64,
    /// How a follower knows v_r and w_r.
    pub feedforward: Feedforward,
}

/// How a follower knows v_r and w_r.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Feedforward {
    /// They travel with the position, as in Eq. 13.
    Message,
    /// All robots know the profile.
    Profile,
}

/// The front robot's speed over time: straight lines between the given points, constant after the
/// last. The default resembles Fig. 8 (the paper prints no numbers): faster from 5 s, slower after
/// 8 s, standing after 12 s, deceleration softer than acceleration, 4.3 m in all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// The points' times (s), rising.
    pub times_s: Vec<f64>,
    /// v_r at each (m/s).
    pub speeds_m_s: Vec<f64>,
    /// w_r at each (rad/s).
    pub yaw_rates_rad_s: Vec<f64>,
}

/// What an open-loop experiment does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpenLoop {
    /// Open loop in place of the two control loops.
    pub enabled: bool,
    /// Torque on each wheel (N m).
    pub torque_nm: f64,
    /// For how long from the beginning (s); none after that.
    pub torque_for_s: f64,
}

/// The controller of each robot. Its model of the robot is the nominal one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Control {
    /// How desired speeds become torques.
    pub law: Law,
    /// Period of the outer loop (s); the paper's 20 Hz.
    pub outer_period_s: f64,
    /// Period of the inner loop (s); the paper's 50 Hz.
    pub inner_period_s: f64,
    /// k_x of Eq. 12 (1/s).
    pub k_x: f64,
    /// k_y of Eq. 12 (1/m²).
    pub k_y: f64,
    /// k_θ of Eq. 12 (1/m).
    pub k_theta: f64,
    /// Proportional gain of each wheel's speed loop (N m s/rad).
    pub k_p: f64,
    /// Integral gain of each wheel's speed loop (N m/rad).
    pub k_i: f64,
    /// `computed_torque`: acceleration for an error of the speed (1/s).
    pub k_v: f64,
    /// The most that the motors give (N m); section 3 of the paper.
    pub torque_max_nm: f64,
    /// What keeps the wheels from slipping.
    pub torque_limit: TorqueLimit,
    /// μ_s in Eq. 11: what the controller believes of the floor (1).
    pub friction: f64,
    /// What `adaptive` believes of the floor before it has felt it (1).
    pub friction_start: f64,
    /// A follower without a fresh position for this long beyond the expected time stops (s).
    pub watchdog_s: f64,
    /// How it then slows down (m/s²).
    pub watchdog_deceleration_m_s2: f64,
    /// Encoders older than this mean that the plant is gone: no torque (s).
    pub plant_timeout_s: f64,
}

/// How desired speeds become torques.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// A PI controller for each wheel (section 3 of the paper).
    Paper,
    /// The robot's dynamics turned around, traction forces cut to what the floor carries.
    ComputedTorque,
}

/// What keeps the wheels from slipping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TorqueLimit {
    /// Nothing but the motors' own limit.
    None,
    /// Eq. 11 at the end of the inner loop.
    Inner,
    /// Desired speeds such that the inner loop asks for no more than Eq. 11.
    Outer,
    /// As `inner`, with the friction estimated while driving.
    Adaptive,
}

/// The links from robot to robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkSettings {
    /// Mean delay (s).
    pub delay_s: f64,
    /// Standard deviation of the delay (s).
    pub jitter_s: f64,
    /// The delay's distribution.
    pub distribution: Distribution,
    /// Share of messages lost, 0 to below 1.
    pub loss: f64,
    /// Mean length of a run of losses (messages, Gilbert–Elliott); 0: independent losses.
    pub burst: f64,
    /// Whether a message may overtake an earlier one.
    pub reorder: bool,
    /// An rtt.csv: message k takes half of row k mod n, plus the delay above; empty: none.
    pub trace: String,
    /// Who sends when.
    pub protocol: Protocol,
    /// The front robot starts the ring anew when the return is overdue by this (s).
    pub ring_timeout_s: f64,
}

/// The distribution of a random delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Distribution {
    /// Normal, cut at 0.
    Normal,
    /// Uniform, cut at 0.
    Uniform,
    /// Lognormal.
    Lognormal,
}

/// Who sends when.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// A robot sends after it received from the one ahead, the front one after the last one's
    /// return (section 4 of the paper).
    Ring,
    /// Every robot sends at each outer tick.
    Periodic,
}

/// The simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plant {
    /// Step of the plant (s).
    pub step_s: f64,
    /// Wall clock: a torque older than this is dropped, as motor drivers do (s).
    pub command_timeout_s: f64,
}

/// The sensors besides the encoders. A rate of 0: there is none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSettings {
    /// The camera above.
    pub camera: Camera,
    /// The inertial sensor at c.
    pub imu: Imu,
}

/// What goes into the recording besides every tick, message and event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingRates {
    /// True states, one in this time (s).
    pub state_period_s: f64,
    /// Whether the recording holds the trace, which `slipstream trace` reads.
    pub trace: bool,
}

impl Settings {
    /// When the loops are due.
    pub fn schedule(&self) -> Schedule {
        Schedule {
            outer_ns: ns_from_s(self.control.outer_period_s),
            inner_ns: ns_from_s(self.control.inner_period_s),
        }
    }

    /// Where robot `index` starts: x = δ (1 − index), so that the paper's second robot starts at
    /// the origin; an open-loop robot starts there itself.
    pub fn start_pose(&self, index: u32) -> [f64; 3] {
        if self.open_loop.enabled {
            return [0.0; 3];
        }
        [0.6096 * (1.0 - f64::from(index)), 0.0, 0.0]
    }

    /// How long a position takes at most around the ring when nothing is lost (ns): on each link
    /// the configured delay and the wait for the receiver's outer tick.
    pub fn expected_ring_round_ns(&self, longest_trace_ns: i64) -> i64 {
        let hop_s = self.links.delay_s + self.links.jitter_s + self.control.outer_period_s;
        i64::from(self.robots.count) * (ns_from_s(hop_s) + longest_trace_ns)
    }
}

impl SensorSettings {
    /// The sensors that there are.
    pub fn present(&self) -> Sensors {
        Sensors {
            camera: Some(self.camera.clone()).filter(|camera| camera.rate_hz != 0.0),
            imu: Some(self.imu.clone()).filter(|imu| imu.rate_hz != 0.0),
        }
    }
}

impl Experiment {
    /// The longest delay that the trace brings (ns); 0 without one.
    pub fn longest_trace_ns(&self) -> i64 {
        self.half_round_trips_ns
            .iter()
            .flatten()
            .copied()
            .max()
            .unwrap_or(0)
    }
}

impl Profile {
    /// v_r (m/s) and w_r (rad/s) at a time.
    pub fn at(&self, t_s: f64) -> (f64, f64) {
        let after = self.times_s.partition_point(|&t| t <= t_s);
        let value = |column: &[f64]| match (after.checked_sub(1), column.get(after)) {
            (None, first) => first.copied().unwrap_or(0.0),
            (Some(before), None) => column.get(before).copied().unwrap_or(0.0),
            (Some(before), Some(next)) => {
                let share =
                    (t_s - self.times_s[before]) / (self.times_s[after] - self.times_s[before]);
                column[before] + share * (next - column[before])
            }
        };
        (value(&self.speeds_m_s), value(&self.yaw_rates_rad_s))
    }
}
