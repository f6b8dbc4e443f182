//! Poses in the plane (SE(2)): of the centre of mass c, or of the midpoint of the axle, d behind c.

/// A pose in the world frame. φ is counter-clockwise and not wrapped.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// x (m).
    pub x_m: f64,
    /// y (m).
    pub y_m: f64,
    /// φ (rad).
    pub yaw_rad: f64,
}

impl Pose {
    /// From x (m), y (m), φ (rad).
    pub fn new([x_m, y_m, yaw_rad]: [f64; 3]) -> Self {
        Self { x_m, y_m, yaw_rad }
    }

    /// x (m), y (m), φ (rad).
    pub fn to_array(self) -> [f64; 3] {
        [self.x_m, self.y_m, self.yaw_rad]
    }

    /// The pose of the body's point `distance_m` ahead on its longitudinal axis.
    #[must_use]
    pub fn ahead(self, distance_m: f64) -> Self {
        let (sin, cos) = self.yaw_rad.sin_cos();
        Self {
            x_m: self.x_m + distance_m * cos,
            y_m: self.y_m + distance_m * sin,
            yaw_rad: self.yaw_rad,
        }
    }

    /// The pose after an arc of length `path_m` that turns by `turn_rad`, by the midpoint rule. The
    /// direction of the chord, the mean heading, is exact; its length is taken to be that of the
    /// arc, with a relative error of `turn_rad`² / 24.
    #[must_use]
    pub fn along_arc(self, path_m: f64, turn_rad: f64) -> Self {
        let (sin, cos) = (self.yaw_rad + 0.5 * turn_rad).sin_cos();
        Self {
            x_m: self.x_m + path_m * cos,
            y_m: self.y_m + path_m * sin,
            yaw_rad: self.yaw_rad + turn_rad,
        }
    }
}

/// Wraps an angle to (−π, π].
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    let full_turn = std::f64::consts::TAU;
    let positive = angle_rad.rem_euclid(full_turn);
    if positive > std::f64::consts::PI {
        positive - full_turn
    } else {
        positive
    }
}
