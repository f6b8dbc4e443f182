//! One window simulated from its start, and compared with everything measured in it.

use slipstream_sim::{CommandKind, Robot, State};

use crate::data::track::{Sensor, Track};
use crate::predict::window::{LOCALS, Window};

/// Commands before the window that the drive train may still feel (s).
const MEMORY_S: f64 = 2.0;

/// Measurements from before the window's start by more than this say nothing (s).
const BEFORE_S: f64 = 2e-3;

/// How far the simulation goes on beyond the window for measurements stamped early (s).
const BEYOND_S: f64 = 0.5;

/// A residual larger than this says no more than that it is off (deviations).
const LARGEST_RESIDUAL: f64 = 1e5;

/// Residual of an acceleration from which on it counts less (deviations).
const SOFT: f64 = 3.0;

/// A robot, and how it is simulated.
pub(crate) struct Simulated {
    pub(crate) robot: Robot,
    /// Longest step (s).
    pub(crate) step_s: f64,
    /// What acts depends on where the robot is, or which way it faces.
    pub(crate) bound_to_place: bool,
}

impl Simulated {
    /// A window to simulate.
    pub(crate) fn over<'a>(&'a self, track: &'a Track, window: &'a Window) -> Simulation<'a> {
        Simulation {
            track,
            window,
            own: self,
        }
    }
}

/// One window, its track and the robot to simulate.
#[derive(Clone, Copy)]
pub(crate) struct Simulation<'a> {
    track: &'a Track,
    window: &'a Window,
    own: &'a Simulated,
}

/// An instant of a simulation, without derivatives.
#[derive(Clone, Copy)]
struct Knot {
    pose: [f64; 3],
    velocity: [f64; 3],
    angle: [f64; 2],
    speed: [f64; 2],
}

impl Knot {
    fn new(robot: &Robot, state: &State) -> Self {
        Self {
            pose: state.pose(),
            velocity: state.velocity(),
            angle: robot.measured_angle(state),
            speed: robot.measured_speed(state),
        }
    }

    /// Pose and angles, and their rates.
    fn motion(&self) -> ([f64; 5], [f64; 5]) {
        let [x, y, yaw] = self.pose;
        let [u, w, turn] = self.velocity;
        let (sin, cos) = yaw.sin_cos();
        let [right, left] = self.angle;
        let rate = [
            u * cos - w * sin,
            u * sin + w * cos,
            turn,
            self.speed[0],
            self.speed[1],
        ];
        ([x, y, yaw, right, left], rate)
    }
}

impl Simulation<'_> {
    /// Simulated minus measured from `start`, in standard deviations. NaN where nothing was measured or
    /// the window does not reach.
    pub(crate) fn residuals(&self, start: &[f64; LOCALS]) -> Vec<f64> {
        let mut seen = PendingMeasurements::new(self, [start[5], start[6]]);
        let mut state = self.begin(start);
        let told = &self.track.commands;
        let robot = &self.own.robot;
        let mut before = Knot::new(robot, &state);
        let mut now_s = self.window.from_s;
        let mut at = self.window.command;
        let end_s = self.window.to_s + BEYOND_S;
        while now_s < end_s && !seen.is_done() {
            while told
                .get(at + 1)
                .is_some_and(|(t_s, _)| *t_s <= now_s + 1e-9)
            {
                at += 1;
            }
            let command = told[at].1;
            let until_s = told.get(at + 1).map_or(end_s, |(t_s, _)| t_s.min(end_s));
            let steps = ((until_s - now_s) / self.own.step_s - 1e-6).ceil().max(1.0);
            let step_s = (until_s - now_s) / steps;
            let from_s = now_s;
            for k in 0..steps as u32 {
                let t_s = from_s + f64::from(k) * step_s;
                robot.step(&mut state, t_s, step_s, &command);
                let after = Knot::new(robot, &state);
                if seen.due_s <= t_s + step_s {
                    seen.between([t_s, step_s], &before, &after, &state);
                }
                before = after;
            }
            now_s = until_s;
        }
        let mut residuals = seen.residuals;
        self.window.share(&mut residuals);
        residuals
    }

    fn begin(&self, start: &[f64; LOCALS]) -> State {
        let robot = &self.own.robot;
        let mut state = robot.start([start[0], start[1], start[2]]);
        let first = self.window.command;
        let from_s = self.window.from_s;
        if self.window.free[3] {
            robot.set_rolling(&mut state, start[3], start[4]);
        }
        if self.window.free[3] || first > 0 {
            let told = &self.track.commands[..=first];
            let memory = told.iter().rev();
            let felt = memory.take_while(|(t_s, _)| *t_s > from_s - MEMORY_S);
            let past = &told[first.saturating_sub(felt.count())..];
            robot.replay_commands(&mut state, past, from_s);
        }
        state
    }
}

/// The measurements that are still to come.
struct PendingMeasurements<'a> {
    simulation: &'a Simulation<'a>,
    offset: [f64; 2],
    jumps: bool,
    next: Vec<usize>,
    /// When the next one of any series was taken (s).
    due_s: f64,
    residuals: Vec<f64>,
}

impl<'a> PendingMeasurements<'a> {
    fn new(simulation: &'a Simulation<'a>, offset: [f64; 2]) -> Self {
        let window = simulation.window;
        let mut seen = Self {
            simulation,
            offset,
            jumps: simulation.track.kind() == CommandKind::Speed,
            next: window.rows.iter().map(|rows| rows[0]).collect(),
            due_s: 0.0,
            residuals: vec![f64::NAN; window.channels.len()],
        };
        for series in 0..seen.next.len() {
            while seen
                .true_s(series)
                .is_some_and(|t_s| t_s < window.from_s - BEFORE_S)
            {
                seen.next[series] += 1;
            }
        }
        seen.look_ahead();
        seen
    }

    fn is_done(&self) -> bool {
        self.due_s.is_infinite()
    }

    /// When the next row of a series was taken.
    fn true_s(&self, series: usize) -> Option<f64> {
        let Simulation { track, window, own } = self.simulation;
        let row = self.next[series];
        (row < window.rows[series][1]).then(|| {
            let series = &track.series[series];
            own.robot.true_s(series.sensor.clock(), series.rows[row].0)
        })
    }

    fn look_ahead(&mut self) {
        let due = (0..self.next.len()).filter_map(|series| self.true_s(series));
        self.due_s = due.fold(f64::INFINITY, f64::min);
    }

    /// Compares what was measured in one step.
    fn between(&mut self, [t_s, step_s]: [f64; 2], before: &Knot, after: &Knot, state: &State) {
        let (start, mut start_rate) = before.motion();
        let (end, end_rate) = after.motion();
        if self.jumps {
            start_rate = end_rate;
        }
        let at = |share: f64| {
            let (s2, s3) = (share * share, share * share * share);
            let up = s2 * 3.0 - s3 * 2.0;
            let (early, late) = ((s3 - s2 * 2.0 + share) * step_s, (s3 - s2) * step_s);
            let mut value = [0.0; 5];
            for (i, value) in value.iter_mut().enumerate() {
                *value = start[i]
                    + (end[i] - start[i]) * up
                    + start_rate[i] * early
                    + end_rate[i] * late;
            }
            value
        };
        let speed = |share: f64| {
            [0, 1].map(|i| start_rate[3 + i] + (end_rate[3 + i] - start_rate[3 + i]) * share)
        };
        // yaw rate, as the gyro sees it
        let (early, late) = (start_rate[2], end_rate[2]);
        for series in 0..self.next.len() {
            while let Some(true_s) = self.true_s(series).filter(|true_s| *true_s <= t_s + step_s) {
                let share = (true_s - t_s) / step_s;
                let turn = early + (late - early) * share;
                self.compare(series, at(share), speed(share), (state, turn));
                self.next[series] += 1;
            }
        }
        self.look_ahead();
    }

    fn compare(
        &mut self,
        which: usize,
        at: [f64; 5],
        speed: [f64; 2],
        (state, turn): (&State, f64),
    ) {
        let Simulation { track, window, own } = self.simulation;
        let series = &track.series[which];
        let row = self.next[which];
        let values = series.rows[row].1;
        let simulated = match series.sensor {
            Sensor::WheelAngle => [at[3] + self.offset[0], at[4] + self.offset[1], f64::NAN],
            Sensor::WheelSpeed => [speed[0], speed[1], f64::NAN],
            Sensor::Pose => {
                let seen = tracked(track, &own.robot, [at[0], at[1], at[2]]);
                let turn = seen[2] - values[2];
                let turns = (turn / std::f64::consts::TAU).round() * std::f64::consts::TAU;
                [seen[0], seen[1], seen[2] - turns]
            }
            Sensor::Odometry => {
                let [v, w] = own.robot.odometry(speed);
                [v, w, f64::NAN]
            }
            Sensor::Imu if track.imu_without_weight => {
                let [along, across, _] = state.acceleration();
                [along, across, turn]
            }
            Sensor::Imu => {
                let [along, across, _] = own.robot.measured_inertial(state);
                [along, across, turn]
            }
        };
        let width = series.sensor.width();
        let base = window.base[which] + (row - window.rows[which][0]) * width;
        for part in 0..width {
            let residual = (simulated[part] - values[part]) / series.deviation[part];
            let residual = residual.clamp(-LARGEST_RESIDUAL, LARGEST_RESIDUAL);
            self.residuals[base + part] = if series.sensor == Sensor::Imu && part < 2 {
                asinh_compressed(residual)
            } else {
                residual
            };
        }
    }
}

/// A residual of an acceleration, in which what is far off counts less: accelerations jump where a
/// wheel begins to slide, and a sample beside a jump is on either side of it by chance.
fn asinh_compressed(residual: f64) -> f64 {
    SOFT * (residual / SOFT).asinh()
}

/// What a asinh_compressed residual was.
pub(crate) fn asinh_expanded(residual: f64) -> f64 {
    SOFT * (residual / SOFT).sinh()
}

/// Where the camera sees the tracked point of a robot at `pose`.
pub(crate) fn tracked(track: &Track, robot: &Robot, pose: [f64; 3]) -> [f64; 3] {
    let [x, y, yaw] = robot.measured_pose(pose);
    let (sin, cos) = yaw.sin_cos();
    let ahead = track.tracked_ahead_m;
    [x + cos * ahead, y + sin * ahead, yaw]
}
