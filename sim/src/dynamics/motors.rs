//! Motors: torque from command or voltage, and what is lost in proportion to speed (back-EMF and
//! droop).

use crate::parts::command::{Command, CommandKind};
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::robot::Robot;
use crate::robot::mode::Gear;

/// Share of I_wy on the motor's side of a gear with backlash.
pub(crate) const MOTOR_SHARE: f64 = 0.25;

impl<S: Scalar> Robot<S> {
    /// Effort of each motor on its wheel under a steady command, at the given wheel speeds (rad/s):
    /// for torque and voltage commands the torque less what is lost with speed (N m), for speed
    /// commands the commanded speed (rad/s), which has the sign of the effort if something resists.
    pub fn motor_efforts(&self, command: &Command<S>, wheel_speed: Pair<S>) -> Pair<S> {
        let (kind, actuation) = self.at_wheels(command);
        motor_effort(self, kind, actuation, wheel_speed)
    }
}

/// [`Robot::motor_efforts`] for the output of the actuators.
pub(crate) fn motor_effort<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    actuation: Pair<S>,
    wheel_speed: Pair<S>,
) -> Pair<S> {
    if kind == CommandKind::Speed {
        return actuation;
    }
    let torque = motor_torque(robot, kind, actuation);
    let damping = motor_damping(robot, kind);
    [0, 1].map(|i| torque[i] - damping * wheel_speed[i])
}

/// Torque of each motor (N m), without what it loses with speed.
pub(crate) fn motor_torque<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    actuation: Pair<S>,
) -> Pair<S> {
    match kind {
        CommandKind::Torque => actuation,
        CommandKind::Voltage => {
            let per_volt = robot.actuator.torque_per_volt.unwrap_or(S::constant(0.0));
            actuation.map(|volts| volts * per_volt)
        }
        CommandKind::Speed => [S::constant(0.0); 2],
    }
}

/// Torque lost at each motor per speed (N m s/rad).
pub(crate) fn motor_damping<S: Scalar>(robot: &Robot<S>, kind: CommandKind) -> S {
    match kind {
        CommandKind::Voltage => robot.actuator.droop + robot.actuator.back_emf,
        CommandKind::Torque => robot.actuator.droop,
        CommandKind::Speed => S::constant(0.0),
    }
}

/// Viscous damping of each velocity: drag at c, and losses of the motors that are engaged, times 1 - s of
/// the wheel.
pub(crate) fn damping_vector<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    gear: [Gear; 2],
) -> Vector<S> {
    let mut damping = robot.damping;
    for (i, gear) in gear.into_iter().enumerate() {
        damping[3 + i] = if gear.is_engaged() {
            motor_damping(robot, kind) * robot.travel[i]
        } else {
            S::constant(0.0)
        };
    }
    damping
}

/// Whether any velocity is damped, so that the effective mass matrix depends on the length of a
/// step.
pub(crate) fn is_damped<S: Scalar>(robot: &Robot<S>, kind: CommandKind) -> bool {
    robot.damped || kind == CommandKind::Voltage
}
