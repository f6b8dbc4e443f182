//! Manoeuvres: desired speeds over time, and the open-loop commands for them.

use super::random::RandomStream;
use slipstream_trial_plant::{Commands, Physics, Quantity};

/// Period of the commands (s).
pub(crate) const COMMAND_PERIOD_S: f64 = 0.02;

/// Driving style.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Starts, stops and turns within the limits of friction.
    Lively,
    /// The same, beyond the limits of friction.
    Wild,
    /// Nearly constant speed and wide turns.
    Cruise,
}

/// The kind of command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    /// Torque at each wheel.
    Torque,
    /// Voltage at each motor.
    Voltage,
    /// Speed of each wheel.
    WheelSpeed,
    /// Speed and yaw rate.
    Twist,
}

impl CommandKind {
    /// The quantity that the command sets at the wheels.
    pub(crate) fn quantity(self) -> Quantity {
        match self {
            Self::Torque => Quantity::Torque,
            Self::Voltage => Quantity::Voltage,
            Self::WheelSpeed | Self::Twist => Quantity::Speed,
        }
    }
}

/// Desired [v (m/s), w (rad/s)] at the start of each command.
pub(crate) type DesiredTwists = Vec<[f64; 2]>;

/// The ranges of a driving style.
struct Ranges {
    /// Speed (m/s).
    speed: [f64; 2],
    /// Largest yaw rate (rad/s).
    rate: f64,
    /// Acceleration (m/s²).
    acceleration: [f64; 2],
    /// Yaw acceleration (rad/s²).
    turn: [f64; 2],
    /// How long a target is held (s).
    hold_s: [f64; 2],
    /// Probability that the next target is to stand still.
    stop: f64,
}

fn ranges(style: Style) -> Ranges {
    match style {
        Style::Lively => Ranges {
            speed: [-0.35, 0.9],
            rate: 2.5,
            acceleration: [0.3, 1.0],
            turn: [1.0, 4.0],
            hold_s: [0.2, 1.2],
            stop: 0.2,
        },
        Style::Wild => Ranges {
            speed: [-0.35, 1.1],
            rate: 3.0,
            acceleration: [0.8, 2.4],
            turn: [2.0, 9.0],
            hold_s: [0.2, 1.0],
            stop: 0.2,
        },
        Style::Cruise => Ranges {
            speed: [0.25, 0.4],
            rate: 0.4,
            acceleration: [0.08, 0.25],
            turn: [0.2, 0.6],
            hold_s: [2.0, 5.0],
            stop: 0.0,
        },
    }
}

/// Draws desired twists for `duration_s` (s): at rest first, then from target to target with limited
/// acceleration.
pub(crate) fn desired_twists(
    style: Style,
    duration_s: f64,
    random: &mut RandomStream,
) -> DesiredTwists {
    let ranges = ranges(style);
    let rows = (duration_s / COMMAND_PERIOD_S).round() as usize;
    let rest = (random.uniform(0.5, 1.0) / COMMAND_PERIOD_S) as usize;
    let mut desired = vec![[0.0; 2]; rest];
    let mut now = [0.0; 2];
    while desired.len() < rows {
        let stop = random.bernoulli(ranges.stop);
        let target = if stop {
            [0.0; 2]
        } else {
            let turns = random.bernoulli(0.75);
            let rate = random.uniform(-ranges.rate, ranges.rate);
            [
                random.uniform(ranges.speed[0], ranges.speed[1]),
                if turns { rate } else { 0.0 },
            ]
        };
        let [a, b] = ranges.acceleration;
        let [c, d] = ranges.turn;
        let most = [
            random.uniform(a, b) * COMMAND_PERIOD_S,
            random.uniform(c, d) * COMMAND_PERIOD_S,
        ];
        while now != target && desired.len() < rows {
            now = [0, 1].map(|i| now[i] + (target[i] - now[i]).clamp(-most[i], most[i]));
            desired.push(now);
        }
        let hold = random.uniform(ranges.hold_s[0], ranges.hold_s[1]);
        for _ in 0..(hold / COMMAND_PERIOD_S) as usize {
            desired.push(now);
        }
    }
    desired.truncate(rows);
    desired
}

/// The open-loop command at row `k`, by inverse dynamics of the nominal robot without slip.
pub(crate) fn open_loop(
    kind: CommandKind,
    desired: &DesiredTwists,
    k: usize,
    nominal: &Physics,
) -> [f64; 2] {
    let now = desired[k];
    let next = desired.get(k + 1).copied().unwrap_or(now);
    let change = [0, 1].map(|i| (next[i] - now[i]) / COMMAND_PERIOD_S);
    let command = match kind {
        CommandKind::Twist => now,
        CommandKind::WheelSpeed => Commands::wheel_speeds(now, nominal.nominal),
        CommandKind::Torque => torque(change, nominal),
        CommandKind::Voltage => {
            let speeds = Commands::wheel_speeds(now, nominal.nominal);
            let torque = torque(change, nominal);
            [0, 1].map(|i| (torque[i] + nominal.back_emf * speeds[i]) / nominal.per_volt)
        }
    };
    command.map(rounded)
}

/// Wheel torques for an acceleration [m/s², rad/s²] of the nominal robot without slip (N m).
fn torque([along, turning]: [f64; 2], p: &Physics) -> [f64; 2] {
    let (r, b) = (p.radius[0], p.half_track);
    let spin = p.spin_inertia / r;
    let mass = p.body_mass + 2.0 * p.wheel_mass;
    // About the middle of the axle, the centre of rotation.
    let inertia = p.body_inertia
        + 2.0 * p.wheel_yaw_inertia
        + p.body_mass * p.to_axle * p.to_axle
        + 2.0 * p.wheel_mass * b * b;
    let (even, odd) = (
        along * (mass * r / 2.0 + spin),
        turning * (inertia * r / (2.0 * b) + spin * b),
    );
    [even + odd, even - odd]
}

/// Rounded to six decimals, as in the recording.
pub(crate) fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
