//! Coulomb friction and contact forces at one instant, for a given mode: kinetic friction where a
//! constraint slides, multipliers where it sticks.

use super::constrained::ConstrainedDynamics;
use super::normal_forces::{LoadTransfer, normal_forces, split_normal};
use crate::parts::friction_constraints::{
    ConstraintSet, FrictionConstraint, LATERAL, LONGITUDINAL_LEFT, LONGITUDINAL_RIGHT,
};
use crate::parts::scalar::{Pair, Scalar, Vector, length};
use crate::parts::tolerances::{CASTER_CONVERGED, SLIP_DIRECTION_MIN};
use crate::robot::Robot;
use crate::robot::body::ContactForces;
use crate::robot::mode::Mode;

/// All forces on a robot at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Forces<S> {
    /// Generalised force, without the multipliers of the active set.
    pub(crate) force: Vector<S>,
    /// Forces at the driven wheels' contacts, multipliers included.
    pub(crate) contact: ContactForces<S>,
}

/// Adds kinetic friction to the generalised force `applied` and computes the forces at the driven
/// wheels. `prescribed_surge` is the part of the surge acceleration that prescribed wheel speeds
/// cause, not forces (m/s²).
#[inline]
pub(crate) fn forces_at<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    dynamics: &ConstrainedDynamics<S>,
    nu: &Vector<S>,
    applied: Vector<S>,
    prescribed_surge: S,
) -> Forces<S> {
    if robot.dry_friction.constraints.is_empty() {
        return wheel_forces(robot, mode, dynamics, nu, applied, prescribed_surge);
    }
    let mut caster = robot.load.caster();
    if robot.load.transfer.is_none() {
        let force = add_dry_friction(robot, mode, nu, applied, caster);
        return wheel_forces(robot, mode, dynamics, nu, force, prescribed_surge);
    }
    // Caster friction and load transfer depend on each other: a contraction by about μ h / (d + e)
    loop {
        let force = add_dry_friction(robot, mode, nu, applied, caster);
        let forces = wheel_forces(robot, mode, dynamics, nu, force, prescribed_surge);
        let [right, left] = forces.contact.normal_n;
        let next = robot.load.total - right - left;
        let change = (next - caster).value().abs();
        caster = next;
        if change <= CASTER_CONVERGED * robot.load.total.value() || change.is_nan() {
            return forces;
        }
    }
}

/// Adds the kinetic friction of axles, body and caster.
pub(crate) fn add_dry_friction<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    nu: &Vector<S>,
    mut force: Vector<S>,
    caster_normal: S,
) -> Vector<S> {
    for constraint in robot.dry_friction.constraints.iter() {
        if !mode.slides(constraint) {
            continue;
        }
        let limit = robot.dry_friction.limit(constraint, caster_normal);
        let direction = sliding_direction(robot, mode, constraint, nu);
        for (&row, part) in constraint.rows().iter().zip(direction) {
            force -= robot.jacobian_row(row) * (limit * part);
        }
    }
    force
}

/// Unit direction in which a sliding constraint slides.
#[inline]
pub(crate) fn sliding_direction<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    constraint: FrictionConstraint,
    nu: &Vector<S>,
) -> Pair<S> {
    let mut slip = robot.slip_velocity(constraint, nu);
    if mode.slides_longitudinally_only(constraint) {
        slip[1] = S::constant(0.0);
    }
    let speed = length(slip);
    if speed.value() <= SLIP_DIRECTION_MIN {
        return mode.direction[constraint as usize];
    }
    let per_speed = speed.recip();
    [slip[0] * per_speed, slip[1] * per_speed]
}

/// Forces at the driven wheels, added to `force` where they slide.
#[inline]
fn wheel_forces<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    dynamics: &ConstrainedDynamics<S>,
    nu: &Vector<S>,
    force: Vector<S>,
    prescribed_surge: S,
) -> Forces<S> {
    let sticks = !mode.active.intersection(ConstraintSet::WHEELS).is_empty();
    let lateral = if sticks {
        dynamics.multiplier(LATERAL, &force)
    } else {
        S::constant(0.0)
    };
    let slides = FrictionConstraint::WHEELS.map(|wheel| mode.slides(wheel));
    if slides == [false; 2] && robot.load.transfer.is_none() {
        return sticking_wheels(robot, mode, dynamics, force, sticks, lateral);
    }
    let sliding = SlidingWheels::new(robot, mode, dynamics, nu, sticks);
    let surge = robot.load.transfer.map(|transfer| {
        let rate = |f: &Vector<S>| dynamics.acceleration.row(0).transpose().dot(f);
        let [right, left] = &sliding.generalised;
        LoadTransfer {
            transfer,
            free: prescribed_surge + rate(&force) - nu[1] * nu[2],
            per_normal: [rate(right), rate(left)],
        }
    });
    sliding.forces(robot, dynamics, force, lateral, sticks, surge)
}

/// Both wheels stick, or cannot slide: the contact forces are multipliers alone.
#[inline]
fn sticking_wheels<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    dynamics: &ConstrainedDynamics<S>,
    force: Vector<S>,
    sticks: bool,
    lateral: S,
) -> Forces<S> {
    let zero = S::constant(0.0);
    let mut longitudinal_n = [zero; 2];
    if sticks {
        longitudinal_n =
            [LONGITUDINAL_RIGHT, LONGITUDINAL_LEFT].map(|row| dynamics.multiplier(row, &force));
    }
    let unneeded = mode.wheel_friction == [None; 2] && robot.dry_friction.caster.is_none();
    let normal_n = if unneeded {
        [zero; 2]
    } else {
        let difference = robot.load.lateral * lateral + robot.load.offset;
        split_normal(robot.load.driven, difference)
    };
    let contact = ContactForces {
        normal_n,
        longitudinal_n,
        lateral_n: lateral,
    };
    Forces { force, contact }
}

/// Kinetic friction of the sliding wheels per newton of normal force; zero for a wheel that sticks.
struct SlidingWheels<S> {
    /// Force at each contact, [longitudinal, lateral].
    at_contact: [Pair<S>; 2],
    /// The same as a generalised force.
    generalised: [Vector<S>; 2],
    /// Lateral force of both wheels: the friction itself, and what a wheel that sticks adds to it.
    lateral: Pair<S>,
}

impl<S: Scalar> SlidingWheels<S> {
    #[inline]
    fn new(
        robot: &Robot<S>,
        mode: &Mode<S>,
        dynamics: &ConstrainedDynamics<S>,
        nu: &Vector<S>,
        sticks: bool,
    ) -> Self {
        let zero = S::constant(0.0);
        let mut wheels = Self {
            at_contact: [[zero; 2]; 2],
            generalised: [Vector::from([zero; 5]); 2],
            lateral: [zero; 2],
        };
        for (i, wheel) in FrictionConstraint::WHEELS.into_iter().enumerate() {
            if let (true, Some(wheel_friction)) = (mode.slides(wheel), mode.wheel_friction[i]) {
                let [x, y] = sliding_direction(robot, mode, wheel, nu);
                let friction = -wheel_friction.friction_kinetic;
                wheels.at_contact[i] = [friction * x, friction * y];
                wheels.generalised[i] = contact_force(robot, i, wheels.at_contact[i]);
                wheels.lateral[i] = wheels.at_contact[i][1];
                if sticks {
                    wheels.lateral[i] += dynamics.multiplier(LATERAL, &wheels.generalised[i]);
                }
            }
        }
        wheels
    }

    /// Solves for the normal forces and scales the friction by them.
    #[inline]
    fn forces(
        &self,
        robot: &Robot<S>,
        dynamics: &ConstrainedDynamics<S>,
        force: Vector<S>,
        lateral: S,
        sticks: bool,
        surge: Option<LoadTransfer<S>>,
    ) -> Forces<S> {
        let normal_n = normal_forces(robot, lateral, self.lateral, surge);
        let [right, left] = self.generalised;
        let force = force + right * normal_n[0] + left * normal_n[1];
        let mut longitudinal_n = [0, 1].map(|i| self.at_contact[i][0] * normal_n[i]);
        if sticks {
            longitudinal_n[0] += dynamics.multiplier(LONGITUDINAL_RIGHT, &force);
            longitudinal_n[1] += dynamics.multiplier(LONGITUDINAL_LEFT, &force);
        }
        let lateral_n = lateral + self.lateral[0] * normal_n[0] + self.lateral[1] * normal_n[1];
        Forces {
            force,
            contact: ContactForces {
                normal_n,
                longitudinal_n,
                lateral_n,
            },
        }
    }
}

/// The generalised force of a force [longitudinal, lateral] at the contact of wheel `i`.
#[inline]
fn contact_force<S: Scalar>(
    robot: &Robot<S>,
    i: usize,
    [longitudinal, lateral]: Pair<S>,
) -> Vector<S> {
    let zero = S::constant(0.0);
    let lever = robot.half_track * longitudinal;
    let moment = if i == 0 { lever } else { -lever } - robot.com_to_axle * lateral;
    let spin = -robot.radius[i] * longitudinal;
    let spin = if i == 0 { [spin, zero] } else { [zero, spin] };
    Vector::from([longitudinal, lateral, moment, spin[0], spin[1]])
}
