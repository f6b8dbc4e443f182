//! What a run reports about the truth: the state hash, slip, spacing errors, final poses.

use sha2::{Digest, Sha256};
use slipstream_bus::Experiment;
use slipstream_bus::record::{Record, Recorder, State};
use slipstream_bus::time::{ns_from_s, s_from_ns};

use super::spacing::Spacing;
use crate::{Truth, World};

/// A contact that slides faster than this slips (m/s).
const SLIPS_M_S: f64 = 0.003;
/// Spacing errors count from here on (ns).
const SPACING_FROM_NS: i64 = 3_000_000_000;

/// Watches the world through a run.
#[derive(Debug)]
pub struct Observer {
    hash: Option<Sha256>,
    steps: u64,
    spacing_m: f64,
    outer_ns: i64,
    state_ns: i64,
    robots: Vec<Watched>,
}

#[derive(Debug)]
struct Watched {
    report: RobotReport,
    slip_ns: [i64; 2],
    /// Behind which robot: the one ahead.
    spacing: Option<Spacing>,
}

/// The truth about a run.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct PlantReport {
    /// SHA-256 over every plant step, in hexadecimal; empty when it was not asked for.
    pub state_hash: String,
    /// When the run ended (s).
    pub duration_s: f64,
    /// Plant steps.
    pub steps: u64,
    /// The robots, from the front.
    pub robots: Vec<RobotReport>,
}

/// The truth about one robot of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct RobotReport {
    /// x (m), y (m), φ (rad) of c at the end.
    pub final_true: [f64; 3],
    /// How long each wheel's contact slid faster than 3 mm/s (s).
    pub slip_time_s: [f64; 2],
    /// The fastest sliding of each contact (m/s).
    pub max_slip_m_s: [f64; 2],
    /// The largest true spacing error from 3 s on (m); none for the front robot.
    pub max_spacing_error_m: Option<f64>,
}

impl Observer {
    /// Before the first step. Hashing costs about as much as a plant step.
    pub fn new(experiment: &Experiment, hashing: bool) -> Self {
        let settings = &experiment.settings;
        let in_formation = !settings.open_loop.enabled;
        let ahead = std::iter::once(None).chain(experiment.robots.iter().map(Some));
        let watched = |ahead: Option<&slipstream_bus::RobotSetup>| Watched {
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
            robots: ahead.take(experiment.robots.len()).map(watched).collect(),
        }
    }

    /// After a step of `dt_ns`.
    pub fn step(&mut self, world: &World, dt_ns: i64, recorder: &mut impl Recorder) {
        self.steps += 1;
        let now_ns = world.time_ns();
        if let Some(hash) = &mut self.hash {
            hash.update(now_ns.to_le_bytes());
        }
        let recorded = now_ns % self.state_ns == 0;
        for (i, watched) in self.robots.iter_mut().enumerate() {
            let truth = world.truth(i);
            if let Some(hash) = &mut self.hash {
                hash.update(state_bytes(&truth));
            }
            watched.slip(&truth, dt_ns);
            if recorded {
                recorder.record(&Record::State(state(i, now_ns, &truth)));
            }
        }
        if now_ns % self.outer_ns == 0 {
            self.measure_spacing(world, now_ns);
        }
    }

    /// The front robot's speed (m/s) and the spacing errors' largest so far (m).
    pub fn glance(&self, world: &World) -> (f64, f64) {
        let error = |watched: &Watched| watched.report.max_spacing_error_m;
        let largest = self.robots.iter().filter_map(error).fold(0.0, f64::max);
        (world.truth(0).velocity[0], largest)
    }

    /// After the last step.
    pub fn finish(self, world: &World) -> PlantReport {
        let final_robot = |(i, watched): (usize, Watched)| RobotReport {
            final_true: world.truth(i).pose,
            slip_time_s: watched.slip_ns.map(s_from_ns),
            ..watched.report
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
        for (i, watched) in self.robots.iter_mut().enumerate() {
            let Some(spacing) = &mut watched.spacing else {
                continue;
            };
            spacing.extend(world.truth(i - 1).pose);
            if now_ns >= SPACING_FROM_NS {
                let error = (spacing.behind(world.truth(i).pose) - self.spacing_m).abs();
                let largest = watched.report.max_spacing_error_m.unwrap_or(0.0);
                watched.report.max_spacing_error_m = Some(largest.max(error));
            }
        }
    }
}

impl Watched {
    fn slip(&mut self, truth: &Truth, dt_ns: i64) {
        for wheel in 0..2 {
            let slip_m_s = truth.slip_m_s[wheel];
            let largest = &mut self.report.max_slip_m_s[wheel];
            *largest = largest.max(slip_m_s);
            if slip_m_s > SLIPS_M_S {
                self.slip_ns[wheel] += dt_ns;
            }
        }
    }
}

/// The bits that the state hash covers: pose, velocity, wheel angles and speeds, torques.
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

fn state(robot: usize, t_ns: i64, truth: &Truth) -> State {
    State {
        t_ns,
        robot: u32::try_from(robot).unwrap_or(u32::MAX),
        pose: truth.pose,
        velocity: truth.velocity,
        wheel_angle_rad: truth.wheel_angle_rad,
        wheel_speed_rad_s: truth.wheel_speed_rad_s,
        torque_nm: truth.torque_nm,
        normal_n: truth.contact.normal_n,
        slip_m_s: truth.slip_parts_m_s,
        slides: truth.slides,
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
