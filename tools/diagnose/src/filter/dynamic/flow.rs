//! The plant from one row of measurements to the next, under disturbances that are held.

use slipstream_sim::{Command, Correction, Robot, State};

use super::{ANGLE, DISTURBED, N, POSE, ROLLING, Row, Run, SLIP, Sensor, Vector};

/// State of the plant, its disturbances, and where in the commands it is.
#[derive(Clone)]
pub(crate) struct Point {
    pub(crate) state: State,
    pub(crate) disturbance: [f64; 5],
    pub(crate) t_s: f64,
    command: usize,
}

/// Speed (m/s, rad/s) beyond which a simulation has diverged.
const LOST: f64 = 1e4;

impl Point {
    /// Whether the simulation has diverged.
    pub(crate) fn is_lost(&self) -> bool {
        let mut speeds = self.state.velocity().into_iter();
        !speeds.all(|speed| speed.abs() < LOST)
    }

    /// The commands that lie behind it, of which it lets go.
    pub(crate) fn passed(&mut self) -> usize {
        std::mem::take(&mut self.command)
    }
}

/// The plant of one robot in one run.
pub(crate) struct Flow<'a> {
    pub(crate) robot: &'a Robot,
    pub(crate) run: &'a Run,
    /// Longest step (s) of wheels that roll, and of wheels that slide or gears that are apart.
    pub(crate) step_s: [f64; 2],
    /// Whether the third and the fourth disturbance are torques of the wheels.
    pub(crate) of_wheels: bool,
    /// A load outside of the catalogue: until when (s) each acts, along (N) and about (N m).
    pub(crate) loads: &'a [(f64, [f64; 2])],
}

impl Flow<'_> {
    /// Where the run begins.
    pub(crate) fn start(&self) -> Point {
        Point {
            state: self.state_at(&self.run.start),
            disturbance: [0.0; 5],
            t_s: self.run.begin_s,
            command: 0,
        }
    }

    /// Where a robot that rolls alike would be, were it this one.
    pub(crate) fn rolling_as(&self, point: &Point, coordinates: &Vector) -> Point {
        Point {
            state: self.state_at(coordinates),
            ..point.clone()
        }
    }

    /// A robot that rolls at these coordinates.
    fn state_at(&self, at: &Vector) -> State {
        let mut state = self.robot.start([at[POSE], at[POSE + 1], at[POSE + 2]]);
        if at[ROLLING] != 0.0 || at[ROLLING + 1] != 0.0 {
            self.robot
                .set_rolling(&mut state, at[ROLLING], at[ROLLING + 1]);
        }
        self.robot.correct(
            &mut state,
            &Correction {
                angle_rad: [at[ANGLE], at[ANGLE + 1]],
                ..Correction::default()
            },
        );
        state
    }

    /// Advances `point` to `to_s` (s).
    pub(crate) fn advance(&self, point: &mut Point, to_s: f64) {
        let told = &self.run.commands;
        let over_s = to_s - point.t_s;
        if over_s <= 0.0 {
            return;
        }
        let start = point.state.pose();
        let [mut surge, mut yaw, third, fourth, across] = point.disturbance;
        let [along, about] = self.load(to_s);
        surge += along;
        yaw += about;
        let force = if self.of_wheels {
            [surge, 0.0, yaw, third, fourth]
        } else {
            [surge, 0.0, yaw, 0.0, 0.0]
        };
        let disturbed = force.iter().any(|force| *force != 0.0);
        point.state.set_external_force(disturbed.then_some(force));
        while point.t_s < to_s {
            while told
                .get(point.command + 1)
                .is_some_and(|(t_s, _)| *t_s <= point.t_s + SIMULTANEOUS_S)
            {
                point.command += 1;
            }
            let change_s = told.get(point.command + 1).map_or(to_s, |(t_s, _)| *t_s);
            let until_s = if change_s >= to_s - SIMULTANEOUS_S {
                to_s
            } else {
                change_s
            };
            self.held(point, until_s, &told[point.command].1);
        }
        if !self.of_wheels && (third != 0.0 || fourth != 0.0) || across != 0.0 {
            let [along, about] = if self.of_wheels {
                [0.0; 2]
            } else {
                [third * over_s, fourth * over_s]
            };
            let end = point.state.pose()[2];
            let (sin, cos) = (0.5 * (start[2] + end + about)).sin_cos();
            let side = across * over_s;
            self.robot.correct(
                &mut point.state,
                &Correction {
                    pose: [along * cos - side * sin, along * sin + side * cos, about],
                    ..Correction::default()
                },
            );
        }
    }

    /// The load outside of the catalogue until `to_s` (s).
    fn load(&self, to_s: f64) -> [f64; 2] {
        let at = self
            .loads
            .partition_point(|(until_s, _)| *until_s < to_s - SIMULTANEOUS_S);
        self.loads.get(at).map_or([0.0; 2], |(_, load)| *load)
    }

    /// Advances under one command.
    fn held(&self, point: &mut Point, to_s: f64, command: &Command) {
        while point.t_s < to_s - SIMULTANEOUS_S {
            let rolls = point.state.slides() == [false; 2] && point.state.engaged() == [true; 2];
            let longest_s = self.step_s[usize::from(!rolls)];
            let left_s = to_s - point.t_s;
            let step_s = left_s / (left_s / longest_s - 1e-6).ceil().max(1.0);
            self.robot
                .step(&mut point.state, point.t_s, step_s, command);
            point.t_s += step_s;
        }
        point.t_s = to_s;
    }

    /// What the sensor of `row` would measure at `point`.
    pub(crate) fn measured(&self, point: &Point, row: &Row) -> [f64; 3] {
        let (robot, state) = (self.robot, &point.state);
        match row.sensor {
            Sensor::WheelAngle => {
                let [right, left] = robot.measured_angle(state);
                [right, left, f64::NAN]
            }
            Sensor::WheelSpeed => {
                let [right, left] = robot.measured_speed(state);
                [right, left, f64::NAN]
            }
            Sensor::Pose => {
                let [x, y, yaw] = robot.measured_pose(state.pose());
                let (sin, cos) = yaw.sin_cos();
                let ahead = self.run.tracked_ahead_m;
                [x + cos * ahead, y + sin * ahead, yaw]
            }
            Sensor::Imu => {
                let [along, across, turn] = if self.run.without_gravity {
                    let [along, across, _] = state.acceleration();
                    [along, across, state.velocity()[2]]
                } else {
                    robot.measured_inertial(state)
                };
                let creep = if self.of_wheels {
                    0.0
                } else {
                    point.disturbance[3]
                };
                [along, across, turn + creep]
            }
        }
    }

    /// How fast what a row measures changes, where its stamp is uncertain: the angles of wheels.
    pub(crate) fn rates(&self, point: &Point, row: &Row) -> [f64; 3] {
        match row.sensor {
            Sensor::WheelAngle => {
                let [right, left] = self.robot.measured_speed(&point.state);
                [right, left, 0.0]
            }
            _ => [0.0; 3],
        }
    }

    /// Measured minus predicted; 0 where nothing was measured.
    pub(crate) fn innovation(&self, point: &Point, row: &Row) -> [f64; 3] {
        let predicted = self.measured(point, row);
        let mut difference = [0, 1, 2].map(|i| row.value[i] - predicted[i]);
        if row.sensor == Sensor::Pose {
            let turns = (difference[2] / std::f64::consts::TAU).round();
            difference[2] -= turns * std::f64::consts::TAU;
        }
        difference.map(|d| if d.is_finite() { d } else { 0.0 })
    }

    /// Adds `change` to the state of `point`.
    pub(crate) fn correct(&self, point: &mut Point, change: &Vector) {
        let part = |from: usize| [change[from], change[from + 1]];
        self.robot.correct(
            &mut point.state,
            &Correction {
                pose: [change[POSE], change[POSE + 1], change[POSE + 2]],
                rolling: part(ROLLING),
                angle_rad: part(ANGLE),
                slip_m_s: [change[SLIP], change[SLIP + 1], change[SLIP + 2]],
            },
        );
        for (own, change) in point.disturbance.iter_mut().zip(&change[DISTURBED..]) {
            *own += change;
        }
    }

    /// The state of `point` as numbers.
    pub(crate) fn coordinates(&self, point: &Point) -> Vector {
        let mut out = [0.0; N];
        let [surge, _, turn] = point.state.velocity();
        out[..3].copy_from_slice(&point.state.pose());
        out[ROLLING..ROLLING + 2].copy_from_slice(&[surge, turn]);
        out[ANGLE..ANGLE + 2].copy_from_slice(&point.state.wheel_angle());
        out[DISTURBED..DISTURBED + 5].copy_from_slice(&point.disturbance);
        out[SLIP..].copy_from_slice(&self.robot.slip_m_s(&point.state));
        out
    }
}

/// Times closer than this are the same (s).
const SIMULTANEOUS_S: f64 = 1e-9;
