//! References for the controllers: along a path, or behind the robot ahead.

use slipstream_recording::recording::LinkMessage;

use super::manoeuvre::COMMAND_PERIOD_S;

/// Distance between the robots of a platoon (m).
pub(crate) const SPACING_M: f64 = 0.6;

/// A reference pose with its velocities.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reference {
    /// x, y of c (m) and heading (rad).
    pub(crate) pose: [f64; 3],
    /// v (m/s) and w (rad/s).
    pub(crate) speed: [f64; 2],
}

/// The reference path: it follows the desired twists exactly.
pub(crate) struct Path {
    /// x, y of c (m) and heading (rad).
    pose: [f64; 3],
}

impl Path {
    /// A path from this pose on.
    pub(crate) fn new(pose: [f64; 3]) -> Self {
        Self { pose }
    }

    /// Moves on by one command period at [v (m/s), w (rad/s)].
    pub(crate) fn advance(&mut self, [v, w]: [f64; 2]) {
        let heading = self.pose[2] + w * COMMAND_PERIOD_S / 2.0;
        self.pose[0] += v * COMMAND_PERIOD_S * heading.cos();
        self.pose[1] += v * COMMAND_PERIOD_S * heading.sin();
        self.pose[2] += w * COMMAND_PERIOD_S;
    }
}

impl Reference {
    /// The reference of the front robot: the path itself.
    pub(crate) fn on_path(path: &Path, speed: [f64; 2]) -> Self {
        Self {
            pose: path.pose,
            speed,
        }
    }

    /// The reference of a follower: behind the pose in the latest message, at rest before the first one.
    pub(crate) fn behind(message: Option<&LinkMessage>, path: &Path, speed: [f64; 2]) -> Self {
        let Some(message) = message else {
            return Self::on_path(path, [0.0; 2]);
        };
        let (sin, cos) = message.yaw_rad.sin_cos();
        let pose = [
            message.x_m - SPACING_M * cos,
            message.y_m - SPACING_M * sin,
            message.yaw_rad,
        ];
        Self { pose, speed }
    }
}
