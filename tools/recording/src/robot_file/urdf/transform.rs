//! Places and directions of parts.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix3, Vector3};

/// How far an angle may be from a whole number of quarter turns to be taken as that (rad): files write π/2 as
/// 1.57.
const QUARTER_TURN_RAD: f64 = 1e-3;

/// A frame within another. Where no axis is turned, offsets add up without any rounding but their own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transform {
    /// From the inner frame's axes to those of the outer.
    pub(super) rotation: Matrix3<f64>,
    /// The inner frame's origin in the outer frame (m).
    pub(super) offset: Vector3<f64>,
}

impl Transform {
    /// The frame itself.
    pub(super) fn identity() -> Self {
        Self {
            rotation: Matrix3::identity(),
            offset: Vector3::zeros(),
        }
    }

    /// `inner`, a frame within this one, in the outer frame of this one.
    pub(super) fn then(&self, inner: &Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            offset: self.place(inner.offset),
        }
    }

    /// The outer frame in the inner one.
    pub(super) fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            rotation,
            offset: -(rotation * self.offset),
        }
    }

    /// A point of the inner frame in the outer one.
    pub(super) fn place(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.offset + self.rotation * point
    }
}

/// The rotation by roll about x, then pitch about y, then yaw about z, all axes fixed (rad).
pub(super) fn of_roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(sine_cosine);
    let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
    let about_y = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    let about_z = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
    about_z * about_y * about_x
}

/// The rotation of a quaternion x, y, z, w of any length but 0.
pub(super) fn of_quaternion(xyzw: [f64; 4]) -> Option<Matrix3<f64>> {
    let norm = xyzw.iter().map(|own| own * own).sum::<f64>().sqrt();
    if !norm.is_normal() {
        return None;
    }
    let [x, y, z, w] = xyzw.map(|own| own / norm);
    Some(Matrix3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - z * w),
        2.0 * (x * z + y * w),
        2.0 * (x * y + z * w),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - x * w),
        2.0 * (x * z - y * w),
        2.0 * (y * z + x * w),
        1.0 - 2.0 * (x * x + y * y),
    ))
}

/// Sine and cosine; exact for quarter turns.
fn sine_cosine(angle: f64) -> (f64, f64) {
    let quarters = (angle / FRAC_PI_2).round();
    let near = (angle - quarters * FRAC_PI_2).abs() < QUARTER_TURN_RAD;
    if !near || quarters == 0.0 {
        return angle.sin_cos();
    }
    match quarters.rem_euclid(4.0) {
        1.0 => (1.0, 0.0),
        2.0 => (0.0, -1.0),
        3.0 => (-1.0, 0.0),
        _ => (0.0, 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        let turned = of_roll_pitch_yaw([1.571, 0.0, -1.57]);
        let expected = Matrix3::new(0.0, 0.0, -1.0, -1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        assert_eq!(turned, expected);
        assert_eq!(sine_cosine(-4.7124), (1.0, 0.0));
        assert_eq!(sine_cosine(0.0), (0.0, 1.0));
        assert_eq!(sine_cosine(5e-4), (5e-4_f64).sin_cos());
    }

    #[test]
    fn a_frame_and_its_inverse_cancel() {
        let one = Transform {
            rotation: of_roll_pitch_yaw([0.1, -0.4, 2.0]),
            offset: Vector3::new(0.3, -1.0, 0.2),
        };
        let none = one.then(&one.inverse());
        assert!((none.rotation - Matrix3::identity()).norm() < 1e-15);
        assert!(none.offset.norm() < 1e-15);
    }

    #[test]
    fn a_quaternion_is_the_same_rotation() {
        let (sine, cosine) = 0.35_f64.sin_cos();
        let turned = of_quaternion([0.0, 0.0, 2.0 * sine, 2.0 * cosine]).unwrap();
        assert!((turned - of_roll_pitch_yaw([0.0, 0.0, 0.7])).norm() < 1e-15);
        assert_eq!(of_quaternion([0.0; 4]), None);
    }
}
