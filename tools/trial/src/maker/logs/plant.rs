//! A kinematic robot: its drive, the contact of its wheels with the floor, and exact arcs at 1 kHz.

use super::robot::LogRobot;
use super::wander::{WANDER_PERIOD_S, Wander, Wandering};
use crate::maker::random::RandomStream;

/// Step of the simulation (s).
pub(crate) const STEP_S: f64 = 1e-3;
/// Steps in a period of the noise.
const NOISE_STEPS: usize = (WANDER_PERIOD_S / STEP_S) as usize;
/// Share of the largest speed below which a robot stands, and does not wander.
const STANDS_SHARE: f64 = 1e-3;
/// Share of the largest yaw rate below which a curve is gentle.
const GENTLE_SHARE: f64 = 0.2;

/// What the robot really is and does; a new one is as its nominal model says. Pairs are [right, left].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Plant {
    pub(crate) delay_s: f64,
    pub(crate) dead_band_rad_s: f64,
    pub(crate) dead_zone_rad_s: f64,
    pub(crate) saturation_rad_s: f64,
    pub(crate) lag_s: f64,
    pub(crate) gain: [f64; 2],
    pub(crate) sag_per_s: f64,
    /// Share of the command that its integral action brings, and after how long (s).
    pub(crate) slow: [f64; 2],
    pub(crate) radius_scale: [f64; 2],
    pub(crate) track_scale: f64,
    pub(crate) skid: Option<Skid>,
    /// Speed lost for each rad/s of turning (m).
    pub(crate) turn_loss_m: f64,
    pub(crate) noise: Vec<Wander>,
}

/// The effective track of a robot that skids.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Skid {
    pub(crate) scale: f64,
    /// By how much larger to the left, and smaller to the right.
    pub(crate) aside: f64,
    /// By how much smaller in the gentlest curves.
    pub(crate) gentle: f64,
}

/// The floor of one run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Floor {
    pub(crate) slip_ratio: f64,
    /// Factor of the effective track.
    pub(crate) track: f64,
}

impl Default for Plant {
    fn default() -> Self {
        Self {
            delay_s: 0.0,
            dead_band_rad_s: 0.0,
            dead_zone_rad_s: 0.0,
            saturation_rad_s: f64::INFINITY,
            lag_s: 0.0,
            gain: [1.0; 2],
            sag_per_s: 0.0,
            slow: [0.0, 1.0],
            radius_scale: [1.0; 2],
            track_scale: 1.0,
            skid: None,
            turn_loss_m: 0.0,
            noise: Vec::new(),
        }
    }
}

impl Default for Floor {
    fn default() -> Self {
        Self {
            slip_ratio: 0.0,
            track: 1.0,
        }
    }
}

impl Skid {
    /// Factor of the track at a yaw rate by the nominal geometry.
    pub(crate) fn at(&self, turn_rad_s: f64, largest_rad_s: f64) -> f64 {
        let gentle = (-turn_rad_s.abs() / (GENTLE_SHARE * largest_rad_s)).exp();
        self.scale * (1.0 + self.aside * turn_rad_s.signum()) * (1.0 - self.gentle * gentle)
    }
}

/// What the robot did, at every step from 0 on.
#[derive(Debug, Clone, Default)]
pub(crate) struct Trace {
    states: Vec<State>,
}

/// The robot at one instant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct State {
    /// Middle of the axle: x, y (m), yaw (rad).
    pub(crate) pose: [f64; 3],
    /// Yaw rate (rad/s).
    pub(crate) turn_rad_s: f64,
    /// Wheel angles (rad).
    pub(crate) angle_rad: [f64; 2],
    /// Wheel speeds (rad/s).
    pub(crate) speed_rad_s: [f64; 2],
}

impl Trace {
    /// The state at a time, between two steps on the line between them.
    pub(crate) fn at(&self, t_s: f64) -> State {
        let last = self.states.len().saturating_sub(1);
        let place = (t_s / STEP_S).clamp(0.0, last as f64);
        let from = (place as usize).min(last.saturating_sub(1));
        let share = place - from as f64;
        let (Some(a), Some(b)) = (self.states.get(from), self.states.get((from + 1).min(last)))
        else {
            return State::default();
        };
        let blend = |one: f64, other: f64| one + (other - one) * share;
        State {
            pose: std::array::from_fn(|i| blend(a.pose[i], b.pose[i])),
            turn_rad_s: blend(a.turn_rad_s, b.turn_rad_s),
            angle_rad: std::array::from_fn(|i| blend(a.angle_rad[i], b.angle_rad[i])),
            speed_rad_s: std::array::from_fn(|i| blend(a.speed_rad_s[i], b.speed_rad_s[i])),
        }
    }
}

impl Plant {
    /// Drives for the time of the commands: wheel speeds (rad/s) at every period.
    pub(crate) fn drive(
        &self,
        robot: &LogRobot,
        floor: &Floor,
        commands: &[[f64; 2]],
        period_s: f64,
        mut random: impl FnMut(usize) -> RandomStream,
    ) -> Trace {
        let steps = (commands.len() as f64 * period_s / STEP_S) as usize;
        let mut noise: Vec<Wandering<'_>> = self
            .noise
            .iter()
            .enumerate()
            .map(|(at, wander)| Wandering::new(wander, random(at)))
            .collect();
        let mut state = State::default();
        let (mut slow, mut drift) = ([0.0; 2], [0.0; 2]);
        let mut states = vec![state];
        for k in 0..steps {
            let t_s = k as f64 * STEP_S;
            let target = self.mean_target(commands, period_s, t_s, &mut slow);
            let mean = self.follow(&mut state.speed_rad_s, target);
            let [rim, _] = robot.twist(state.speed_rad_s.map(f64::abs));
            let share = rim / robot.speed_m_s;
            if k % NOISE_STEPS == 0 {
                let now = noise.iter_mut().map(|own| own.step(share));
                drift = now.fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]]);
            }
            let [v, w] = self.contact(robot, floor, mean);
            let moves = f64::from(u8::from(share > STANDS_SHARE));
            step(
                &mut state,
                mean,
                [v + moves * drift[0], w + moves * drift[1]],
            );
            states.push(state);
        }
        Trace { states }
    }

    /// Wheel speeds that the drive aims at in the mean over a step: a new command acts from its instant on.
    fn mean_target(
        &self,
        commands: &[[f64; 2]],
        period_s: f64,
        t_s: f64,
        slow: &mut [f64; 2],
    ) -> [f64; 2] {
        let from_s = t_s - self.delay_s;
        let row = |t_s: f64| (t_s / period_s + 1e-9).floor();
        let aim = |row: f64| {
            let at = (row.max(0.0) as usize).min(commands.len() - 1);
            let told = if row < 0.0 { [0.0; 2] } else { commands[at] };
            self.target(told, t_s)
        };
        let (first, last) = (row(from_s), row(from_s + STEP_S));
        let before = if first < last {
            ((last * period_s - from_s) / STEP_S).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let (one, other) = (aim(first), aim(last));
        let [share, time_s] = self.slow;
        let decay = (-STEP_S / time_s).exp();
        [0, 1].map(|i| {
            let target = before * one[i] + (1.0 - before) * other[i];
            slow[i] = target + (slow[i] - target) * decay;
            target + share * (slow[i] - target)
        })
    }

    /// Behind dead band, dead zone, saturation, gain and sag.
    fn target(&self, told: [f64; 2], t_s: f64) -> [f64; 2] {
        let sag = 1.0 - self.sag_per_s * t_s;
        [0, 1].map(|i| {
            let size = told[i].abs();
            let passes = f64::from(u8::from(size >= self.dead_band_rad_s));
            let size = (passes * size - self.dead_zone_rad_s / self.gain[i]).max(0.0);
            told[i].signum() * size.min(self.saturation_rad_s) * self.gain[i] * sag
        })
    }

    /// Lets wheel speeds follow a target for a step; returns their mean.
    fn follow(&self, speed: &mut [f64; 2], target: [f64; 2]) -> [f64; 2] {
        if self.lag_s <= 0.0 {
            *speed = target;
            return target;
        }
        let left = (-STEP_S / self.lag_s).exp();
        let before = *speed;
        *speed = [0, 1].map(|i| target[i] + (before[i] - target[i]) * left);
        let mean_left = self.lag_s / STEP_S * (1.0 - left);
        [0, 1].map(|i| target[i] + (before[i] - target[i]) * mean_left)
    }

    /// Twist of the robot that comes of wheel speeds, without noise.
    pub(crate) fn contact(&self, robot: &LogRobot, floor: &Floor, speed: [f64; 2]) -> [f64; 2] {
        let grip = 1.0 - floor.slip_ratio;
        let rims = [0, 1].map(|i| speed[i] * self.radius_scale[i] * robot.wheel_radius_m * grip);
        let v = (rims[0] + rims[1]) / 2.0;
        let [_, nominal] = robot.twist(speed);
        let skid = self
            .skid
            .as_ref()
            .map_or(1.0, |skid| skid.at(nominal, robot.turn_rad_s));
        let track_m = 2.0 * robot.half_track_m * self.track_scale * floor.track * skid;
        let w = (rims[0] - rims[1]) / track_m;
        let lost = (self.turn_loss_m * w.abs()).min(v.abs());
        [v - lost * v.signum(), w]
    }
}

/// One step along an arc, with these mean wheel speeds and this twist.
fn step(state: &mut State, speed_rad_s: [f64; 2], [v, w]: [f64; 2]) {
    let half = w * STEP_S / 2.0;
    let chord = v
        * STEP_S
        * if half.abs() > 1e-9 {
            half.sin() / half
        } else {
            1.0
        };
    let [x, y, yaw] = state.pose;
    let (sin, cos) = (yaw + half).sin_cos();
    state.pose = [x + chord * cos, y + chord * sin, yaw + 2.0 * half];
    state.turn_rad_s = w;
    state.angle_rad = [0, 1].map(|i| state.angle_rad[i] + speed_rad_s[i] * STEP_S);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot() -> LogRobot {
        LogRobot {
            wheel_radius_m: 0.1,
            half_track_m: 0.25,
            speed_m_s: 1.0,
            turn_rad_s: 1.0,
        }
    }

    /// Driven for 10 s at constant wheel speeds.
    fn driven(plant: &Plant, floor: &Floor, speeds: [f64; 2]) -> Trace {
        plant.drive(&robot(), floor, &[speeds; 200], 0.05, |at| {
            RandomStream::new(1, at as u64)
        })
    }

    #[test]
    fn a_nominal_robot_drives_a_circle() {
        // v = 0.5 m/s, w = 0.4 rad/s
        let trace = driven(&Plant::default(), &Floor::default(), [6.0, 4.0]);
        let [x, y, yaw] = trace.at(10.0).pose;
        assert!((yaw - 4.0).abs() < 1e-9);
        assert!(
            (x - 1.25 * 4f64.sin()).abs() < 1e-9 && (y - 1.25 * (1.0 - 4f64.cos())).abs() < 1e-9
        );
        assert!((trace.at(2.0005).angle_rad[0] - 12.003).abs() < 1e-9);
    }

    /// A change of the robot, a time (s), and the wheel speed that it has then (rad/s).
    type Expected = (fn(&mut Plant), f64, f64);

    /// Wheel speed (rad/s) of a changed robot that is told 5 rad/s.
    fn speed_of(change: fn(&mut Plant), t_s: f64) -> f64 {
        let mut plant = Plant::default();
        change(&mut plant);
        driven(&plant, &Floor::default(), [5.0; 2])
            .at(t_s)
            .speed_rad_s[0]
    }

    #[test]
    fn each_part_of_the_drive_does_what_its_name_says() {
        let exactly: [Expected; 6] = [
            (|plant| plant.delay_s = 0.2, 0.19, 0.0),
            (|plant| plant.delay_s = 0.2, 0.21, 5.0),
            (|plant| plant.dead_band_rad_s = 5.1, 1.0, 0.0),
            (|plant| plant.dead_zone_rad_s = 1.0, 1.0, 4.0),
            (|plant| plant.saturation_rad_s = 3.0, 1.0, 3.0),
            (|plant| plant.gain = [0.8; 2], 1.0, 4.0),
        ];
        for (change, t_s, speed) in exactly {
            assert!((speed_of(change, t_s) - speed).abs() < 1e-12, "{speed}");
        }
        let lagging = 5.0 * (1.0 - (-1f64).exp());
        let nearly: [Expected; 4] = [
            (|plant| plant.sag_per_s = 0.02, 5.0, 4.5),
            (|plant| plant.lag_s = 0.5, 0.5, lagging),
            (|plant| plant.slow = [0.3, 1.0], 0.002, 3.5),
            (|plant| plant.slow = [0.3, 1.0], 9.0, 5.0),
        ];
        for (change, t_s, speed) in nearly {
            assert!((speed_of(change, t_s) - speed).abs() < 0.01, "{speed}");
        }
    }

    #[test]
    fn commands_act_at_their_instant_and_lags_are_exact() {
        // rest, then 5 rad/s from 0.0333 s on
        let commands = [vec![[0.0; 2]], vec![[5.0; 2]; 60]].concat();
        let angle = |lag_s: f64| {
            let plant = Plant {
                lag_s,
                ..Plant::default()
            };
            let random = |at| RandomStream::new(1, at as u64);
            let trace = plant.drive(&robot(), &Floor::default(), &commands, 0.0333, random);
            trace.at(1.0).angle_rad[0]
        };
        assert!((angle(0.0) - 5.0 * 0.9667).abs() < 1e-9);
        let behind = 0.2 * (1.0 - (-0.9667f64 / 0.2).exp());
        assert!((angle(0.2) - 5.0 * (0.9667 - behind)).abs() < 1e-5);
    }

    #[test]
    fn each_part_of_the_contact_does_what_its_name_says() {
        let twist = |plant: Plant, floor: Floor, speeds| plant.contact(&robot(), &floor, speeds);
        let floor = Floor::default;
        let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| {
            assert!((a - c).abs() + (b - d).abs() < 1e-9, "{a} {b}")
        };
        let larger = Plant {
            radius_scale: [1.1, 1.0],
            ..Plant::default()
        };
        near(twist(larger, floor(), [5.0; 2]), [0.525, 0.1]);
        let wider = Plant {
            track_scale: 2.0,
            ..Plant::default()
        };
        near(twist(wider, floor(), [6.0, 4.0]), [0.5, 0.2]);
        let carpet = Floor {
            slip_ratio: 0.2,
            ..floor()
        };
        near(twist(Plant::default(), carpet, [6.0, 4.0]), [0.4, 0.32]);
        let losing = Plant {
            turn_loss_m: 0.1,
            ..Plant::default()
        };
        near(twist(losing, floor(), [6.0, 4.0]), [0.46, 0.4]);
    }

    #[test]
    fn a_skid_track_is_larger_to_one_side_and_smaller_in_gentle_curves() {
        let skid = Skid {
            scale: 1.5,
            aside: 0.05,
            gentle: 0.2,
        };
        assert!(skid.at(1.0, 1.0) > skid.at(-1.0, 1.0));
        assert!(skid.at(0.05, 1.0) < 0.9 * skid.at(1.0, 1.0));
        assert!((skid.at(1.0, 1.0) + skid.at(-1.0, 1.0) - 3.0).abs() < 0.01);
    }
}
