//! Outer loop: tracking controller of Kanayama et al. (1990) in the form of the paper's Eq. 12.

use slipstream_bus::experiment::Control;

use crate::controller::DesiredTwist;
use crate::pose::{Pose, wrapped};

/// Eq. 12: v_d = v_r cos e_θ + k_x e_x, w_d = w_r + v_r (k_y e_y + k_θ sin e_θ).
///
/// `error` is e_x (m), e_y (m), e_θ (rad) by [`tracking_error`]; `reference_velocity` is v_r (m/s) and w_r (rad/s).
pub fn desired_twist(
    [e_x, e_y, e_theta]: [f64; 3],
    [v_r, w_r]: [f64; 2],
    gains: &Control,
) -> DesiredTwist {
    DesiredTwist {
        v: v_r * e_theta.cos() + gains.k_x * e_x,
        w: w_r + v_r * (gains.k_y * e_y + gains.k_theta * e_theta.sin()),
    }
}

/// e_x (m), e_y (m), e_θ (rad): reference less pose, in the robot's frame, e_θ in (−π, π].
///
/// Both are poses of the midpoint of the axle, the point of a differential drive that cannot move sideways; on a straight
/// line the errors of c are the same.
pub fn tracking_error(pose: Pose, reference: Pose) -> [f64; 3] {
    let (sin, cos) = pose.yaw_rad.sin_cos();
    let (dx, dy) = (reference.x_m - pose.x_m, reference.y_m - pose.y_m);
    let e_x = cos * dx + sin * dy;
    let e_y = cos * dy - sin * dx;
    let e_theta = wrapped(reference.yaw_rad - pose.yaw_rad);
    [e_x, e_y, e_theta]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_in_the_frame_of_the_robot() {
        let gains = Control::default();
        // The robot points along y; the reference is 1 m ahead of it and 2 m to its left.
        let pose = Pose::new([0.0, 0.0, std::f64::consts::FRAC_PI_2]);
        let reference = Pose::new([-2.0, 1.0, std::f64::consts::FRAC_PI_2 + 0.1]);
        let error = tracking_error(pose, reference);
        let desired = desired_twist(error, [0.5, 0.2], &gains);
        let [e_x, e_y, e_theta] = error;
        assert!((e_x - 1.0).abs() < 1e-12 && (e_y - 2.0).abs() < 1e-12);
        assert!((e_theta - 0.1).abs() < 1e-12);
        assert!((desired.v - (0.5 * 0.1f64.cos() + gains.k_x)).abs() < 1e-12);
        let w_d = 0.2 + 0.5 * (gains.k_y * 2.0 + gains.k_theta * 0.1f64.sin());
        assert!((desired.w - w_d).abs() < 1e-12);
    }
}
