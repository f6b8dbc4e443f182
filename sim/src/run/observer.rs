//! Ground truth of a run: state hash, slip, spacing errors and final poses.

use sha2::{Digest, Sha256};
use slipstream_bus::record::{Record, Recorder, State};
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_bus::{Experiment, RobotSetup};

use super::spacing::{SPACING_FROM_S, Spacing};
use crate::{Truth, World};

/// Slip speed from which slip time counts (m/s).
const SLIP_MIN_M_S: f64 = 0.003;

/// Accumulates the report of a run, step by step, and records states.
#[derive(Debug)]
pub struct Observer {
    hash: Option<Sha256>,
    steps: u64,
    spacing_m: f64,
    outer_ns: i64,
    state_ns: i64,
    robots: Vec<ObservedRobot>,
}

#[derive(Debug)]
struct ObservedRobot {
    report: RobotReport,
    slip_ns: [i64; 2],
    /// Path of the robot ahead; `None` for the front robot and in open loop.
    spacing: Option<Spacing>,
}

/// Ground truth of a run.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct PlantReport {
    /// SHA-256 over the states after every plant step, in hexadecimal; empty without hashing.
    pub state_hash: String,
    /// Time at which the run ended (s).
    pub duration_s: f64,
    /// Number of plant steps.
    pub steps: u64,
    /// The robots, from front to rear.
    pub robots: Vec<RobotReport>,
}

/// Ground truth of one robot in a run. Pairs are [right, left].
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct RobotReport {
    /// x and y of c (m) and heading φ (rad) at the end.
    pub final_true: [f64; 3],
    /// Time during which each wheel's contact slid faster than 3 mm/s (s).
    pub slip_time_s: [f64; 2],
    /// Largest slip speed of each contact (m/s).
    pub max_slip_m_s: [f64; 2],
    /// Largest true spacing error from 3 s on (m); `None` for the front robot.
    pub max_spacing_error_m: Option<f64>,
}

impl Observer {
    /// For a run of `experiment` that has not begun. `hashing` the states costs about as much as a
    /// plant step.
    pub fn new(experiment: &Experiment, hashing: bool) -> Self {
        let settings = &experiment.settings;
        let in_formation = !settings.open_loop.enabled;
        let ahead = std::iter::once(None).chain(experiment.robots.iter().map(Some));
        let observed = |ahead: Option<&RobotSetup>| ObservedRobot {
            report: RobotReport::default(),
            slip_ns: [0; 2],
            spacing: ahead
                .filter(|_| in_formation)
                .map(|robot| Spacing::new(robot.pose)),
        };
        Self {
            hash: hashing.then(Sha256::new),
            steps: 0,
            spacing_m: settings.formation.spacing_m,
            outer_ns: settings.schedule().outer_ns,
            state_ns: ns_from_s(settings.recording.state_period_s),
            robots: ahead.take(experiment.robots.len()).map(observed).collect(),
        }
    }

    /// Observes the world after a step of `dt_ns` (ns).
    pub fn step(&mut self, world: &World, dt_ns: i64, recorder: &mut impl Recorder) {
        self.steps += 1;
        let now_ns = world.time_ns();
        if let Some(hash) = &mut self.hash {
            hash.update(now_ns.to_le_bytes());
        }
        let recorded = now_ns % self.state_ns == 0;
        for (i, observed) in self.robots.iter_mut().enumerate() {
            let truth = world.truth(i);
            if let Some(hash) = &mut self.hash {
                hash.update(state_bytes(&truth));
            }
            observed.observe_slip(&truth, dt_ns);
            if recorded {
                recorder.record(&Record::State(state_record(i, now_ns, &truth)));
            }
        }
        if now_ns % self.outer_ns == 0 {
            self.measure_spacing(world, now_ns);
        }
    }

    /// Speed of the front robot (m/s) and largest spacing error so far (m), for a progress display.
    pub fn progress(&self, world: &World) -> (f64, f64) {
        let error = |observed: &ObservedRobot| observed.report.max_spacing_error_m;
        let largest = self.robots.iter().filter_map(error).fold(0.0, f64::max);
        (world.truth(0).velocity[0], largest)
    }

    /// The report, after the last step.
    pub fn finish(self, world: &World) -> PlantReport {
        let final_robot = |(i, observed): (usize, ObservedRobot)| RobotReport {
            final_true: world.truth(i).pose,
            slip_time_s: observed.slip_ns.map(s_from_ns),
            ..observed.report
        };
        PlantReport {
            state_hash: self
                .hash
                .map(|hash| hex(&hash.finalize()))
                .unwrap_or_default(),
            duration_s: s_from_ns(world.time_ns()),
            steps: self.steps,
            robots: self
                .robots
                .into_iter()
                .enumerate()
                .map(final_robot)
                .collect(),
        }
    }

    fn measure_spacing(&mut self, world: &World, now_ns: i64) {
        let counts = now_ns >= ns_from_s(SPACING_FROM_S);
        for (i, observed) in self.robots.iter_mut().enumerate() {
            let Some(spacing) = &mut observed.spacing else {
                continue;
            };
            spacing.extend(world.truth(i - 1).pose);
            if counts {
                let error = (spacing.distance(world.truth(i).pose) - self.spacing_m).abs();
                let largest = observed.report.max_spacing_error_m.unwrap_or(0.0);
                observed.report.max_spacing_error_m = Some(largest.max(error));
            }
        }
    }
}

impl ObservedRobot {
    fn observe_slip(&mut self, truth: &Truth, dt_ns: i64) {
        for wheel in 0..2 {
            let slip_m_s = truth.slip_speed_m_s[wheel];
            let largest = &mut self.report.max_slip_m_s[wheel];
            *largest = largest.max(slip_m_s);
            if slip_m_s > SLIP_MIN_M_S {
                self.slip_ns[wheel] += dt_ns;
            }
        }
    }
}

/// The bytes that the state hash covers: pose, velocity, wheel angles and speeds, torques.
fn state_bytes(truth: &Truth) -> [u8; 96] {
    let values = truth
        .pose
        .iter()
        .chain(&truth.velocity)
        .chain(&truth.wheel_angle_rad)
        .chain(&truth.wheel_speed_rad_s)
        .chain(&truth.torque_nm);
    let mut bytes = [0; 96];
    for (place, value) in bytes.chunks_exact_mut(8).zip(values) {
        place.copy_from_slice(&value.to_bits().to_le_bytes());
    }
    bytes
}

fn state_record(robot: usize, t_ns: i64, truth: &Truth) -> State {
    State {
        t_ns,
        robot: u32::try_from(robot).unwrap_or(u32::MAX),
        pose: truth.pose,
        velocity: truth.velocity,
        wheel_angle_rad: truth.wheel_angle_rad,
        wheel_speed_rad_s: truth.wheel_speed_rad_s,
        torque_nm: truth.torque_nm,
        normal_n: truth.contact.normal_n,
        slip_m_s: truth.slip_m_s,
        slides: truth.slides,
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
