//! N robots on one floor, with their sensors and noise. They do not interact.

use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_bus::{Camera, Encoder, Imu, InputError, RobotModel, Sensors};

use crate::integrate::State;
use crate::parts::command::Command;
use crate::robot::Robot;
use crate::robot::body::ContactForces;
use crate::sensors::measurement::{Stream, counts};
use crate::sensors::noise::{Noise, Purpose};
use crate::sensors::sampler::{Sample, Sampler};

/// Counts per revolution of an encoder that the model does not describe.
const DEFAULT_COUNTS_PER_REV: f64 = Encoder::MICRORADIANS.counts_per_rev;

/// One robot at the start of a run.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Its name. Its noise depends on the name and the seed alone.
    pub name: String,
    /// Its model, with the effects that are really present.
    pub model: RobotModel,
    /// x and y of c (m) and heading φ (rad), world frame.
    pub pose: [f64; 3],
    /// Its sensors besides the encoders.
    pub sensors: Sensors,
}

/// Ground truth of one robot. Pairs are [right, left].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// x and y of c (m) and heading φ (rad, not wrapped), world frame.
    pub pose: [f64; 3],
    /// Velocity of c along and across the body (m/s) and yaw rate (rad/s).
    pub velocity: [f64; 3],
    /// Wheel angles (rad).
    pub wheel_angle_rad: [f64; 2],
    /// Wheel speeds (rad/s).
    pub wheel_speed_rad_s: [f64; 2],
    /// Mean torques at the wheels over the last step (N m).
    pub torque_nm: [f64; 2],
    /// Forces between the floor and the driven wheels at the end of the last step.
    pub contact: ContactForces,
    /// Slip velocities of the contacts: longitudinal right and left, lateral of both (m/s).
    pub slip_m_s: [f64; 3],
    /// Slip speed of each contact, the length of its slip velocity (m/s).
    pub slip_speed_m_s: [f64; 2],
    /// Whether each contact slides.
    pub slides: [bool; 2],
}

/// N robots, simulated with `f64` throughout.
///
/// ```
/// use slipstream_bus::{Camera, RobotModel, Sensors};
/// use slipstream_sim::{Command, Setup, World};
///
/// let setup = |name: &str, x_m: f64| Setup {
///     name: name.to_owned(),
///     model: RobotModel::paper_with_slip(),
///     pose: [x_m, 0.0, 0.0],
///     sensors: Sensors { camera: Some(Camera::default()), imu: None },
/// };
/// let mut world = World::new(&[setup("r1", 0.0), setup("r2", -0.6096)], 1)?;
///
/// let forward = Command::Torque { right_nm: 0.05, left_nm: 0.05 };
/// let mut frames = 0;
/// for _ in 0..1000 {
///     world.step(1_000_000, &[forward, Command::zero_torque()]);
///     frames += usize::from(world.camera(0).is_some());
/// }
///
/// assert_eq!(world.time_ns(), 1_000_000_000);
/// assert!(world.truth(0).pose[0] > 0.3, "r1 has moved");
/// assert_eq!(world.truth(1).pose[0], -0.6096, "r2 stands");
/// assert!((29..=31).contains(&frames), "30 frames a second");
/// # Ok::<(), slipstream_bus::InputError>(())
/// ```
#[derive(Debug)]
pub struct World {
    robots: Vec<SimulatedRobot>,
    time_ns: i64,
}

#[derive(Debug)]
struct SimulatedRobot {
    robot: Robot,
    state: State,
    /// Unknown offset of each encoder's counter, in [0, 1) counts.
    encoder_phase: [f64; 2],
    camera: Option<Sampler<Camera>>,
    imu: Option<Sampler<Imu>>,
    /// The last command.
    command: Command,
}

impl World {
    /// The robots of `setups`, in this order, at rest at time zero. `seed` determines all noise.
    ///
    /// # Errors
    /// An invalid model or sensor; the error's place begins with the robot's name.
    pub fn new(setups: &[Setup], seed: u64) -> Result<Self, InputError> {
        let robots = setups.iter().map(|setup| SimulatedRobot::new(setup, seed));
        Ok(Self {
            robots: robots.collect::<Result<_, _>>()?,
            time_ns: 0,
        })
    }

    /// Advances all robots by `dt_ns` (ns). `commands` has one command for each robot, held
    /// throughout; robots without a command get zero torque.
    pub fn step(&mut self, dt_ns: i64, commands: &[Command]) {
        let none = Command::zero_torque();
        let (t_s, dt_s) = (s_from_ns(self.time_ns), s_from_ns(dt_ns));
        for (i, simulated) in self.robots.iter_mut().enumerate() {
            let command = commands.get(i).unwrap_or(&none);
            let SimulatedRobot { robot, state, .. } = simulated;
            robot.step(state, t_s, dt_s, command);
            simulated.command = *command;
        }
        self.time_ns += dt_ns;
    }

    /// From now on robot `i` is another one, which goes on where it is: its motion and the counters of its encoders are
    /// continuous.
    ///
    /// # Panics
    /// If there is no robot `i`.
    pub fn replace(&mut self, i: usize, robot: Robot) {
        let own = &mut self.robots[i];
        let state = robot.carry_on((&own.robot, &own.state), &own.command);
        let counted = own.robot.measured_angle(&own.state);
        let counts = robot.measured_angle(&state);
        let per_rev = robot.counts_per_rev().unwrap_or(DEFAULT_COUNTS_PER_REV);
        for side in 0..2 {
            let apart_rad = counted[side] - counts[side];
            own.encoder_phase[side] += apart_rad * per_rev / std::f64::consts::TAU;
        }
        (own.robot, own.state) = (robot, state);
    }

    /// True time since the start of the run (ns).
    pub fn time_ns(&self) -> i64 {
        self.time_ns
    }

    /// The first robot whose pose, velocity or wheel speeds are no finite numbers, if there is one.
    pub fn first_not_finite(&self) -> Option<usize> {
        self.robots.iter().position(|simulated| {
            let state = &simulated.state;
            let motion = state.pose().into_iter().chain(state.velocity());
            let sum: f64 = motion.chain(state.wheel_speed()).sum();
            !sum.is_finite()
        })
    }

    /// Number of robots.
    pub fn len(&self) -> usize {
        self.robots.len()
    }

    /// Whether there are no robots.
    pub fn is_empty(&self) -> bool {
        self.robots.is_empty()
    }

    /// Ground truth of robot `i`.
    ///
    /// # Panics
    /// If there is no robot `i`.
    pub fn truth(&self, i: usize) -> Truth {
        let SimulatedRobot { robot, state, .. } = &self.robots[i];
        let slip_m_s = robot.slip_m_s(state);
        let [right, left, lateral] = slip_m_s;
        Truth {
            pose: state.pose(),
            velocity: state.velocity(),
            wheel_angle_rad: state.wheel_angle(),
            wheel_speed_rad_s: state.wheel_speed(),
            torque_nm: state.applied_torque(),
            contact: state.contact_forces(),
            slip_m_s,
            slip_speed_m_s: [right.hypot(lateral), left.hypot(lateral)],
            slides: state.slides(),
        }
    }

    /// Counters of robot `i`'s encoders now, right and left. Without an encoder in the model a
    /// count is a microradian.
    ///
    /// # Panics
    /// If there is no robot `i`.
    pub fn encoder_counts(&self, i: usize) -> [i64; 2] {
        let SimulatedRobot { robot, state, .. } = &self.robots[i];
        let phase = self.robots[i].encoder_phase;
        let per_rev = robot.counts_per_rev().unwrap_or(DEFAULT_COUNTS_PER_REV);
        let angle = robot.measured_angle(state);
        [0, 1].map(|side| counts(angle[side], per_rev, phase[side]))
    }

    /// Time stamp that `stream` of robot `i` gives to a measurement made now (ns).
    ///
    /// # Panics
    /// If there is no robot `i`.
    pub fn stamp_ns(&self, i: usize, stream: Stream) -> i64 {
        let robot = &self.robots[i].robot;
        ns_from_s(robot.stamp_s(stream, s_from_ns(self.time_ns)))
    }

    /// Pose of robot `i` by its camera: x, y (m) and yaw (rad). `None` between frames, for a lost
    /// frame, and without a camera. Call it after every step.
    ///
    /// # Panics
    /// If there is no robot `i`.
    pub fn camera(&mut self, i: usize) -> Option<Sample<[f64; 3]>> {
        let stamp_ns = self.stamp_ns(i, Stream::Pose);
        let simulated = &mut self.robots[i];
        let camera = simulated.camera.as_mut()?;
        camera.sample(&simulated.robot, &simulated.state, stamp_ns, self.time_ns)
    }

    /// Specific force along and across the body (m/s²) and yaw rate (rad/s) of robot `i` by its
    /// inertial sensor. `None` between samples and without such a sensor. Call it after every step.
    ///
    /// # Panics
    /// If there is no robot `i`.
    pub fn imu(&mut self, i: usize) -> Option<Sample<[f64; 3]>> {
        let stamp_ns = self.stamp_ns(i, Stream::Imu);
        let simulated = &mut self.robots[i];
        let imu = simulated.imu.as_mut()?;
        imu.sample(&simulated.robot, &simulated.state, stamp_ns, self.time_ns)
    }
}

impl SimulatedRobot {
    fn new(setup: &Setup, seed: u64) -> Result<Self, InputError> {
        let named = |error: InputError| InputError {
            place: format!("{}: {}", setup.name, error.place),
            ..error
        };
        let sensors = &setup.sensors;
        sensors.validate().map_err(named)?;
        let robot = Robot::new(&setup.model).map_err(named)?;
        let state = robot.start(setup.pose);
        let noise = |purpose| Noise::new(seed, &setup.name, purpose);
        let mut phase = noise(Purpose::EncoderPhase);
        let camera = |camera| Sampler::camera(camera, noise(Purpose::Camera));
        let imu = |imu| Sampler::imu(imu, noise(Purpose::Imu));
        Ok(Self {
            robot,
            state,
            encoder_phase: [phase.uniform(), phase.uniform()],
            camera: sensors.camera.as_ref().map(camera),
            imu: sensors.imu.as_ref().map(imu),
            command: Command::zero_torque(),
        })
    }
}
