//! Fast path for rolling: Heun's method in the two velocities that rolling leaves, u and φ̇ (Eq. 1:
//! η̇ = 0, ρ̇ = r θ̇).
//!
//! All accelerations and contact forces are linear in τ_r, τ_l, u φ̇ and φ̇²; the coefficients are
//! taken from the constrained dynamics once. The step equals that of [`crate::Robot::step`] up to
//! rounding; it is declined where a wheel might break away.

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::parts::friction_constraints::{LATERAL, LONGITUDINAL_LEFT, LONGITUDINAL_RIGHT};
use crate::parts::parameters::Friction;
use crate::parts::pose::advance_pose;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::SURELY_STICKS;
use crate::robot::Robot;
use crate::robot::body::{Body, ContactForces};

/// Coefficients of one quantity: per torque at the right and the left wheel, per u φ̇ and per φ̇².
type Coefficients<S> = [S; 4];

/// Constants of a robot that rolls on both wheels.
#[derive(Debug, Clone)]
pub(crate) struct RollingStep<S> {
    /// Surge acceleration.
    surge: Coefficients<S>,
    /// Yaw acceleration.
    yaw: Coefficients<S>,
    /// Longitudinal contact forces.
    longitudinal: [Coefficients<S>; 2],
    /// Lateral contact force.
    lateral: Coefficients<S>,
    /// 1 / r (1/m).
    per_radius: Pair<S>,
    /// Squared static friction of each wheel, reduced by a margin; `None` if wheels cannot slide.
    friction: Option<Pair<S>>,
}

/// Accelerations and contact forces at one instant.
struct RollingInstant<S> {
    surge: S,
    yaw: S,
    contact: ContactForces<S>,
    /// Both wheels surely stick.
    sticks: bool,
}

impl<S: Scalar> RollingStep<S> {
    pub(crate) fn new(
        robot: &Robot<S>,
        wheel_friction: Pair<Option<Friction<S>>>,
        dynamics: &ConstrainedDynamics<S>,
    ) -> Self {
        let zero = S::constant(0.0);
        let (m, [sx, sy], d) = (robot.mass, robot.first_moment, robot.com_to_axle);
        // generalised inertial forces per u φ̇ and per φ̇²: those of `applied_forces` with w = d φ̇
        let product = Vector::from([zero, -m, -sx, zero, zero]);
        let square = Vector::from([m * d + sx, sy, -sy * d, zero, zero]);
        let row = |per_force: &Vector<S>| -> Coefficients<S> {
            [
                per_force[3],
                per_force[4],
                per_force.dot(&product),
                per_force.dot(&square),
            ]
        };
        let acceleration = |i: usize| dynamics.acceleration.row(i).transpose();
        // without patches both wheels have friction, or none has
        let friction = match wheel_friction {
            [Some(right), Some(left)] => {
                Some([right, left].map(|g| g.friction_static * g.friction_static * SURELY_STICKS))
            }
            _ => None,
        };
        Self {
            surge: row(&acceleration(0)),
            yaw: row(&acceleration(2)),
            longitudinal: [LONGITUDINAL_RIGHT, LONGITUDINAL_LEFT]
                .map(|r| row(&dynamics.multiplier_vector(r))),
            lateral: row(&dynamics.multiplier_vector(LATERAL)),
            per_radius: [robot.radius[0].recip(), robot.radius[1].recip()],
            friction,
        }
    }

    #[inline(always)]
    fn at(&self, robot: &Robot<S>, u: S, rate: S, torque: Pair<S>) -> RollingInstant<S> {
        let (product, square) = (u * rate, rate * rate);
        let sum = |k: &Coefficients<S>| {
            (k[0] * torque[0] + k[1] * torque[1]) + (k[2] * product + k[3] * square)
        };
        let longitudinal_n = [sum(&self.longitudinal[0]), sum(&self.longitudinal[1])];
        let lateral_n = sum(&self.lateral);
        let mut contact = ContactForces {
            normal_n: [S::constant(0.0); 2],
            longitudinal_n,
            lateral_n,
        };
        let mut sticks = true;
        if let Some(friction) = self.friction {
            contact.normal_n = robot.load.of_wheels(lateral_n);
            let lateral_square = lateral_n * lateral_n;
            let safe = |i: usize| {
                let normal = contact.normal_n[i];
                let square = longitudinal_n[i] * longitudinal_n[i] + lateral_square;
                square.value() <= (friction[i] * normal * normal).value() && normal.value() > 0.0
            };
            sticks = safe(0) & safe(1);
        }
        RollingInstant {
            surge: sum(&self.surge),
            yaw: sum(&self.yaw),
            contact,
            sticks,
        }
    }

    /// Advances `body` by one step, or returns `false` where a wheel might break away.
    #[inline]
    pub(crate) fn step(
        &self,
        robot: &Robot<S>,
        body: &mut Body<S>,
        over_s: f64,
        torque: Pair<S>,
    ) -> bool {
        let (u, rate) = (body.nu[0], body.nu[2]);
        let start = self.at(robot, u, rate, torque);
        let (guess_u, guess_rate) = (u + start.surge * over_s, rate + start.yaw * over_s);
        let end = self.at(robot, guess_u, guess_rate, torque);
        if !(start.sticks & end.sticks) {
            return false;
        }
        let next_u = u + (start.surge + end.surge) * (0.5 * over_s);
        let next_rate = rate + (start.yaw + end.yaw) * (0.5 * over_s);
        let d = robot.com_to_axle;
        let turn = robot.half_track * next_rate;
        let wheels = [
            (next_u + turn) * self.per_radius[0],
            (next_u - turn) * self.per_radius[1],
        ];
        let nu = Vector::from([next_u, d * next_rate, next_rate, wheels[0], wheels[1]]);
        let mean = (body.nu + nu) * S::constant(0.5);
        body.pose = advance_pose(body.pose, &mean, &(nu - body.nu), over_s);
        body.angle = [
            body.angle[0] + mean[3] * over_s,
            body.angle[1] + mean[4] * over_s,
        ];
        body.nu = nu;
        let spin = robot.half_track * end.yaw;
        body.acceleration = Vector::from([
            end.surge,
            d * end.yaw,
            end.yaw,
            (end.surge + spin) * self.per_radius[0],
            (end.surge - spin) * self.per_radius[1],
        ]);
        body.torque = torque;
        body.contact = end.contact;
        true
    }
}
