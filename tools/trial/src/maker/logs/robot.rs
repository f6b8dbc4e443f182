//! Robots as they are sold and built, and what their logs hold.

use crate::maker::manoeuvre::{CommandKind, rounded};
use crate::maker::random::RandomStream;

/// Least and largest distance between the wheels (m).
const TRACK_M: [f64; 2] = [0.09, 1.2];
/// Least and largest speed that a robot is driven at (m/s).
const SPEED_M_S: [f64; 2] = [0.05, 4.0];

/// A robot with two driven wheels (or sides).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LogRobot {
    pub(crate) wheel_radius_m: f64,
    pub(crate) half_track_m: f64,
    /// Largest speed that it is told (m/s).
    pub(crate) speed_m_s: f64,
    /// Largest yaw rate that it is told (rad/s).
    pub(crate) turn_rad_s: f64,
}

impl LogRobot {
    /// Draws a robot: larger wheels on wider ones, faster where larger.
    pub(crate) fn draw(random: &mut RandomStream) -> Self {
        let radius = random.log_uniform(0.016, 0.3);
        let [narrow, wide] = TRACK_M;
        let track = (radius * random.log_uniform(2.5, 8.0)).clamp(narrow, wide);
        let [slow, fast] = SPEED_M_S;
        let speed = (track * random.log_uniform(0.6, 5.0)).clamp(slow, fast);
        let turn = (speed / track * random.uniform(1.0, 2.0)).clamp(0.3, 3.0);
        Self {
            wheel_radius_m: rounded(radius),
            half_track_m: rounded(track / 2.0),
            speed_m_s: rounded(speed),
            turn_rad_s: rounded(turn),
        }
    }

    /// Wheel speeds [right, left] (rad/s) of a twist, by the nominal geometry.
    pub(crate) fn wheel_speeds(&self, [v, w]: [f64; 2]) -> [f64; 2] {
        let across = self.half_track_m * w;
        [v + across, v - across].map(|rim| rim / self.wheel_radius_m)
    }

    /// Twist of wheel speeds, by the nominal geometry.
    pub(crate) fn twist(&self, [right, left]: [f64; 2]) -> [f64; 2] {
        let r = self.wheel_radius_m;
        [
            r * (right + left) / 2.0,
            r * (right - left) / (2.0 * self.half_track_m),
        ]
    }
}

/// How wheels are logged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum WheelKind {
    /// Counters.
    Ticks,
    /// Angles from a counter whose counts per turn need not be whole.
    Angles,
    /// Mean speeds since the row before, from a counter.
    MeanSpeeds,
    /// Speeds at the instant, to the digit.
    Speeds,
}

/// What the reference sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PoseKind {
    /// Position and heading.
    Full,
    /// Position alone.
    Position,
    /// Position and heading at rest, before and after the drive.
    Sparse,
}

/// The streams of a log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Streams {
    pub(crate) command: Option<CommandKind>,
    pub(crate) wheels: Option<WheelKind>,
    pub(crate) pose: Option<PoseKind>,
    pub(crate) gyro: bool,
    /// Whether the gyro is read at the instant of a row; else it is the mean over a period about it.
    pub(crate) momentary_gyro: bool,
    /// Counts per turn of a wheel.
    pub(crate) counts: f64,
    /// Periods of command, wheels, pose and gyro (s).
    pub(crate) periods_s: [f64; 4],
}

/// Which streams there are: probability, command, wheels, pose, gyro.
const SETS: [(f64, [bool; 4]); 6] = [
    (0.30, [true, true, true, false]),
    (0.10, [true, true, true, true]),
    (0.15, [true, true, false, true]),
    (0.17, [false, true, true, false]),
    (0.13, [true, false, true, false]),
    (0.15, [false, true, false, true]),
];

impl Streams {
    /// Draws the streams; `slow` ones for long recordings.
    pub(crate) fn draw(slow: bool, random: &mut RandomStream) -> Self {
        let mut at = random.unit();
        let drawn = SETS.iter().find(|(share, _)| {
            at -= share;
            at < 0.0
        });
        let [command, wheels, pose, gyro] = drawn.unwrap_or(&SETS[0]).1;
        let kind = if random.bernoulli(0.7) {
            CommandKind::Twist
        } else {
            CommandKind::WheelSpeed
        };
        let counts = random.log_uniform(500.0, 400_000.0).round();
        let fastest = if slow { 20.0 } else { 50.0 };
        let mut period = |least: f64| rounded(1.0 / random.log_uniform(least, fastest).round());
        Self {
            command: command.then_some(kind),
            wheels: wheels.then_some(WheelKind::Ticks),
            pose: pose.then_some(PoseKind::Full),
            gyro,
            momentary_gyro: false,
            counts,
            periods_s: [period(10.0), period(10.0), period(5.0), period(15.0)],
        }
    }
}
