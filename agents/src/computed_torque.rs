//! Computed torque with friction-limited allocation, beside the paper's wheel loops (its future
//! work: a controller that includes the dynamics and the traction forces).
//!
//! The outer loop's desired speeds stay. Where the paper gives each wheel a PI controller, this law
//! asks the robot's dynamics (Eq. 3 while it rolls) which traction forces give the accelerations that
//! are wanted, cuts them to what the floor carries, and which torques give those forces.

use crate::geometry::{Dynamics, Geometry};
use crate::traction::normal_forces_n;
use crate::wheels::WheelTorque;

/// What the law is told at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// Forward acceleration of the axle's middle (m/s²) and yaw acceleration (rad/s²).
    pub acceleration: [f64; 2],
    /// Forward speed of the axle's middle (m/s) and yaw rate (rad/s), measured.
    pub twist: [f64; 2],
    /// The friction that the floor is believed to have (1); none: no limit but the motors'.
    pub friction: Option<f64>,
    /// The most that a motor gives (N m).
    pub torque_max_nm: f64,
}

/// The forces that the wheels put on the floor, right and left (N): their sum and difference.
///
/// Forces on the robot that rolls, v at the axle's middle: F_r + F_l = m_t v̇ − m_r d w²,
/// (F_r − F_l) b = I_axle ẇ + m_r d v w, across the axle m_t v w + m_r d ẇ.
#[derive(Debug, Clone, Copy)]
struct Forces {
    sum: f64,
    difference: f64,
}

/// Torques for what is wanted, and those that the floor and the motors carry.
///
/// What the floor does not carry is cut from the forward acceleration first, then from the turn: a
/// robot that falls back is still on its path. Braking alone is kept before the turn: the slower a
/// robot is, the less its turn needs.
pub fn computed_torque(wish: &Wish, dynamics: &Dynamics, geometry: &Geometry) -> WheelTorque {
    let plan = Plan::new(wish, dynamics, geometry);
    let [along, turn] = wish.acceleration;
    let wanted = plan.forces(along, turn);
    let allowed = match wish.friction {
        None => wanted,
        Some(friction) => {
            let normal_n = normal_forces_n(dynamics, geometry, wish.twist);
            let all_n: f64 = normal_n.iter().sum();
            let left = |turn: f64| {
                let used = plan.across_n(turn) / all_n;
                (friction * friction - used * used).max(0.0).sqrt()
            };
            if along * wish.twist[0] < 0.0 {
                // Half of the floor at least, though the turn may need it all.
                let left = left(0.0).max(friction / 2.0);
                let most = normal_n.map(|n| n * left);
                braking(plan.forces(along, turn), most)
            } else {
                let turn = plan.nearest_turn(turn, friction * all_n);
                let most = normal_n.map(|n| n * left(turn));
                within(plan.forces(along, turn), most)
            }
        }
    };
    let most = wish.torque_max_nm;
    WheelTorque {
        wanted_nm: plan.torques(wanted),
        torque_nm: plan
            .torques(allowed)
            .map(|torque| torque.clamp(-most, most)),
    }
}

/// Desired speeds (m/s, rad/s) on the same curve, slower where the floor would not carry the turn:
/// m_t v w within nine tenths of what it carries.
pub(crate) fn on_this_floor(
    [v, w]: [f64; 2],
    friction: f64,
    dynamics: &Dynamics,
    geometry: &Geometry,
) -> [f64; 2] {
    let carried_n: f64 = normal_forces_n(dynamics, geometry, [v, w])
        .iter()
        .sum::<f64>()
        * friction;
    let share = (0.9 * carried_n / (dynamics.m_t * (v * w).abs()))
        .sqrt()
        .min(1.0);
    [v * share, w * share]
}

/// The dynamics at the measured speeds.
struct Plan<'a> {
    dynamics: &'a Dynamics,
    geometry: &'a Geometry,
    /// m_r d w² (N), m_r d v w (N m) and m_t v w (N).
    centrifugal: f64,
    coriolis: f64,
    sideways: f64,
}

impl<'a> Plan<'a> {
    fn new(wish: &Wish, dynamics: &'a Dynamics, geometry: &'a Geometry) -> Self {
        let [v, w] = wish.twist;
        let moment = dynamics.m_r * geometry.d;
        Self {
            dynamics,
            geometry,
            centrifugal: moment * w * w,
            coriolis: moment * v * w,
            sideways: dynamics.m_t * v * w,
        }
    }

    fn forces(&self, along: f64, turn: f64) -> Forces {
        Forces {
            sum: self.dynamics.m_t * along - self.centrifugal,
            difference: (self.dynamics.i_axle * turn + self.coriolis) / self.geometry.b,
        }
    }

    /// The force across the axle that a turn needs (N).
    fn across_n(&self, turn: f64) -> f64 {
        self.sideways + self.dynamics.m_r * self.geometry.d * turn
    }

    /// The yaw acceleration nearest to `turn` that the floor carries by itself, if it carries
    /// `most_n` in all: difference² + across² ≤ most_n². Where it carries none, the one that needs
    /// least.
    fn nearest_turn(&self, turn: f64, most_n: f64) -> f64 {
        let b = self.geometry.b;
        let (slope_d, slope_a) = (
            self.dynamics.i_axle / b,
            self.dynamics.m_r * self.geometry.d,
        );
        let (at_d, at_a) = (self.coriolis / b, self.sideways);
        let square = slope_d * slope_d + slope_a * slope_a;
        let middle = -(slope_d * at_d + slope_a * at_a) / square;
        let least = (at_d + slope_d * middle).powi(2) + (at_a + slope_a * middle).powi(2);
        let reach = ((most_n * most_n - least).max(0.0) / square).sqrt();
        turn.clamp(middle - reach, middle + reach)
    }

    fn torques(&self, Forces { sum, difference }: Forces) -> [f64; 2] {
        let Geometry { r, b, .. } = *self.geometry;
        let along = (sum + self.centrifugal) / self.dynamics.m_t;
        let turn = (difference * b - self.coriolis) / self.dynamics.i_axle;
        let spin = self.dynamics.i_wy / r;
        [
            r * (sum + difference) / 2.0 + spin * (along + b * turn),
            r * (sum - difference) / 2.0 + spin * (along - b * turn),
        ]
    }
}

/// The forces nearest to what is wanted that both wheels carry: the turn first.
fn within(wanted: Forces, [right_n, left_n]: [f64; 2]) -> Forces {
    let both = right_n + left_n;
    let difference = wanted.difference.clamp(-both, both);
    let most = (2.0 * right_n - difference).min(2.0 * left_n + difference);
    let least = (-2.0 * right_n - difference).max(-2.0 * left_n + difference);
    // Rounding may cross the two where nothing is left.
    let sum = wanted.sum.max(least).min(most);
    Forces { sum, difference }
}

/// The forces nearest to what is wanted that both wheels carry: the sum first.
fn braking(wanted: Forces, [right_n, left_n]: [f64; 2]) -> Forces {
    let both = right_n + left_n;
    let sum = wanted.sum.clamp(-both, both);
    let most = (2.0 * right_n - sum).min(2.0 * left_n + sum);
    let least = (-2.0 * right_n - sum).max(-2.0 * left_n + sum);
    let difference = wanted.difference.max(least).min(most);
    Forces { sum, difference }
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

    fn wish(acceleration: [f64; 2], twist: [f64; 2], friction: Option<f64>) -> Wish {
        Wish {
            acceleration,
            twist,
            friction,
            torque_max_nm: 10.0,
        }
    }

    /// From rest the torques give the wheels the accelerations that were wanted.
    #[test]
    fn from_rest_the_inverse_is_that_of_the_rolling_robot() {
        let (geometry, dynamics) = robot();
        let wish = wish([1.0, 3.0], [0.0; 2], None);
        let torque = computed_torque(&wish, &dynamics, &geometry);
        let alpha = rolling_acceleration(torque.torque_nm, &dynamics, &geometry);
        let expected = geometry.wheel_speeds(1.0, 3.0);
        for (found, expected) in alpha.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{alpha:?} {expected:?}");
        }
    }

    /// On a straight line the allocation is Eq. 11.
    #[test]
    fn straight_on_the_limit_is_that_of_eq11() {
        let (geometry, dynamics) = robot();
        let wish = wish([50.0, 0.0], [0.3, 0.0], Some(0.24));
        let torque = computed_torque(&wish, &dynamics, &geometry).torque_nm;
        let n = normal_forces_n(&dynamics, &geometry, [0.3, 0.0])[0];
        let limit = torque_limit_nm(&dynamics, &geometry, 0.24, n);
        for torque in torque {
            assert!((torque - limit).abs() < 1e-12, "{torque} {limit}");
        }
    }

    /// Whatever is wanted, the forces on the floor stay inside the friction circles.
    #[test]
    fn the_floor_carries_what_is_allowed() {
        let (geometry, dynamics) = robot();
        let friction = 0.24;
        for along in [-5.0, 0.0, 1.2, 9.0] {
            for turn in [-200.0, -2.0, 0.0, 2.0, 20.0] {
                for twist in [[0.0, 0.0], [0.7, 1.4], [0.5, -2.0]] {
                    let wish = wish([along, turn], twist, Some(friction));
                    let torque = computed_torque(&wish, &dynamics, &geometry).torque_nm;
                    let plan = Plan::new(&wish, &dynamics, &geometry);
                    let normal_n = normal_forces_n(&dynamics, &geometry, twist);
                    let all_n: f64 = normal_n.iter().sum();
                    let turn = plan.nearest_turn(turn, friction * all_n);
                    // Who brakes may use half of the floor along, whatever the turn uses across.
                    let brakes = along * twist[0] < 0.0;
                    let share = if brakes {
                        0.0
                    } else {
                        plan.across_n(turn) / all_n
                    };
                    // Back from the torques: τ = r F + I_wy (the wheel's acceleration).
                    let alpha = rolling(&plan, torque);
                    for i in 0..2 {
                        let push = (torque[i] - dynamics.i_wy * alpha[i]) / geometry.r;
                        let force = push.hypot(share * normal_n[i]);
                        assert!(force <= friction * normal_n[i] + 1e-9, "{wish:?} {force}");
                    }
                }
            }
        }
    }

    /// Wheel accelerations (rad/s²) of the rolling robot under torques, by its two equations.
    fn rolling(plan: &Plan<'_>, [right, left]: [f64; 2]) -> [f64; 2] {
        let Geometry { r, b, .. } = *plan.geometry;
        let Dynamics {
            m_t, i_wy, i_axle, ..
        } = *plan.dynamics;
        let along = ((right + left) / r + plan.centrifugal) / (m_t + 2.0 * i_wy / (r * r));
        let turn =
            ((right - left) * b / r - plan.coriolis) / (i_axle + 2.0 * i_wy * b * b / (r * r));
        [(along + b * turn) / r, (along - b * turn) / r]
    }

    /// On a floor that does not carry the turn the robot slows down on the same curve.
    #[test]
    fn a_slippery_floor_is_driven_slowly() {
        let (geometry, dynamics) = robot();
        assert_eq!(
            on_this_floor([0.3, 0.6], 0.24, &dynamics, &geometry),
            [0.3, 0.6]
        );
        assert_eq!(
            on_this_floor([0.5, 0.0], 0.01, &dynamics, &geometry),
            [0.5, 0.0]
        );
        let [v, w] = on_this_floor([0.7, 1.4], 0.1, &dynamics, &geometry);
        assert!((w / v - 2.0).abs() < 1e-12 && v < 0.55, "{v} {w}");
        let normal_n: f64 = normal_forces_n(&dynamics, &geometry, [v, w]).iter().sum();
        assert!((dynamics.m_t * v * w - 0.09 * normal_n).abs() < 1e-9);
        // Who is too fast brakes, though the turn needs it all.
        let wish = wish([-1.0, 0.0], [0.7, 1.4], Some(0.1));
        let torque = computed_torque(&wish, &dynamics, &geometry).torque_nm;
        assert!(torque[0] + torque[1] < -0.01, "{torque:?}");
    }

    /// A turn that the floor carries is not touched, whatever forward acceleration is wanted.
    #[test]
    fn the_turn_comes_first() {
        let (geometry, dynamics) = robot();
        for along in [0.0, 1.0, 9.0] {
            let wish = wish([along, 3.0], [0.3, 0.6], Some(0.24));
            let torque = computed_torque(&wish, &dynamics, &geometry).torque_nm;
            let plan = Plan::new(&wish, &dynamics, &geometry);
            let [right, left] = rolling(&plan, torque);
            let turn = geometry.r * (right - left) / (2.0 * geometry.b);
            assert!((turn - 3.0).abs() < 1e-9, "{turn}");
        }
    }
}
