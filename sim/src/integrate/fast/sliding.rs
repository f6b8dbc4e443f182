//! Fast path for sliding: Heun's method with kinetic friction at both wheels, written out in
//! components where the general step multiplies matrices.
//!
//! The step equals that of [`crate::Robot::step`] up to rounding; it is declined where a wheel is close to
//! sticking, the direction of its slip turns fast, or it lifts off.

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::parts::parameters::Friction;
use crate::parts::pose::advance_pose;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::{EXPLICIT_MAX, TURN_MAX};
use crate::robot::Robot;
use crate::robot::body::{Body, ContactForces};

/// Constants of a robot that slides on both wheels.
#[derive(Debug, Clone)]
pub(crate) struct SlidingStep<S> {
    /// Inverse of the mass matrix over surge, sway and yaw, by rows.
    body: [[S; 3]; 3],
    /// 1 / I_wy (1/(kg m²)).
    per_spin: S,
    /// −μ_k of each wheel (1).
    friction: Pair<S>,
    /// Slip deceleration of each contact by friction, per newton of normal force (m/s² per N).
    braking: Pair<f64>,
}

/// Slip, accelerations and contact forces at one instant.
struct SlidingInstant<S> {
    /// Longitudinal slip of the right and the left contact, and lateral slip of both (m/s).
    slip: [S; 3],
    acceleration: Vector<S>,
    contact: ContactForces<S>,
    /// No wheel lifts off.
    grounded: bool,
}

impl<S: Scalar> SlidingStep<S> {
    pub(crate) fn new(
        wheel_friction: Pair<Friction<S>>,
        dynamics: &ConstrainedDynamics<S>,
    ) -> Self {
        let a = &dynamics.acceleration;
        let kinetic = wheel_friction.map(|friction| friction.friction_kinetic);
        let mobility = dynamics.mobility;
        Self {
            body: [0, 1, 2].map(|i| [a[(i, 0)], a[(i, 1)], a[(i, 2)]]),
            per_spin: a[(3, 3)],
            friction: kinetic.map(|friction| -friction),
            braking: [0, 1].map(|i| kinetic[i].value() * mobility[i]),
        }
    }

    #[inline(always)]
    fn at(
        &self,
        robot: &Robot<S>,
        outside: Option<&Vector<S>>,
        nu: &Vector<S>,
        mut torque: Pair<S>,
    ) -> SlidingInstant<S> {
        let slip = robot.wheel_slip(nu);
        let (u, w, rate) = (nu[0], nu[1], nu[2]);
        let (m, [sx, sy]) = (robot.mass, robot.first_moment);
        let lateral_square = slip[2] * slip[2];
        let per_slip = [
            self.friction[0] / (slip[0] * slip[0] + lateral_square).sqrt(),
            self.friction[1] / (slip[1] * slip[1] + lateral_square).sqrt(),
        ];
        // contact forces per newton of normal force
        let along = [per_slip[0] * slip[0], per_slip[1] * slip[1]];
        let across = [per_slip[0] * slip[2], per_slip[1] * slip[2]];
        let load = &robot.load;
        let half = load.lateral * 0.5;
        let gain = (S::constant(1.0) - half * (across[0] - across[1])).recip();
        let difference = (half * (across[0] + across[1]) * load.driven + load.offset) * gain;
        let normal_n = [
            (load.driven + difference) * 0.5,
            (load.driven - difference) * 0.5,
        ];
        let longitudinal_n = [along[0] * normal_n[0], along[1] * normal_n[1]];
        let lateral_n = across[0] * normal_n[0] + across[1] * normal_n[1];
        let mut force = [
            (m * w + sx * rate) * rate + longitudinal_n[0] + longitudinal_n[1],
            (sy * rate - m * u) * rate + lateral_n,
            robot.half_track * (longitudinal_n[0] - longitudinal_n[1])
                - robot.com_to_axle * lateral_n
                - (sx * u + sy * w) * rate,
        ];
        if let Some(outside) = outside {
            for (i, own) in force.iter_mut().chain(&mut torque).enumerate() {
                *own += outside[i];
            }
        }
        let row = |i: usize| {
            let [a, b, c] = self.body[i];
            a * force[0] + b * force[1] + c * force[2]
        };
        let spin = |i: usize| (torque[i] - robot.radius[i] * longitudinal_n[i]) * self.per_spin;
        SlidingInstant {
            slip,
            acceleration: Vector::from([row(0), row(1), row(2), spin(0), spin(1)]),
            contact: ContactForces {
                normal_n,
                longitudinal_n,
                lateral_n,
            },
            grounded: difference.value().abs() < load.driven.value(),
        }
    }

    /// Advances `body` by one step under forces from `outside`, or returns `false` where an event may be near.
    #[inline]
    pub(crate) fn step(
        &self,
        robot: &Robot<S>,
        outside: Option<&Vector<S>>,
        body: &mut Body<S>,
        over_s: f64,
        torque: Pair<S>,
    ) -> bool {
        let start = self.at(robot, outside, &body.nu, torque);
        let guess = body.nu + start.acceleration * S::constant(over_s);
        let end = self.at(robot, outside, &guess, torque);
        let change = (start.acceleration + end.acceleration) * S::constant(0.5 * over_s);
        let nu = body.nu + change;
        let end_slip = robot.wheel_slip(&nu);
        let steady = |i: usize| {
            let pair = |slip: &[S; 3]| [slip[i].value(), slip[2].value()];
            let (a, b, c) = (pair(&start.slip), pair(&end.slip), pair(&end_slip));
            let dot = |p: [f64; 2], q: [f64; 2]| p[0] * q[0] + p[1] * q[1];
            let cross = a[0] * c[1] - a[1] * c[0];
            let braked = self.braking[i] * start.contact.normal_n[i].value() * over_s;
            let square = dot(a, a);
            (braked * braked <= EXPLICIT_MAX * EXPLICIT_MAX * square)
                & (dot(a, b) > 0.0)
                & (dot(a, c) > 0.0)
                & (cross * cross <= TURN_MAX * square * dot(c, c))
        };
        if !(start.grounded & end.grounded & steady(0) & steady(1)) {
            return false;
        }
        let mean = body.nu + change * S::constant(0.5);
        body.pose = advance_pose(body.pose, &mean, &change, over_s);
        body.angle = [
            body.angle[0] + mean[3] * over_s,
            body.angle[1] + mean[4] * over_s,
        ];
        body.nu = nu;
        body.acceleration = end.acceleration;
        body.torque = torque;
        body.contact = end.contact;
        true
    }
}
