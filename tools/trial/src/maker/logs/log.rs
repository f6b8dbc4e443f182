//! One case of the plan `logs`, drawn but not yet made: the robot, its drives, its log, and what is concealed.

use super::course::Course;
use super::plant::{Floor, Plant};
use super::robot::{LogRobot, PoseKind, Streams};
use crate::maker::manoeuvre::{CommandKind, rounded};
use crate::maker::random::RandomStream;

/// What a stream of rows comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// What the robot was told.
    Command,
    /// Its wheels.
    Wheels,
    /// A reference: camera, scan matching.
    Pose,
    /// Its gyro.
    Gyro,
}

impl Source {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Command, Self::Wheels, Self::Pose, Self::Gyro];

    /// The effect of its latency; none of the command, whose clock is the reference.
    pub(crate) fn latency(self) -> Option<&'static str> {
        match self {
            Self::Command => None,
            Self::Wheels => Some("wheels_latency"),
            Self::Pose => Some("pose_latency"),
            Self::Gyro => Some("imu_latency"),
        }
    }

    /// Its name as the stream of a clock.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Command => "command",
            Self::Wheels => "wheels",
            Self::Pose => "pose",
            Self::Gyro => "imu",
        }
    }
}

/// One drive.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    pub(crate) duration_s: f64,
    pub(crate) floor: Floor,
    /// Latency of each source beyond that of the machine (s).
    pub(crate) latency_s: [f64; 4],
}

/// What the sensors are beyond what the model says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LogSensors {
    pub(crate) encoder_scale: [f64; 2],
    /// x, y (m) and yaw (rad) of the tracked point.
    pub(crate) pose_offset: [f64; 3],
    /// Latency of each source (s).
    pub(crate) latency_s: [f64; 4],
    /// Rate of the clock of each source, less 1.
    pub(crate) drift: [f64; 4],
    /// Noise of the position (m), the heading (rad) and the gyro (rad/s).
    pub(crate) noise: [f64; 3],
    /// Whether the recording says how large that noise is.
    pub(crate) noise_is_known: bool,
}

/// The value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Text(&'static str),
}

/// A concealed effect.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LogEffect {
    pub(crate) id: &'static str,
    pub(crate) parameters: Vec<(&'static str, Value)>,
    /// The run in which it acts with these parameters; none: all.
    pub(crate) run: Option<usize>,
    /// Error that its parameters may have beyond the usual one.
    pub(crate) tolerance: f64,
}

impl LogEffect {
    /// An effect of the machine, with numbers.
    pub(crate) fn new(id: &'static str, parameters: &[(&'static str, f64)]) -> Self {
        let numbers = parameters.iter();
        Self {
            id,
            parameters: numbers
                .map(|(name, value)| (*name, Value::Number(*value)))
                .collect(),
            run: None,
            tolerance: 0.0,
        }
    }

    /// The same of one run.
    pub(crate) fn in_run(self, run: usize) -> Self {
        let run = Some(run);
        Self { run, ..self }
    }
}

/// A nuisance that was drawn: its row in the table, and its size from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DrawnNuisance {
    pub(crate) row: usize,
    pub(crate) size: f64,
    /// The streams that have it, where it acts on rows.
    pub(crate) on: Vec<Source>,
}

/// A case, drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Log {
    pub(crate) seed: u64,
    pub(crate) robot: LogRobot,
    pub(crate) streams: Streams,
    pub(crate) course: Course,
    pub(crate) runs: Vec<Run>,
    pub(crate) plant: Plant,
    pub(crate) sensors: LogSensors,
    /// Stamp of the first run's start (s).
    pub(crate) epoch_s: f64,
    pub(crate) effects: Vec<LogEffect>,
    pub(crate) nuisances: Vec<DrawnNuisance>,
    /// Findings that nuisances bring and that are not wrong.
    pub(crate) allowed: Vec<&'static str>,
}

/// Purposes of the streams of random numbers of a case.
pub(crate) mod purpose {
    pub(crate) const ROBOT: u64 = 0;
    pub(crate) const EFFECTS: u64 = 1;
    pub(crate) const NUISANCES: u64 = 100;
    pub(crate) const COURSES: u64 = 1_000;
    pub(crate) const WANDER: u64 = 2_000;
    pub(crate) const SENSORS: u64 = 3_000;
    pub(crate) const FAULTS: u64 = 10_000;
}

impl Log {
    /// A robot with its streams and drives, without effects and nuisances.
    pub(crate) fn plain(seed: u64) -> Self {
        let mut random = RandomStream::new(seed, purpose::ROBOT);
        let robot = LogRobot::draw(&mut random);
        let long = random.bernoulli(0.04);
        let total_s = if long {
            random.log_uniform(120.0, 600.0)
        } else {
            random.log_uniform(20.0, 110.0)
        };
        let count = if random.bernoulli(0.55) {
            1.0
        } else {
            random.uniform(2.0, 7.0).floor()
        };
        let run = |random: &mut RandomStream| Run {
            duration_s: (f64::max(total_s / count * random.uniform(0.8, 1.2), 10.0) * 2.0).round()
                / 2.0,
            floor: Floor::default(),
            latency_s: [0.0; 4],
        };
        let runs = (0..count as usize).map(|_| run(&mut random)).collect();
        let streams = Streams::draw(long, &mut random);
        let track_m = 2.0 * robot.half_track_m;
        let noise = [
            track_m * random.log_uniform(0.002, 0.02),
            random.log_uniform(0.002, 0.01),
            random.log_uniform(0.002, 0.02),
        ];
        Self {
            seed,
            robot,
            streams,
            course: *random.choose(&Course::ALL),
            runs,
            plant: Plant::default(),
            sensors: LogSensors {
                encoder_scale: [1.0; 2],
                pose_offset: [0.0; 3],
                latency_s: [0.0; 4],
                drift: [0.0; 4],
                noise: noise.map(rounded),
                noise_is_known: random.bernoulli(0.5),
            },
            epoch_s: 0.0,
            effects: Vec::new(),
            nuisances: Vec::new(),
            allowed: Vec::new(),
        }
    }

    /// What the robot is told in a run: twists, or wheel speeds, rounded as in the log.
    pub(crate) fn commands(&self, run: usize) -> Vec<[f64; 2]> {
        let mut random = RandomStream::new(self.seed, purpose::COURSES + run as u64);
        let period_s = self.streams.periods_s[Source::Command as usize];
        let twists = self.course.twists(
            &self.robot,
            self.runs[run].duration_s,
            period_s,
            &mut random,
        );
        let told = twists.into_iter().map(|twist| match self.streams.command {
            Some(CommandKind::WheelSpeed) => self.robot.wheel_speeds(twist),
            _ => twist,
        });
        told.map(|pair| pair.map(rounded)).collect()
    }

    /// The wheel speeds that the robot is told in a run (rad/s).
    pub(crate) fn wheel_speeds(&self, run: usize) -> Vec<[f64; 2]> {
        let speeds = self
            .commands(run)
            .into_iter()
            .map(|told| match self.streams.command {
                Some(CommandKind::WheelSpeed) => told,
                _ => self.robot.wheel_speeds(told),
            });
        speeds.collect()
    }

    /// The sizes of all wheel speeds told while it drives, rising (rad/s).
    pub(crate) fn told_rad_s(&self) -> Vec<f64> {
        let told =
            (0..self.runs.len()).flat_map(|run| self.wheel_speeds(run).into_iter().flatten());
        let mut sizes: Vec<f64> = told.map(f64::abs).filter(|size| *size > 1e-6).collect();
        sizes.sort_by(f64::total_cmp);
        sizes
    }

    /// Whether there is this stream.
    pub(crate) fn has(&self, source: Source) -> bool {
        match source {
            Source::Command => self.streams.command.is_some(),
            Source::Wheels => self.streams.wheels.is_some(),
            Source::Pose => self.streams.pose.is_some(),
            Source::Gyro => self.streams.gyro,
        }
    }

    /// Whether a reference of poses sees the drives, not their ends alone.
    pub(crate) fn sees_drives(&self) -> bool {
        self.streams
            .pose
            .is_some_and(|kind| kind != PoseKind::Sparse)
    }

    /// Whether one of these effects is concealed.
    pub(crate) fn conceals(&self, any: &[&str]) -> bool {
        self.effects.iter().any(|effect| any.contains(&effect.id))
    }

    /// Duration of all runs (s).
    pub(crate) fn duration_s(&self) -> f64 {
        self.runs.iter().map(|run| run.duration_s).sum()
    }
}

/// The name of a run.
pub(crate) fn run_name(run: usize) -> String {
    format!("r{}", run + 1)
}

/// The value at a share of a rising list; 0 of none.
pub(crate) fn quantile(rising: &[f64], share: f64) -> f64 {
    let at = (rising.len().saturating_sub(1) as f64 * share).round() as usize;
    rising.get(at).copied().unwrap_or(0.0)
}
