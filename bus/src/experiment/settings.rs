//! Settings of an experiment: every key with its unit and meaning.
//!
//! The field names are the keys of an experiment file: `links.delay_s` is
//! [`LinkSettings::delay_s`]. The defaults are in `builtin.rs`. Only the launcher reads files; it
//! hands the settings to all processes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::change_table::ChangeTable;
use super::hears::Hears;
use super::parameters::{EVERY_ROBOT, Parameters, program_of};
use super::profile::Profile;
use crate::message::{RobotIndex, robot_name};
use crate::sensors::{Camera, Imu, Sensors};
use crate::time::{Schedule, ns_from_s};
use crate::twist_limits::TwistLimits;

/// Every key of an experiment. The default is the paper's platoon (section 4).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The experiment's name.
    pub name: String,
    /// Duration (s).
    pub duration_s: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Lockstep in virtual time, or the wall clock.
    pub clock: Clock,
    /// Reaction to the death of a process.
    pub on_death: OnDeath,
    /// A process that shows no sign of life for this long hangs, and is ended as by a death (s of
    /// wall time, on both clocks).
    pub watchdog_s: f64,
    /// In a run across hosts: a host from which nothing comes for this long ends the run (s of wall time).
    pub host_timeout_s: f64,
    /// Number of robots and their model.
    pub robots: Robots,
    /// Coordination of the formation.
    pub formation: Formation,
    /// Reference velocities of the front robot.
    pub profile: Profile,
    /// Open-loop torques in place of control.
    pub open_loop: OpenLoop,
    /// The controller of each robot.
    pub control: Control,
    /// Communication from robot to robot.
    pub links: LinkSettings,
    /// The simulated plant.
    pub plant: Plant,
    /// Sensors besides the encoders. They are recorded only; no controller uses them.
    pub sensors: SensorSettings,
    /// Content of the recording.
    pub recording: RecordingRates,
    /// What begins at a time in the run: an effect of a robot, or another delay of a link.
    #[serde(default)]
    pub changes: Vec<ChangeTable>,
    /// Programs that control robots in place of the built-in controller, by the robot's name; `*` for all robots without an entry of
    /// their own. Empty: the built-in controller.
    pub agents: BTreeMap<String, String>,
    /// Parameters of these programs, by the robot's name and the parameter's; `*` for all robots.
    pub controller: BTreeMap<String, Parameters>,
}

/// The clock of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Lockstep in virtual time: as fast as the machine can, and reproducible bit for bit.
    Virtual,
    /// Real time: every loop keeps its own deadlines on the wall clock.
    Wall,
}

/// Reaction to the death of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OnDeath {
    /// The run ends.
    Stop,
    /// The other processes continue (wall clock only). The exit code of the run is still 1.
    Continue,
    /// As `continue`; a dead agent is restarted and rejoins.
    Restart,
}

/// Number of robots and their model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robots {
    /// Number of robots.
    pub count: u32,
    /// A robot.toml for all robots; empty: the paper's robot with wheel slip.
    pub model: String,
    /// Where the robots start, from the front: lists of x, y and yaw of c, in m and rad. Those without an entry stand in a row
    /// along x.
    pub start: Vec<[f64; 3]>,
}

/// Coordination of the formation (section 4 of the paper).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Formation {
    /// δ: distance to the predecessor, along the path that it drove (m).
    pub spacing_m: f64,
    /// When coordination begins (s). Until then every robot follows the profile by itself.
    pub start_s: f64,
    /// Source of a follower's v_r and w_r.
    pub feedforward: Feedforward,
}

/// Source of a follower's reference velocities v_r and w_r.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Feedforward {
    /// They are sent with the position, and so are delayed with it (Eq. 13).
    Message,
    /// Every robot knows the profile.
    Profile,
}

/// Open-loop torques in place of control (section 3 of the paper).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpenLoop {
    /// Whether open-loop torques replace the two control loops.
    pub enabled: bool,
    /// Torque on each wheel (N m).
    pub torque_nm: f64,
    /// Duration of the torque from time 0 on (s); zero torque afterwards.
    pub torque_for_s: f64,
}

/// The controller of each robot. It uses the robot's nominal model, without effects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Control {
    /// Control law from desired velocities to torques.
    pub law: Law,
    /// What robots are told: torques by the inner loop, or the twist of the outer loop.
    pub drive: Drive,
    /// Period of the outer loop (s); 20 Hz in the paper.
    pub outer_period_s: f64,
    /// Period of the inner loop (s); 50 Hz in the paper.
    pub inner_period_s: f64,
    /// k_x of Eq. 12a (1/s).
    pub k_x: f64,
    /// k_y of Eq. 12b (1/m²).
    pub k_y: f64,
    /// k_θ of Eq. 12b (1/m).
    pub k_theta: f64,
    /// Proportional gain of each wheel's speed loop (N m s/rad).
    pub k_p: f64,
    /// Integral gain of each wheel's speed loop (N m/rad).
    pub k_i: f64,
    /// `computed_torque`: velocity gain, acceleration per velocity error (1/s).
    pub k_v: f64,
    /// Largest torque of a motor (N m); section 3 of the paper.
    pub torque_max_nm: f64,
    /// Torque limit that avoids wheel slip.
    pub torque_limit: TorqueLimit,
    /// μ_s in Eq. 11, as assumed by the controller (1).
    pub friction: f64,
    /// Initial friction estimate of `adaptive` (1).
    pub friction_start: f64,
    /// A follower brakes when a fresh position is overdue by this time (s).
    pub watchdog_s: f64,
    /// Deceleration of that braking (m/s²).
    pub watchdog_deceleration_m_s2: f64,
    /// Wall clock: a controller whose encoder readings are older than this commands no torque (s).
    pub plant_timeout_s: f64,
    /// Limits of v_d and w_d.
    pub limits: TwistLimits,
}

/// What robots are told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Drive {
    /// Wheel torques, by the inner loop of the controller.
    #[default]
    Torque,
    /// v_d and w_d of the outer loop: the robot has speed loops of its own. The controller's inner loop does not run.
    Twist,
}

/// Control law from desired velocities to torques.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// A PI speed controller for each wheel (section 3 of the paper).
    Paper,
    /// Computed torque: inverse dynamics with traction forces limited by friction.
    ComputedTorque,
}

/// Torque limit that avoids wheel slip (section 2.1 of the paper).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TorqueLimit {
    /// Only the limit of the motors.
    None,
    /// Eq. 11 at the end of the inner loop.
    Inner,
    /// Wheel speed set-points for which the inner loop commands no more than Eq. 11.
    Outer,
    /// As `inner`, with friction estimated online.
    Adaptive,
}

/// Communication from robot to robot: protocol, delay, jitter, loss.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkSettings {
    /// Mean delay (s).
    pub delay_s: f64,
    /// Standard deviation of the delay (s).
    pub jitter_s: f64,
    /// The delay's distribution.
    pub distribution: Distribution,
    /// Fraction of messages lost, from 0 to below 1 (1).
    pub loss: f64,
    /// Mean length of a loss burst (messages, Gilbert–Elliott model); 0: independent losses.
    pub burst: f64,
    /// Whether a message may overtake an earlier one.
    pub reorder: bool,
    /// A file of round-trip times: message k is delayed by half of row k mod n, in addition to the
    /// delay above; empty: none.
    pub trace: String,
    /// Who hears whom: `predecessor`, `leader_predecessor`, `two_predecessors`, `ring`, `all`, or links such as
    /// `r1>r2 r2>r3`. The ring protocol adds the link from the last robot to the front one to a topology that has a name; a list of
    /// links must have it.
    pub topology: Hears,
    /// When each robot sends.
    pub protocol: Protocol,
    /// The front robot starts a new token round when the last one is overdue by this time (s).
    pub ring_timeout_s: f64,
}

/// The distribution of a random delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Distribution {
    /// Normal, clipped at 0.
    Normal,
    /// Uniform, clipped at 0.
    Uniform,
    /// Lognormal.
    Lognormal,
}

/// When each robot sends its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Protocol {
    /// Token ring (section 4 of the paper): a robot sends after it received from its predecessor,
    /// the front robot after the position of the last one returned.
    Ring,
    /// Every robot sends at each outer tick.
    Periodic,
}

/// The simulated plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plant {
    /// Step size (s).
    pub step_s: f64,
    /// Wall clock: the plant drops a torque older than this, as motor drivers do (s).
    pub command_timeout_s: f64,
}

/// The sensors besides the encoders. A sensor with a rate of 0 is absent.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSettings {
    /// The external camera.
    pub camera: Camera,
    /// The inertial sensor at c.
    pub imu: Imu,
}

/// Content of the recording besides every tick, message and event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordingRates {
    /// Period of the recorded true states (s).
    pub state_period_s: f64,
    /// Whether the recording contains the trace, which `slipstream trace` reads.
    pub trace: bool,
}

impl Settings {
    /// The schedule of the control loops. A twist is passed on at once, so the inner tick follows the outer one.
    pub fn schedule(&self) -> Schedule {
        let outer_ns = ns_from_s(self.control.outer_period_s);
        Schedule {
            outer_ns,
            inner_ns: match self.control.drive {
                Drive::Torque => ns_from_s(self.control.inner_period_s),
                Drive::Twist => outer_ns,
            },
        }
    }

    /// Initial pose of c of robot `index`: as given, else x = 0.6096 m (1 − index), as in section 4 of the paper; an
    /// open-loop robot starts at the origin.
    pub fn start_pose(&self, index: u32) -> [f64; 3] {
        if self.open_loop.enabled {
            return [0.0; 3];
        }
        let given = self.robots.start.get(index as usize).copied();
        given.unwrap_or([0.6096 * (1.0 - f64::from(index)), 0.0, 0.0])
    }

    /// Expected duration of a token round without losses (ns): on each link the configured delay,
    /// the jitter, the longest delay of the trace, changes of the delay and the wait for the receiver's outer tick.
    pub fn expected_token_round_ns(&self, longest_trace_ns: i64) -> i64 {
        let hop_s = self.links.delay_s + self.links.jitter_s + self.control.outer_period_s;
        i64::from(self.robots.count) * (ns_from_s(hop_s) + longest_trace_ns)
            + self.longer_round_ns()
    }
}

impl Settings {
    /// The program that controls a robot; `None`: the built-in controller.
    pub fn program(&self, robot: RobotIndex) -> Option<&str> {
        program_of(&self.agents, robot)
    }

    /// The parameters that the experiment gives to the program that controls a robot.
    pub fn parameters(&self, robot: RobotIndex) -> Parameters {
        if self.program(robot).is_none() {
            return Parameters::new();
        }
        let tables = [EVERY_ROBOT.to_owned(), robot_name(robot)];
        let given = tables.iter().filter_map(|name| self.controller.get(name));
        let mut parameters = Parameters::new();
        for table in given {
            parameters.extend(table.clone());
        }
        parameters
    }
}

impl SensorSettings {
    /// The sensors whose rate is not 0.
    pub fn present(&self) -> Sensors {
        Sensors {
            camera: Some(self.camera.clone()).filter(|camera| camera.rate_hz != 0.0),
            imu: Some(self.imu.clone()).filter(|imu| imu.rate_hz != 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::ParameterValue;
    use super::*;

    #[test]
    fn a_robots_own_entries_come_before_those_for_all() {
        let mut settings = Settings::default();
        let program = |text: &str| text.to_owned();
        settings.agents.insert(program("*"), program("./a"));
        settings.agents.insert(program("r1"), String::new());
        assert_eq!(settings.program(0), None);
        assert_eq!(settings.program(1), Some("./a"));
        let table = |gain: f64, name: &str| {
            Parameters::from([(name.to_owned(), ParameterValue::Number(gain))])
        };
        settings.controller.insert(program("*"), table(1.0, "gain"));
        settings
            .controller
            .insert(program("r2"), table(2.0, "gain"));
        assert_eq!(settings.parameters(0), Parameters::new());
        assert_eq!(settings.parameters(1), table(2.0, "gain"));
        assert_eq!(settings.parameters(2), table(1.0, "gain"));
    }
}
