//! Poses in the plane, of the centre of mass c and of the axle's middle a distance d behind it.

/// A pose in the world: x forward, y left, φ counter-clockwise and not wrapped.
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

    /// The pose of the point `distance_m` ahead on the body's own axis.
    #[must_use]
    pub fn ahead(self, distance_m: f64) -> Self {
        let (sin, cos) = self.yaw_rad.sin_cos();
        Self {
            x_m: self.x_m + distance_m * cos,
            y_m: self.y_m + distance_m * sin,
            yaw_rad: self.yaw_rad,
        }
    }

    /// The pose after an arc of a wheeled axle: `path_m` forward while turning by `turn_rad`, with
    /// the chord in the direction of the middle heading (exact in direction, third order in length).
    #[must_use]
    pub fn driven(self, path_m: f64, turn_rad: f64) -> Self {
        let (sin, cos) = (self.yaw_rad + 0.5 * turn_rad).sin_cos();
        Self {
            x_m: self.x_m + path_m * cos,
            y_m: self.y_m + path_m * sin,
            yaw_rad: self.yaw_rad + turn_rad,
        }
    }
}

/// The same angle in (−π, π].
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let rest = angle_rad.rem_euclid(turn);
    if rest > std::f64::consts::PI {
        rest - turn
    } else {
        rest
    }
}
