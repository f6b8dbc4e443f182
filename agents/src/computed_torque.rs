//! Computed torque (inverse dynamics) with friction-limited traction forces.
//!
//! Replaces the paper's PI speed loops; the paper names a controller with dynamics and traction
//! forces as future work (section 5). The law inverts the robot's dynamics without slip (Eq. 3):
//! from the commanded accelerations to traction forces, limits these by the friction of the wheels,
//! and computes the torques that produce them. The outer loop stays that of the paper (Eq.
//! 12).

use crate::geometry::{Dynamics, Geometry};
use crate::traction::normal_forces_n;
use crate::wheel_torques::WheelTorques;

/// Fraction of the friction that the lateral force of a desired turn may use.
const TURN_FRICTION_SHARE: f64 = 0.9;

/// Input of the law at one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AccelerationCommand {
    /// Commanded v̇ of the midpoint of the axle (m/s²) and ẇ (rad/s²).
    pub acceleration: [f64; 2],
    /// Measured v of the midpoint of the axle (m/s) and w (rad/s).
    pub twist: [f64; 2],
    /// Assumed friction coefficient (1); `None`: no limit besides that of the motors.
    pub friction: Option<f64>,
    /// Largest torque of a motor (N m).
    pub torque_max_nm: f64,
}

/// Longitudinal traction forces of both wheels (N): F_r + F_l and F_r − F_l.
#[derive(Debug, Clone, Copy)]
struct TractionForces {
    sum: f64,
    difference: f64,
}

/// Torques for an acceleration command, before and after limiting.
///
/// Where friction does not suffice, the forward acceleration is reduced before the turn: a robot
/// that falls behind is still on its path. Only braking has priority over the turn, because a
/// slower robot needs less lateral force.
pub fn computed_torque(
    command: &AccelerationCommand,
    dynamics: &Dynamics,
    geometry: &Geometry,
) -> WheelTorques {
    let inverse = InverseDynamics::new(command.twist, dynamics, geometry);
    let [forward, yaw] = command.acceleration;
    let wanted = inverse.traction(forward, yaw);
    let allowed = match command.friction {
        None => wanted,
        Some(friction) => inverse.within_friction(command, friction),
    };
    let max_nm = command.torque_max_nm;
    WheelTorques {
        wanted_nm: inverse.torques(wanted),
        torque_nm: inverse
            .torques(allowed)
            .map(|torque| torque.clamp(-max_nm, max_nm)),
    }
}

/// Scales desired velocities v (m/s) and w (rad/s) down, on the same curve, until the lateral force
/// m_t v w is within [`TURN_FRICTION_SHARE`] of the friction.
pub(crate) fn limit_turn(
    [v, w]: [f64; 2],
    friction: f64,
    dynamics: &Dynamics,
    geometry: &Geometry,
) -> [f64; 2] {
    let friction_n: f64 = normal_forces_n(dynamics, geometry, [v, w])
        .iter()
        .sum::<f64>()
        * friction;
    let scale = (TURN_FRICTION_SHARE * friction_n / (dynamics.m_t * (v * w).abs()))
        .sqrt()
        .min(1.0);
    [v * scale, w * scale]
}

/// Dynamics of the rolling robot at its measured velocities, with v at the midpoint of the axle:
///
/// F_r + F_l = m_t v̇ − m_r d w², (F_r − F_l) b = I_axle ẇ + m_r d v w, F_lat = m_t v w + m_r d ẇ.
struct InverseDynamics<'a> {
    dynamics: &'a Dynamics,
    geometry: &'a Geometry,
    twist: [f64; 2],
    /// m_r d w² (N).
    centrifugal: f64,
    /// m_r d v w (N m).
    coriolis: f64,
    /// m_t v w (N).
    centripetal: f64,
}

impl<'a> InverseDynamics<'a> {
    fn new(twist: [f64; 2], dynamics: &'a Dynamics, geometry: &'a Geometry) -> Self {
        let [v, w] = twist;
        let moment = dynamics.m_r * geometry.d;
        Self {
            dynamics,
            geometry,
            twist,
            centrifugal: moment * w * w,
            coriolis: moment * v * w,
            centripetal: dynamics.m_t * v * w,
        }
    }

    /// Traction forces for v̇ = `forward` (m/s²) and ẇ = `yaw` (rad/s²).
    fn traction(&self, forward: f64, yaw: f64) -> TractionForces {
        TractionForces {
            sum: self.dynamics.m_t * forward - self.centrifugal,
            difference: (self.dynamics.i_axle * yaw + self.coriolis) / self.geometry.b,
        }
    }

    /// Lateral force on the wheels for ẇ = `yaw` (N).
    fn lateral_n(&self, yaw: f64) -> f64 {
        self.centripetal + self.dynamics.m_r * self.geometry.d * yaw
    }

    /// Traction forces within what the lateral force leaves of the friction; their difference, in
    /// braking their sum, comes first. Braking may use half of the friction in any case, even beyond
    /// the friction circles.
    fn within_friction(&self, command: &AccelerationCommand, friction: f64) -> TractionForces {
        let [forward, yaw] = command.acceleration;
        let normal_n = normal_forces_n(self.dynamics, self.geometry, self.twist);
        let total_n: f64 = normal_n.iter().sum();
        // Longitudinal friction coefficient that the lateral force leaves.
        let longitudinal = |yaw: f64| {
            let lateral = self.lateral_n(yaw) / total_n;
            (friction * friction - lateral * lateral).max(0.0).sqrt()
        };
        if forward * self.twist[0] < 0.0 {
            // Braking may use at least half of the friction, even if the turn needs all of it.
            let available = longitudinal(0.0).max(friction / 2.0);
            let max_n = normal_n.map(|n| n * available);
            limit_keeping_sum(self.traction(forward, yaw), max_n)
        } else {
            let yaw = self.nearest_feasible_yaw(yaw, friction * total_n);
            let max_n = normal_n.map(|n| n * longitudinal(yaw));
            limit_keeping_difference(self.traction(forward, yaw), max_n)
        }
    }

    /// The yaw acceleration nearest to `yaw` that a total friction of `max_n` allows without
    /// forward acceleration: difference² + lateral² ≤ max_n². If it allows none, the one that needs
    /// least.
    fn nearest_feasible_yaw(&self, yaw: f64, max_n: f64) -> f64 {
        let b = self.geometry.b;
        // Difference and lateral force are linear in the yaw acceleration.
        let (slope_d, slope_l) = (
            self.dynamics.i_axle / b,
            self.dynamics.m_r * self.geometry.d,
        );
        let (at_zero_d, at_zero_l) = (self.coriolis / b, self.centripetal);
        let square = slope_d * slope_d + slope_l * slope_l;
        let middle = -(slope_d * at_zero_d + slope_l * at_zero_l) / square;
        let min_square =
            (at_zero_d + slope_d * middle).powi(2) + (at_zero_l + slope_l * middle).powi(2);
        let half_width = ((max_n * max_n - min_square).max(0.0) / square).sqrt();
        yaw.clamp(middle - half_width, middle + half_width)
    }

    /// Torques that produce the traction forces, including the spin of the wheels:
    /// τ = r F + I_wy α.
    fn torques(&self, TractionForces { sum, difference }: TractionForces) -> [f64; 2] {
        let Geometry { r, b, .. } = *self.geometry;
        let forward = (sum + self.centrifugal) / self.dynamics.m_t;
        let yaw = (difference * b - self.coriolis) / self.dynamics.i_axle;
        let spin = self.dynamics.i_wy / r;
        [
            r * (sum + difference) / 2.0 + spin * (forward + b * yaw),
            r * (sum - difference) / 2.0 + spin * (forward - b * yaw),
        ]
    }
}

/// The nearest forces within the limits of both wheels (N), where the difference has priority.
fn limit_keeping_difference(wanted: TractionForces, [right_n, left_n]: [f64; 2]) -> TractionForces {
    let both = right_n + left_n;
    let difference = wanted.difference.clamp(-both, both);
    let max = (2.0 * right_n - difference).min(2.0 * left_n + difference);
    let min = (-2.0 * right_n - difference).max(-2.0 * left_n + difference);
    // Not `clamp`: by rounding `min` may exceed `max` where no sum is left.
    let sum = wanted.sum.max(min).min(max);
    TractionForces { sum, difference }
}

/// The nearest forces within the limits of both wheels (N), where the sum has priority.
fn limit_keeping_sum(wanted: TractionForces, [right_n, left_n]: [f64; 2]) -> TractionForces {
    let both = right_n + left_n;
    let sum = wanted.sum.clamp(-both, both);
    let max = (2.0 * right_n - sum).min(2.0 * left_n + sum);
    let min = (-2.0 * right_n - sum).max(-2.0 * left_n + sum);
    let difference = wanted.difference.max(min).min(max);
    TractionForces { sum, difference }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;
    use crate::traction::{rolling_acceleration, torque_limit_nm};

    fn robot() -> (Geometry, Dynamics) {
        let geometry = Geometry::new(&RobotModel::default()).unwrap();
        (geometry, geometry.dynamics.unwrap())
    }

    fn command(
        acceleration: [f64; 2],
        twist: [f64; 2],
        friction: Option<f64>,
    ) -> AccelerationCommand {
        AccelerationCommand {
            acceleration,
            twist,
            friction,
            torque_max_nm: 10.0,
        }
    }

    /// From rest the torques produce the commanded accelerations.
    #[test]
    fn from_rest_the_torques_invert_the_rolling_robot() {
        let (geometry, dynamics) = robot();
        let command = command([1.0, 3.0], [0.0; 2], None);
        let torque = computed_torque(&command, &dynamics, &geometry);
        let alpha = rolling_acceleration(torque.torque_nm, &dynamics, &geometry);
        let expected = geometry.wheel_speeds(1.0, 3.0);
        for (actual, expected) in alpha.iter().zip(expected) {
            assert!((actual - expected).abs() < 1e-9, "{alpha:?} {expected:?}");
        }
    }

    /// On a straight line the friction limit is Eq. 11.
    #[test]
    fn on_a_straight_line_the_limit_is_that_of_eq11() {
        let (geometry, dynamics) = robot();
        let command = command([50.0, 0.0], [0.3, 0.0], Some(0.24));
        let torque = computed_torque(&command, &dynamics, &geometry).torque_nm;
        let n = normal_forces_n(&dynamics, &geometry, [0.3, 0.0])[0];
        let limit = torque_limit_nm(&dynamics, &geometry, 0.24, n);
        for torque in torque {
            assert!((torque - limit).abs() < 1e-12, "{torque} {limit}");
        }
    }

    /// Except for braking in a turn, the forces on the floor stay inside the friction circles.
    #[test]
    fn the_forces_stay_inside_the_friction_circles() {
        let (geometry, dynamics) = robot();
        let friction = 0.24;
        for forward in [-5.0, 0.0, 1.2, 9.0] {
            for yaw in [-200.0, -2.0, 0.0, 2.0, 20.0] {
                for twist in [[0.0, 0.0], [0.7, 1.4], [0.5, -2.0]] {
                    let command = command([forward, yaw], twist, Some(friction));
                    let torque = computed_torque(&command, &dynamics, &geometry).torque_nm;
                    let inverse = InverseDynamics::new(command.twist, &dynamics, &geometry);
                    let normal_n = normal_forces_n(&dynamics, &geometry, twist);
                    let total_n: f64 = normal_n.iter().sum();
                    let yaw = inverse.nearest_feasible_yaw(yaw, friction * total_n);
                    // Braking may use half of the friction, whatever the turn needs.
                    let lateral = if forward * twist[0] < 0.0 {
                        0.0
                    } else {
                        inverse.lateral_n(yaw) / total_n
                    };
                    // Traction from the torques: τ = r F + I_wy α.
                    let alpha = rolling(&inverse, torque);
                    for i in 0..2 {
                        let traction = (torque[i] - dynamics.i_wy * alpha[i]) / geometry.r;
                        let force = traction.hypot(lateral * normal_n[i]);
                        assert!(
                            force <= friction * normal_n[i] + 1e-9,
                            "{command:?} {force}"
                        );
                    }
                }
            }
        }
    }

    /// Wheel accelerations (rad/s²) of the rolling robot under torques, from its equations of
    /// motion.
    fn rolling(inverse: &InverseDynamics<'_>, [right, left]: [f64; 2]) -> [f64; 2] {
        let Geometry { r, b, .. } = *inverse.geometry;
        let Dynamics {
            m_t, i_wy, i_axle, ..
        } = *inverse.dynamics;
        let forward = ((right + left) / r + inverse.centrifugal) / (m_t + 2.0 * i_wy / (r * r));
        let yaw =
            ((right - left) * b / r - inverse.coriolis) / (i_axle + 2.0 * i_wy * b * b / (r * r));
        [(forward + b * yaw) / r, (forward - b * yaw) / r]
    }

    /// Where friction does not suffice for the turn, the robot slows down on the same curve.
    #[test]
    fn a_turn_on_a_slippery_floor_is_slowed_down() {
        let (geometry, dynamics) = robot();
        assert_eq!(
            limit_turn([0.3, 0.6], 0.24, &dynamics, &geometry),
            [0.3, 0.6]
        );
        assert_eq!(
            limit_turn([0.5, 0.0], 0.01, &dynamics, &geometry),
            [0.5, 0.0]
        );
        let [v, w] = limit_turn([0.7, 1.4], 0.1, &dynamics, &geometry);
        assert!((w / v - 2.0).abs() < 1e-12 && v < 0.55, "{v} {w}");
        let normal_n: f64 = normal_forces_n(&dynamics, &geometry, [v, w]).iter().sum();
        assert!((dynamics.m_t * v * w - 0.09 * normal_n).abs() < 1e-9);
        // A robot that is too fast brakes, although the turn needs all of the friction.
        let command = command([-1.0, 0.0], [0.7, 1.4], Some(0.1));
        let torque = computed_torque(&command, &dynamics, &geometry).torque_nm;
        assert!(torque[0] + torque[1] < -0.01, "{torque:?}");
    }

    /// A feasible turn is not reduced, whatever the commanded forward acceleration.
    #[test]
    fn the_turn_has_priority_over_acceleration() {
        let (geometry, dynamics) = robot();
        for forward in [0.0, 1.0, 9.0] {
            let command = command([forward, 3.0], [0.3, 0.6], Some(0.24));
            let torque = computed_torque(&command, &dynamics, &geometry).torque_nm;
            let inverse = InverseDynamics::new(command.twist, &dynamics, &geometry);
            let [right, left] = rolling(&inverse, torque);
            let yaw = geometry.r * (right - left) / (2.0 * geometry.b);
            assert!((yaw - 3.0).abs() < 1e-9, "{yaw}");
        }
    }
}
