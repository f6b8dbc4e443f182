//! The sliding step, short: both wheels slide, nothing holds or rubs, the command is a torque.
//!
//! What the wheels' friction does to the body is summed by hand where the general step multiplies
//! matrices. The step is [`crate::Robot::step`]'s; where a wheel comes near to sticking, turns its
//! slip fast or lifts, it is refused.

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::parts::parameters::Friction;
use crate::parts::pose::advance_pose;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::{EXPLICIT_MAX, TURN_MAX};
use crate::robot::Robot;
use crate::robot::body::{Body, Contact};

/// Coefficients of a robot that slides on both wheels.
#[derive(Debug, Clone)]
pub(crate) struct SlidingStep<S> {
    /// Inverse of the body's part of the mass matrix, by rows.
    body: [[S; 3]; 3],
    /// 1 / I_wy.
    per_spin: S,
    /// −μ_k of each wheel.
    friction: Pair<S>,
    /// ActiveSetChange of each contact's slip in a second for a newton of normal force (m/s²).
    braking: Pair<f64>,
}

/// Velocities, slips and accelerations at one instant.
struct Instant<S> {
    /// Slip of the right and the left contact along the wheel, and of both across it.
    slip: [S; 3],
    acceleration: Vector<S>,
    contact: Contact<S>,
    /// No wheel lifts.
    stands: bool,
}

impl<S: Scalar> SlidingStep<S> {
    pub(crate) fn new(grip: Pair<Friction<S>>, operator: &ConstrainedDynamics<S>) -> Self {
        let a = &operator.acceleration;
        let kinetic = grip.map(|grip| grip.friction_kinetic);
        let mobility = operator.mobility;
        Self {
            body: [0, 1, 2].map(|i| [a[(i, 0)], a[(i, 1)], a[(i, 2)]]),
            per_spin: a[(3, 3)],
            friction: kinetic.map(|friction| -friction),
            braking: [0, 1].map(|i| kinetic[i].value() * mobility[i]),
        }
    }

    #[inline(always)]
    fn at(&self, robot: &Robot<S>, nu: &Vector<S>, torque: Pair<S>) -> Instant<S> {
        let slip = robot.slip(nu);
        let (u, w, rate) = (nu[0], nu[1], nu[2]);
        let (m, [sx, sy]) = (robot.mass, robot.moment);
        let across_square = slip[2] * slip[2];
        let per = [
            self.friction[0] / (slip[0] * slip[0] + across_square).sqrt(),
            self.friction[1] / (slip[1] * slip[1] + across_square).sqrt(),
        ];
        // forces at each contact for each newton of normal force
        let along = [per[0] * slip[0], per[1] * slip[1]];
        let across = [per[0] * slip[2], per[1] * slip[2]];
        let load = &robot.load;
        let half = load.lateral * 0.5;
        let own = (S::constant(1.0) - half * (across[0] - across[1])).recip();
        let apart = (half * (across[0] + across[1]) * load.driven + load.offset) * own;
        let normal_n = [(load.driven + apart) * 0.5, (load.driven - apart) * 0.5];
        let along_n = [along[0] * normal_n[0], along[1] * normal_n[1]];
        let across_n = across[0] * normal_n[0] + across[1] * normal_n[1];
        let force = [
            (m * w + sx * rate) * rate + along_n[0] + along_n[1],
            (sy * rate - m * u) * rate + across_n,
            robot.half_track * (along_n[0] - along_n[1])
                - robot.com_to_axle * across_n
                - (sx * u + sy * w) * rate,
        ];
        let row = |i: usize| {
            let [a, b, c] = self.body[i];
            a * force[0] + b * force[1] + c * force[2]
        };
        let spin = |i: usize| (torque[i] - robot.radius[i] * along_n[i]) * self.per_spin;
        Instant {
            slip,
            acceleration: Vector::from([row(0), row(1), row(2), spin(0), spin(1)]),
            contact: Contact {
                normal_n,
                along_n,
                across_n,
            },
            stands: apart.value().abs() < load.driven.value(),
        }
    }

    /// One step, or `false` where the general step has to look.
    #[inline]
    pub(crate) fn step(
        &self,
        robot: &Robot<S>,
        body: &mut Body<S>,
        over_s: f64,
        torque: Pair<S>,
    ) -> bool {
        let start = self.at(robot, &body.nu, torque);
        let guess = body.nu + start.acceleration * S::constant(over_s);
        let end = self.at(robot, &guess, torque);
        let change = (start.acceleration + end.acceleration) * S::constant(0.5 * over_s);
        let nu = body.nu + change;
        let then = robot.slip(&nu);
        let steady = |i: usize| {
            let pair = |slip: &[S; 3]| [slip[i].value(), slip[2].value()];
            let (a, b, c) = (pair(&start.slip), pair(&end.slip), pair(&then));
            let dot = |p: [f64; 2], q: [f64; 2]| p[0] * q[0] + p[1] * q[1];
            let cross = a[0] * c[1] - a[1] * c[0];
            let braked = self.braking[i] * start.contact.normal_n[i].value() * over_s;
            let square = dot(a, a);
            (braked * braked <= EXPLICIT_MAX * EXPLICIT_MAX * square)
                & (dot(a, b) > 0.0)
                & (dot(a, c) > 0.0)
                & (cross * cross <= TURN_MAX * square * dot(c, c))
        };
        if !(start.stands & end.stands & steady(0) & steady(1)) {
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
