//! What a controller knows at a tick.

use std::cell::Cell;

use slipstream_bus::experiment::Control;
use slipstream_bus::message::{Position, RobotIndex};

use crate::speed_loop::SpeedLoops;
use crate::wheel_torques::WheelTorques;

/// What is known at an outer tick. Poses are x (m), y (m), φ (rad) of c; velocities v (m/s) and w (rad/s).
#[derive(Debug, Clone, Copy)]
pub struct OuterInput<'a> {
    /// Time of the run (s).
    pub t_s: f64,
    /// Time since the last outer tick (s).
    pub period_s: f64,
    /// The robot's pose by odometry.
    pub pose: [f64; 3],
    /// The robot's velocity by its wheels.
    pub velocity: [f64; 2],
    /// Reference pose: `formation.spacing_m` behind the robot ahead, on its path. For the front robot, for one that does not
    /// hear the robot ahead, and before `formation.start_s` it is that of the profile.
    pub reference: [f64; 3],
    /// Reference velocity.
    pub reference_velocity: [f64; 2],
    /// e_x (m), e_y (m), e_θ (rad): reference less pose of the midpoint of the axle, in the robot's frame, e_θ in (−π, π].
    pub error: [f64; 3],
    /// Where the robot would be if it had followed the profile exactly from its start.
    pub profile: [f64; 3],
    /// Velocity of the profile.
    pub profile_velocity: [f64; 2],
    /// Whether coordination has begun (`formation.start_s`).
    pub coordinates: bool,
    /// The newest message of every robot that was heard so far, in the order of the robots.
    pub heard: &'a [Heard],
}

/// The newest message of another robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heard {
    /// The message.
    pub position: Position,
    /// The outer tick at which it came out of the link (s).
    pub taken_s: f64,
    /// Whether it came at this tick.
    pub fresh: bool,
}

impl OuterInput<'_> {
    /// The newest message of a robot, if it was heard.
    pub fn heard_from(&self, robot: RobotIndex) -> Option<&Heard> {
        self.heard.iter().find(|own| own.position.from == robot)
    }
}

/// What is known at an inner tick. Pairs are [right, left].
#[derive(Debug)]
pub struct InnerInput<'a> {
    /// Time of the run (s).
    pub t_s: f64,
    /// Time since the last inner tick (s).
    pub period_s: f64,
    /// Mean wheel speeds since the last inner tick (rad/s).
    pub wheel_speed_rad_s: [f64; 2],
    /// v (m/s) and w (rad/s) by these.
    pub velocity: [f64; 2],
    /// v (m/s) and w (rad/s) that the outer loop asks for; while the watchdog brakes, its own.
    pub desired: [f64; 2],
    /// The wheel speeds for them (rad/s).
    pub set_point_rad_s: [f64; 2],
    /// Torque limits (N m), by `control.torque_limit` and `control.torque_max_nm`.
    pub limit_nm: [f64; 2],
    /// Friction coefficient behind the limits (1), if they follow from friction.
    pub friction: Option<f64>,
    /// Whether the watchdog brakes, because no fresh position comes.
    pub brakes: bool,
    pub(crate) control: &'a Control,
    pub(crate) loops: &'a SpeedLoops,
    /// The loops after this tick, if the controller uses them.
    pub(crate) stepped: Cell<Option<SpeedLoops>>,
}

impl InnerInput<'_> {
    /// The torques of the paper's PI speed loops (section 3). Their integral terms advance once in a tick, however often this is
    /// called.
    pub fn paper(&self) -> WheelTorques {
        let mut loops = *self.loops;
        let (speed, set_point) = (self.wheel_speed_rad_s, self.set_point_rad_s);
        let torques = loops.step(speed, set_point, self.limit_nm, self.control);
        self.stepped.set(Some(loops));
        torques
    }

    /// Takes back the step of the speed loops in this tick, as if [`Self::paper`] had not been called.
    pub fn discard(&self) {
        self.stepped.set(None);
    }

    /// Torques of the controller's own (N m) within the limits.
    pub fn limited(&self, wanted_nm: [f64; 2]) -> WheelTorques {
        let limited = |i: usize| wanted_nm[i].max(-self.limit_nm[i]).min(self.limit_nm[i]);
        WheelTorques {
            wanted_nm,
            torque_nm: [limited(0), limited(1)],
        }
    }
}
