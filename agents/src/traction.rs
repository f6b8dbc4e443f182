//! Traction limit: normal forces (Eq. 4 to 6) and the largest torque without slip (Eq. 11).

use crate::geometry::{Dynamics, Geometry};

/// g: acceleration due to gravity (m/s²), the paper's value.
const G: f64 = 9.81;

/// N_r, N_l: normal forces on the wheels (N) at velocity v (m/s) and yaw rate w (rad/s).
///
/// Eq. 4 and 6 give their sum, Eq. 5 their difference, with the lateral force m_t v w of the turn.
/// A wheel that would lift off carries 0.
pub fn normal_forces_n(dynamics: &Dynamics, geometry: &Geometry, [v, w]: [f64; 2]) -> [f64; 2] {
    let Dynamics { m_t, e, h, .. } = *dynamics;
    let sum = m_t * G * e / (geometry.d + e);
    let difference = m_t * v * w * h / geometry.b;
    [(sum + difference) / 2.0, (sum - difference) / 2.0].map(|n| n.clamp(0.0, sum))
}

/// Eq. 11: τ_max = μ N (2 I_wy + m_t r²) / (m_t r), the largest torque without slip (N m) at a
/// normal force `n` (N).
pub fn torque_limit_nm(dynamics: &Dynamics, geometry: &Geometry, friction: f64, n: f64) -> f64 {
    let r = geometry.r;
    friction * n * (2.0 * dynamics.i_wy + dynamics.m_t * r * r) / (dynamics.m_t * r)
}

/// Wheel accelerations (rad/s²) under these torques (N m) if both wheels roll without slip: the sum
/// of the torques accelerates the robot (Eq. 8), their difference turns it about the midpoint of
/// the axle.
pub(crate) fn rolling_acceleration(
    torque: [f64; 2],
    dynamics: &Dynamics,
    geometry: &Geometry,
) -> [f64; 2] {
    let r2 = geometry.r * geometry.r;
    let forward_inertia = dynamics.i_wy + dynamics.m_t * r2 / 2.0;
    let yaw_inertia = dynamics.i_wy + dynamics.i_axle * r2 / (2.0 * geometry.b * geometry.b);
    let sum = (torque[0] + torque[1]) / (2.0 * forward_inertia);
    let difference = (torque[0] - torque[1]) / (2.0 * yaw_inertia);
    [sum + difference, sum - difference]
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;

    /// Section 3 states 0.095 N m; its parameters give 0.0920.
    #[test]
    fn the_papers_robot_has_a_limit_of_92_mnm() {
        let geometry = Geometry::new(&RobotModel::default()).unwrap();
        let dynamics = geometry.dynamics.unwrap();
        let [right, left] = normal_forces_n(&dynamics, &geometry, [0.0, 0.0]);
        assert_eq!(right, left);
        let limit = torque_limit_nm(&dynamics, &geometry, 0.24, right);
        assert!((limit - 0.092_02).abs() < 1e-5, "{limit}");
    }

    #[test]
    fn the_outer_wheel_of_a_left_turn_carries_more() {
        let geometry = Geometry::new(&RobotModel::default()).unwrap();
        let dynamics = geometry.dynamics.unwrap();
        let [right, left] = normal_forces_n(&dynamics, &geometry, [0.5, 1.0]);
        let force = dynamics.m_t * 0.5;
        // Eq. 5: F_lat h + N_l b = N_r b
        assert!((force * dynamics.h + left * geometry.b - right * geometry.b).abs() < 1e-12);
        assert!(right > left);
    }
}
