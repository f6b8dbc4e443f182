//! Continuous state of one robot, and the contact forces that belong to it.

use crate::parts::scalar::{Pair, Scalar, Vector};

/// The continuous part of the state, between two events.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<S> {
    /// x and y of c (m) and heading φ (rad), world frame.
    pub(crate) pose: [S; 3],
    /// ν: surge and sway of c in the body frame (m/s), yaw rate and wheel speeds (rad/s).
    pub(crate) nu: Vector<S>,
    /// Wheel angles θ (rad).
    pub(crate) angle: Pair<S>,
    /// Motor angles at the wheel side of the gear ratio (rad); used only with backlash.
    pub(crate) motor_angle: Pair<S>,
    /// Motor speeds at the wheel side of the gear ratio (rad/s); used only with backlash.
    pub(crate) motor_speed: Pair<S>,
    /// State of the actuators' lag, in the unit of the command.
    pub(crate) lagged: Pair<S>,
    /// What effects add to the motion that the wheels give; `None` without such effects.
    pub(crate) carried: Option<Carried<S>>,
    /// dν/dt at the end of the last step.
    pub(crate) acceleration: Vector<S>,
    /// Mean torque at each wheel over the last step, motor curve and droop included (N m).
    pub(crate) torque: Pair<S>,
    /// Contact forces at the end of the last step.
    pub(crate) contact: ContactForces<S>,
}

impl<S: Scalar> Body<S> {
    /// At rest at `pose` without any force.
    pub(crate) fn at_rest(pose: [S; 3]) -> Self {
        let zero = S::constant(0.0);
        Self {
            pose,
            nu: Vector::zeros(),
            angle: [zero; 2],
            motor_angle: [zero; 2],
            motor_speed: [zero; 2],
            lagged: [zero; 2],
            carried: None,
            acceleration: Vector::zeros(),
            torque: [zero; 2],
            contact: ContactForces::zero(),
        }
    }
}

/// Motion that effects add to the one that the wheels give.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Carried<S> {
    /// Velocity along and across the body (m/s) and yaw rate (rad/s), at the end of the last step.
    pub(crate) velocity: [S; 3],
    /// Its mean rate of change over the last step (m/s² and rad/s²).
    pub(crate) rate: [S; 3],
}

impl<S: Scalar> Body<S> {
    /// Velocity of c along and across the body (m/s) and yaw rate (rad/s).
    pub(crate) fn velocity(&self) -> [S; 3] {
        let nu = [self.nu[0], self.nu[1], self.nu[2]];
        match self.carried {
            None => nu,
            Some(carried) => [0, 1, 2].map(|i| nu[i] + carried.velocity[i]),
        }
    }

    /// Rate of change of [`Body::velocity`] (m/s² and rad/s²).
    pub(crate) fn velocity_rate(&self) -> [S; 3] {
        let rate = [0, 1, 2].map(|i| self.acceleration[i]);
        match self.carried {
            None => rate,
            Some(carried) => [0, 1, 2].map(|i| rate[i] + carried.rate[i]),
        }
    }
}

/// Forces between the floor and the driven wheels (Fig. 2 of the paper). Pairs are [right, left].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForces<S = f64> {
    /// Normal forces N_r and N_l (N). Zero for a robot that rolls without slipping by assumption.
    pub normal_n: Pair<S>,
    /// Longitudinal traction F_long at each wheel, positive forward (N).
    pub longitudinal_n: Pair<S>,
    /// Lateral traction F_lat of both wheels together, positive to the left (N). While both wheels
    /// stick, how they share it is not determined.
    pub lateral_n: S,
}

impl<S: Scalar> ContactForces<S> {
    fn zero() -> Self {
        let zero = S::constant(0.0);
        Self {
            normal_n: [zero; 2],
            longitudinal_n: [zero; 2],
            lateral_n: zero,
        }
    }
}
