//! What a robot is to do: speeds over time, and the commands that would bring them about.

use super::chance::Chance;
use crate::plant::{Commands, Physics, Quantity};

/// Commands hold for this long (s).
pub(crate) const HOLD_S: f64 = 0.02;

/// How a robot is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// Starts, stops and turns, up to what the floor carries.
    Lively,
    /// The same, beyond what the floor carries.
    Wild,
    /// Even speed, wide turns.
    Cruise,
}

/// What is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Told {
    /// Torque at each wheel.
    Torque,
    /// Voltage at each motor.
    Voltage,
    /// Speed of each wheel.
    WheelSpeed,
    /// Speed and yaw rate.
    Twist,
}

impl Told {
    /// What reaches the wheels.
    pub(crate) fn quantity(self) -> Quantity {
        match self {
            Self::Torque => Quantity::Torque,
            Self::Voltage => Quantity::Voltage,
            Self::WheelSpeed | Self::Twist => Quantity::Speed,
        }
    }
}

/// Speed and yaw rate wanted at each command's begin, [v (m/s), w (rad/s)].
pub(crate) type Wanted = Vec<[f64; 2]>;

/// Ranges of one style.
struct Ranges {
    speed: [f64; 2],
    rate: f64,
    acceleration: [f64; 2],
    turn: [f64; 2],
    hold_s: [f64; 2],
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

/// Draws what a robot is to do for `duration_s`: at rest first, then from target to target.
pub(crate) fn wanted(style: Style, duration_s: f64, chance: &mut Chance) -> Wanted {
    let ranges = ranges(style);
    let rows = (duration_s / HOLD_S).round() as usize;
    let rest = (chance.between(0.5, 1.0) / HOLD_S) as usize;
    let mut wanted = vec![[0.0; 2]; rest];
    let mut now = [0.0; 2];
    while wanted.len() < rows {
        let stop = chance.happens(ranges.stop);
        let target = if stop {
            [0.0; 2]
        } else {
            let turns = chance.happens(0.75);
            let rate = chance.between(-ranges.rate, ranges.rate);
            [
                chance.between(ranges.speed[0], ranges.speed[1]),
                if turns { rate } else { 0.0 },
            ]
        };
        let [a, b] = ranges.acceleration;
        let [c, d] = ranges.turn;
        let most = [chance.between(a, b) * HOLD_S, chance.between(c, d) * HOLD_S];
        while now != target && wanted.len() < rows {
            now = [0, 1].map(|i| now[i] + (target[i] - now[i]).clamp(-most[i], most[i]));
            wanted.push(now);
        }
        let hold = chance.between(ranges.hold_s[0], ranges.hold_s[1]);
        for _ in 0..(hold / HOLD_S) as usize {
            wanted.push(now);
        }
    }
    wanted.truncate(rows);
    wanted
}

/// The command at row `k` of an open loop, as it is told: by the nominal robot's inertia, rolling.
pub(crate) fn open_loop(told: Told, wanted: &Wanted, k: usize, nominal: &Physics) -> [f64; 2] {
    let now = wanted[k];
    let next = wanted.get(k + 1).copied().unwrap_or(now);
    let change = [0, 1].map(|i| (next[i] - now[i]) / HOLD_S);
    let told = match told {
        Told::Twist => now,
        Told::WheelSpeed => Commands::wheel_speeds(now, nominal.nominal),
        Told::Torque => torque(change, nominal),
        Told::Voltage => {
            let speeds = Commands::wheel_speeds(now, nominal.nominal);
            let torque = torque(change, nominal);
            [0, 1].map(|i| (torque[i] + nominal.back_emf * speeds[i]) / nominal.per_volt)
        }
    };
    told.map(rounded)
}

/// Torques that accelerate the nominal robot, rolling, by [m/s², rad/s²].
fn torque([along, turning]: [f64; 2], p: &Physics) -> [f64; 2] {
    let (r, b) = (p.radius[0], p.half_track);
    let spin = p.spin_inertia / r;
    let mass = p.body_mass + 2.0 * p.wheel_mass;
    // about the axle's middle, on which the robot turns
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

/// To six digits behind the point, as a recording holds it.
pub(crate) fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
