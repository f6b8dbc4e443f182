//! The outer loop: the path controller of Kanayama et al. 1990 as the paper prints it (Eq. 12).

use slipstream_bus::experiment::Control;

use crate::pose::{Pose, wrapped};

/// Desired speeds, and the errors behind them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Desired {
    /// v_d (m/s).
    pub v: f64,
    /// w_d (rad/s).
    pub w: f64,
    /// e_x (m), e_y (m), e_θ (rad) in the robot's frame.
    pub error: [f64; 3],
}

/// v_d = v_r cos e_θ + k_x e_x, w_d = w_r + v_r (k_y e_y + k_θ sin e_θ).
///
/// Both poses are of the axle's middle, the point of a differential drive that cannot move
/// sideways. On a straight line this is the same as with c.
pub fn desired(pose: Pose, reference: Pose, [v_r, w_r]: [f64; 2], gains: &Control) -> Desired {
    let (sin, cos) = pose.yaw_rad.sin_cos();
    let (dx, dy) = (reference.x_m - pose.x_m, reference.y_m - pose.y_m);
    let e_x = cos * dx + sin * dy;
    let e_y = cos * dy - sin * dx;
    let e_theta = wrapped(reference.yaw_rad - pose.yaw_rad);
    Desired {
        v: v_r * e_theta.cos() + gains.k_x * e_x,
        w: w_r + v_r * (gains.k_y * e_y + gains.k_theta * e_theta.sin()),
        error: [e_x, e_y, e_theta],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_seen_from_the_robot() {
        let gains = Control::default();
        // The robot looks along y; the reference lies 1 ahead of it and 2 to its left.
        let pose = Pose::new([0.0, 0.0, std::f64::consts::FRAC_PI_2]);
        let reference = Pose::new([-2.0, 1.0, std::f64::consts::FRAC_PI_2 + 0.1]);
        let desired = desired(pose, reference, [0.5, 0.2], &gains);
        let [e_x, e_y, e_theta] = desired.error;
        assert!((e_x - 1.0).abs() < 1e-12 && (e_y - 2.0).abs() < 1e-12);
        assert!((e_theta - 0.1).abs() < 1e-12);
        assert!((desired.v - (0.5 * 0.1f64.cos() + gains.k_x)).abs() < 1e-12);
        let turn = 0.2 + 0.5 * (gains.k_y * 2.0 + gains.k_theta * 0.1f64.sin());
        assert!((desired.w - turn).abs() < 1e-12);
    }
}
