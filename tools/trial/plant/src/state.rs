//! The state of a robot.

/// Number of velocities: c along and across the body, yaw rate, right and left wheel, right and left motor.
pub(crate) const N: usize = 7;
/// One value for each velocity (m/s and rad/s).
pub type Velocity = [f64; N];
/// Largest number of dry contacts of a robot.
pub(crate) const CONTACTS: usize = 11;

/// The state of a robot. Pairs are [right, left].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Time (s).
    pub t_s: f64,
    /// x and y of c (m), and yaw (rad, not wrapped).
    pub pose: [f64; 3],
    /// Wheel angles (rad).
    pub wheel: [f64; 2],
    /// Motor angles (rad); the encoders measure these.
    pub motor: [f64; 2],
    /// Velocities.
    pub velocity: Velocity,
    /// Velocity that laws of motion add to that of the wheels: along and across the body (m/s), and yaw
    /// rate (rad/s).
    pub carried: [f64; 3],
    /// Mean acceleration of c along and across the body over the last step (m/s²).
    pub acceleration: [f64; 2],
    /// Speed at which each wheel's contact slides (m/s).
    pub slip_m_s: [f64; 2],
    /// The lagged command.
    pub(crate) lagged: [f64; 2],
    /// Mean force of each dry contact over the last step (N, N m).
    pub(crate) force: [[f64; 2]; CONTACTS],
    /// Whether each dry contact stuck over the last step.
    pub(crate) stuck: [bool; CONTACTS],
    /// The friction patch that each wheel's contact lies in.
    pub(crate) patch: [Option<usize>; 2],
    /// The side of its play that each gear rests on: +1, −1, or 0 for neither.
    pub(crate) gear: [i8; 2],
    /// How far the robot has settled into the floor, from 0 to 1: grows at rest and decays in motion. Only
    /// for [`OutsideEffect::Sticking`](crate::OutsideEffect::Sticking).
    pub(crate) settled: f64,
    /// Disturbance: forces along and across the body (N) and moment (N m), constant until changed.
    pub disturbance: [f64; 3],
    /// Disturbance: torque on each wheel (N m), constant until changed.
    pub wheel_disturbance: [f64; 2],
    /// Disturbance of a robot that rolls at prescribed wheel speeds: its speed (m/s) and turn rate (rad/s) beyond
    /// what the wheels turn, constant until changed.
    pub contact_disturbance: [f64; 2],
}

impl State {
    /// Whether a wheel's contact lies in a friction patch.
    pub fn in_patch(&self) -> bool {
        self.patch.iter().any(Option::is_some)
    }

    /// A state at rest at a pose: x, y (m) and yaw (rad).
    pub fn at(pose: [f64; 3]) -> Self {
        Self {
            t_s: 0.0,
            pose,
            wheel: [0.0; 2],
            motor: [0.0; 2],
            velocity: [0.0; N],
            carried: [0.0; 3],
            acceleration: [0.0; 2],
            slip_m_s: [0.0; 2],
            lagged: [0.0; 2],
            force: [[0.0; 2]; CONTACTS],
            stuck: [true; CONTACTS],
            patch: [None; 2],
            gear: [0; 2],
            settled: 0.0,
            disturbance: [0.0; 3],
            wheel_disturbance: [0.0; 2],
            contact_disturbance: [0.0; 2],
        }
    }
}
