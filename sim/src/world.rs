//! N robots on one floor, with their sensors and noise.

use slipstream_bus::{Camera, Imu, InputError, RobotModel, Sensors};

use crate::integrate::State;
use crate::parts::command::Command;
use crate::robot::Robot;
use crate::robot::body::Contact;
use crate::sensors::measurement::{Stream, counts};
use crate::sensors::noise::{Noise, Purpose};

const NS_PER_S: f64 = 1e9;

/// One robot as a run begins.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Its name. Its noise depends on it and on the seed alone.
    pub name: String,
    /// Its model, with the effects that are really there.
    pub model: RobotModel,
    /// x and y of c (m) and heading φ (rad).
    pub pose: [f64; 3],
    /// What sees it.
    pub sensors: Sensors,
}

/// A robot as it is, all sensors aside. Pairs are [right, left].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// x and y of c (m) and heading φ (rad, not wrapped).
    pub pose: [f64; 3],
    /// Velocity of c along and across the body (m/s) and yaw rate (rad/s).
    pub velocity: [f64; 3],
    /// Wheel angles (rad).
    pub wheel_angle_rad: [f64; 2],
    /// Wheel speeds (rad/s).
    pub wheel_speed_rad_s: [f64; 2],
    /// Mean torques at the wheels in the last step (N m).
    pub torque_nm: [f64; 2],
    /// Forces between floor and driven wheels.
    pub contact: Contact,
    /// Speed at which each contact slides (m/s).
    pub slip_m_s: [f64; 2],
    /// The same along the right and the left wheel, and across both (m/s).
    pub slip_parts_m_s: [f64; 3],
    /// Whether each contact slides.
    pub slides: [bool; 2],
}

/// A measurement of one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T> {
    /// Stamp by the stream's own clock (ns).
    pub stamp_ns: i64,
    /// When it is known to whoever asked for it (ns).
    pub known_ns: i64,
    /// The measurement.
    pub value: T,
}

#[derive(Debug)]
struct SimulatedRobot {
    robot: Robot,
    state: State,
    phase: [f64; 2],
    camera: Option<RateSensor<Camera>>,
    imu: Option<RateSensor<Imu>>,
}

/// A sensor that samples at a rate of its own.
#[derive(Debug)]
struct RateSensor<T> {
    sensor: T,
    noise: Noise,
    period_ns: i64,
    due_ns: i64,
}

impl<T> RateSensor<T> {
    fn new(sensor: T, rate_hz: f64, noise: Noise) -> Self {
        let period_ns = nanoseconds(1.0 / rate_hz).max(1);
        Self {
            sensor,
            noise,
            period_ns,
            due_ns: 0,
        }
    }

    /// Whether it samples now: at the first instant at or after each multiple of its period.
    fn is_due(&mut self, now_ns: i64) -> bool {
        if now_ns < self.due_ns {
            return false;
        }
        self.due_ns = (now_ns / self.period_ns + 1) * self.period_ns;
        true
    }
}

/// N robots, f64 throughout. They do not touch each other.
#[derive(Debug)]
pub struct World {
    machines: Vec<SimulatedRobot>,
    time_ns: i64,
}

impl World {
    /// The robots of `setups`, in this order, at rest at time zero.
    ///
    /// # Errors
    /// A model or sensor that cannot be; the key names the robot.
    pub fn new(setups: &[Setup], seed: u64) -> Result<Self, InputError> {
        let machines = setups
            .iter()
            .map(|setup| SimulatedRobot::new(setup, seed))
            .collect::<Result<_, _>>();
        Ok(Self {
            machines: machines?,
            time_ns: 0,
        })
    }

    /// Moves all robots on by `dt_ns`. `commands` holds one command for each robot and acts all the
    /// time; robots without one get no torque.
    pub fn step(&mut self, dt_ns: i64, commands: &[Command]) {
        let rest = Command::rest();
        let (t_s, dt_s) = (seconds(self.time_ns), seconds(dt_ns));
        for (i, machine) in self.machines.iter_mut().enumerate() {
            let command = commands.get(i).unwrap_or(&rest);
            machine.robot.step(&mut machine.state, t_s, dt_s, command);
        }
        self.time_ns += dt_ns;
    }

    /// Time since the run began (ns).
    pub fn time_ns(&self) -> i64 {
        self.time_ns
    }

    /// Number of robots.
    pub fn len(&self) -> usize {
        self.machines.len()
    }

    /// Whether there is no robot.
    pub fn is_empty(&self) -> bool {
        self.machines.is_empty()
    }

    /// Robot `i` as it is.
    ///
    /// # Panics
    /// If there is no robot `i`, as indexing does.
    pub fn truth(&self, i: usize) -> Truth {
        let SimulatedRobot { robot, state, .. } = &self.machines[i];
        let [right, left, across] = robot.slip_m_s(state);
        Truth {
            pose: state.pose(),
            velocity: state.velocity(),
            wheel_angle_rad: state.wheel_angle(),
            wheel_speed_rad_s: state.wheel_speed(),
            torque_nm: state.applied_torque(),
            contact: state.contact(),
            slip_m_s: [right.hypot(across), left.hypot(across)],
            slip_parts_m_s: [right, left, across],
            slides: state.slides(),
        }
    }

    /// Counters of robot `i`'s encoders now. Without an encoder in the model: in microradians.
    ///
    /// # Panics
    /// If there is no robot `i`, as indexing does.
    pub fn encoder_counts(&self, i: usize) -> [i64; 2] {
        let SimulatedRobot {
            robot,
            state,
            phase,
            ..
        } = &self.machines[i];
        let per_rev = robot
            .counts_per_rev()
            .unwrap_or(std::f64::consts::TAU * 1e6);
        let angle = robot.measured_angle(state);
        [0, 1].map(|side| counts(angle[side], per_rev, phase[side]))
    }

    /// Stamp that robot `i`'s `stream` gives to what it sees now (ns).
    ///
    /// # Panics
    /// If there is no robot `i`, as indexing does.
    pub fn stamp_ns(&self, i: usize, stream: Stream) -> i64 {
        nanoseconds(
            self.machines[i]
                .robot
                .stamp_s(stream, seconds(self.time_ns)),
        )
    }

    /// The pose of robot `i` that its camera sees now: `None` between frames, where the frame is
    /// lost, and without a camera. To be asked after every step.
    ///
    /// # Panics
    /// If there is no robot `i`, as indexing does.
    pub fn camera(&mut self, i: usize) -> Option<Sample<[f64; 3]>> {
        let stamp_ns = self.stamp_ns(i, Stream::Pose);
        let time_ns = self.time_ns;
        let SimulatedRobot {
            robot,
            state,
            camera,
            ..
        } = &mut self.machines[i];
        let eye = camera.as_mut()?;
        if !eye.is_due(time_ns) {
            return None;
        }
        let seen = eye.noise.uniform() >= eye.sensor.dropout;
        let Camera {
            noise_m,
            noise_rad,
            latency_s,
            ..
        } = eye.sensor;
        let exact = robot.measured_pose(state.pose());
        let deviation = [noise_m, noise_m, noise_rad];
        let value = [0, 1, 2].map(|axis| exact[axis] + eye.noise.normal(deviation[axis]));
        let known_ns = time_ns + nanoseconds(latency_s);
        seen.then_some(Sample {
            stamp_ns,
            known_ns,
            value,
        })
    }

    /// Specific force (m/s²) and yaw rate (rad/s) of robot `i` that its inertial sensor sees now;
    /// `None` between samples and without one. To be asked after every step.
    ///
    /// # Panics
    /// If there is no robot `i`, as indexing does.
    pub fn imu(&mut self, i: usize) -> Option<Sample<[f64; 3]>> {
        let stamp_ns = self.stamp_ns(i, Stream::Imu);
        let time_ns = self.time_ns;
        let SimulatedRobot {
            robot, state, imu, ..
        } = &mut self.machines[i];
        let eye = imu.as_mut()?;
        if !eye.is_due(time_ns) {
            return None;
        }
        let exact = robot.measured_inertial(state);
        let Imu {
            noise_m_s2,
            noise_rad_s,
            ..
        } = eye.sensor;
        let deviation = [noise_m_s2, noise_m_s2, noise_rad_s];
        let value = [0, 1, 2].map(|axis| exact[axis] + eye.noise.normal(deviation[axis]));
        Some(Sample {
            stamp_ns,
            known_ns: time_ns,
            value,
        })
    }
}

impl SimulatedRobot {
    fn new(setup: &Setup, seed: u64) -> Result<Self, InputError> {
        let named = |error: InputError| InputError {
            place: format!("{}: {}", setup.name, error.place),
            ..error
        };
        setup.sensors.validate().map_err(named)?;
        let robot = Robot::new(&setup.model).map_err(named)?;
        let state = robot.start(setup.pose);
        let noise = |purpose| Noise::new(seed, &setup.name, purpose);
        let mut phase = noise(Purpose::EncoderPhase);
        let camera = setup.sensors.camera.clone();
        let imu = setup.sensors.imu.clone();
        Ok(Self {
            robot,
            state,
            phase: [phase.uniform(), phase.uniform()],
            camera: camera.map(|c| RateSensor::new(c.clone(), c.rate_hz, noise(Purpose::Camera))),
            imu: imu.map(|s| RateSensor::new(s.clone(), s.rate_hz, noise(Purpose::Imu))),
        })
    }
}

fn seconds(ns: i64) -> f64 {
    ns as f64 / NS_PER_S
}

fn nanoseconds(s: f64) -> i64 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "saturates, after 292 years"
    )]
    let ns = (s * NS_PER_S).round() as i64;
    ns
}
