//! What changes while a robot moves.

/// Velocities: c along and across the body, yaw rate, right and left wheel, right and left motor.
pub(crate) const N: usize = 7;
/// One value for each velocity (m/s and rad/s).
pub type Velocity = [f64; N];
/// Largest number of dry contacts of one robot.
pub(crate) const CONTACTS: usize = 11;

/// A robot at an instant. Pairs are [right, left].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Time (s).
    pub t_s: f64,
    /// x and y of c (m), and yaw (rad, not wrapped).
    pub pose: [f64; 3],
    /// Wheel angles (rad).
    pub wheel: [f64; 2],
    /// Motor angles, where the encoders are (rad).
    pub motor: [f64; 2],
    /// Velocities.
    pub velocity: Velocity,
    /// Acceleration of c along and across the body, mean over the last step (m/s²).
    pub acceleration: [f64; 2],
    /// Speed at which each wheel's contact slides (m/s).
    pub slip_m_s: [f64; 2],
    /// The command behind its lag.
    pub(crate) lagged: [f64; 2],
    /// Force over the last step at each dry contact (N, N m).
    pub(crate) force: [[f64; 2]; CONTACTS],
    /// Whether each dry contact stuck over the last step.
    pub(crate) stuck: [bool; CONTACTS],
    /// Which patch each wheel's contact is in.
    pub(crate) patch: [Option<usize>; 2],
    /// Which side of its play each gear leans on: +1 or −1; 0 is neither.
    pub(crate) gear: [i8; 2],
    /// How far the robot has settled into the floor, between 0 and 1: grows while it stands, fades
    /// while it moves. Only for what the vocabulary does not hold.
    pub(crate) settled: f64,
    /// Disturbing forces along and across the body and moment (N, N m): held until changed.
    pub disturbance: [f64; 3],
}

impl State {
    /// Whether a wheel's contact is in a patch.
    pub fn in_patch(&self) -> bool {
        self.patch.iter().any(Option::is_some)
    }

    /// At rest.
    pub fn at(pose: [f64; 3]) -> Self {
        Self {
            t_s: 0.0,
            pose,
            wheel: [0.0; 2],
            motor: [0.0; 2],
            velocity: [0.0; N],
            acceleration: [0.0; 2],
            slip_m_s: [0.0; 2],
            lagged: [0.0; 2],
            force: [[0.0; 2]; CONTACTS],
            stuck: [true; CONTACTS],
            patch: [None; 2],
            gear: [0; 2],
            settled: 0.0,
            disturbance: [0.0; 3],
        }
    }
}
