//! The common step, short: both wheels roll, nothing else holds or rubs, the command is a torque.
//!
//! Rolling leaves two velocities, u and φ̇ (Eq. 1: η̇ = 0, ρ̇ = r θ̇). All accelerations and contact
//! forces are then sums of τ_r, τ_l, u φ̇ and φ̇², whose coefficients are read off the operator once.
//! The step is [`crate::Robot::step`]'s, in fewer terms; where friction might not hold it is refused.

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::parts::friction_elements::{ACROSS, ALONG_LEFT, ALONG_RIGHT};
use crate::parts::parameters::Friction;
use crate::parts::pose::advance_pose;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::SURELY_STICKS;
use crate::robot::Robot;
use crate::robot::body::{Body, Contact};

/// One quantity per newton metre at the right and the left wheel, per u φ̇ and per φ̇².
type Row<S> = [S; 4];

/// Coefficients of a robot that rolls on both wheels.
#[derive(Debug, Clone)]
pub(crate) struct RollingStep<S> {
    surge: Row<S>,
    turn: Row<S>,
    along: [Row<S>; 2],
    across: Row<S>,
    /// 1 / r.
    per_radius: Pair<S>,
    /// Squares of the static friction, both wheels, with a margin; `None` where nothing slips.
    friction: Option<Pair<S>>,
}

/// Accelerations and contact forces at one instant.
struct Instant<S> {
    surge: S,
    turn: S,
    contact: Contact<S>,
    holds: bool,
}

impl<S: Scalar> RollingStep<S> {
    pub(crate) fn new(
        robot: &Robot<S>,
        grip: Pair<Option<Friction<S>>>,
        operator: &ConstrainedDynamics<S>,
    ) -> Self {
        let zero = S::constant(0.0);
        let (m, [sx, sy], d) = (robot.mass, robot.moment, robot.com_to_axle);
        // forces along, across and about for u φ̇ and for φ̇²: see Robot::applied with w = d φ̇
        let product = Vector::from([zero, -m, -sx, zero, zero]);
        let square = Vector::from([m * d + sx, sy, -sy * d, zero, zero]);
        let row = |coefficients: &Vector<S>| -> Row<S> {
            [
                coefficients[3],
                coefficients[4],
                coefficients.dot(&product),
                coefficients.dot(&square),
            ]
        };
        let acceleration = |i: usize| operator.acceleration.row(i).transpose();
        // a plain robot has the same floor under both wheels
        let friction = match grip {
            [Some(right), Some(left)] => {
                Some([right, left].map(|g| g.friction_static * g.friction_static * SURELY_STICKS))
            }
            _ => None,
        };
        Self {
            surge: row(&acceleration(0)),
            turn: row(&acceleration(2)),
            along: [ALONG_RIGHT, ALONG_LEFT].map(|r| row(&operator.multiplier_vector(r))),
            across: row(&operator.multiplier_vector(ACROSS)),
            per_radius: [robot.radius[0].recip(), robot.radius[1].recip()],
            friction,
        }
    }

    #[inline(always)]
    fn at(&self, robot: &Robot<S>, u: S, rate: S, torque: Pair<S>) -> Instant<S> {
        let (product, square) = (u * rate, rate * rate);
        let sum = |row: &Row<S>| {
            (row[0] * torque[0] + row[1] * torque[1]) + (row[2] * product + row[3] * square)
        };
        let along_n = [sum(&self.along[0]), sum(&self.along[1])];
        let across_n = sum(&self.across);
        let mut contact = Contact {
            normal_n: [S::constant(0.0); 2],
            along_n,
            across_n,
        };
        let mut holds = true;
        if let Some(friction) = self.friction {
            let driven = robot.load.driven;
            let apart = robot.load.lateral * across_n + robot.load.offset;
            contact.normal_n = [(driven + apart) * 0.5, (driven - apart) * 0.5];
            let across = across_n * across_n;
            let safe = |i: usize| {
                let normal = contact.normal_n[i];
                let force = along_n[i] * along_n[i] + across;
                force.value() <= (friction[i] * normal * normal).value() && normal.value() > 0.0
            };
            holds = safe(0) & safe(1);
        }
        Instant {
            surge: sum(&self.surge),
            turn: sum(&self.turn),
            contact,
            holds,
        }
    }

    /// One step, or `false` where friction might not hold and the general step has to look.
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
        let (guess_u, guess_rate) = (u + start.surge * over_s, rate + start.turn * over_s);
        let end = self.at(robot, guess_u, guess_rate, torque);
        if !(start.holds & end.holds) {
            return false;
        }
        let next_u = u + (start.surge + end.surge) * (0.5 * over_s);
        let next_rate = rate + (start.turn + end.turn) * (0.5 * over_s);
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
        let spin = robot.half_track * end.turn;
        body.acceleration = Vector::from([
            end.surge,
            d * end.turn,
            end.turn,
            (end.surge + spin) * self.per_radius[0],
            (end.surge - spin) * self.per_radius[1],
        ]);
        body.torque = torque;
        body.contact = end.contact;
        true
    }
}
