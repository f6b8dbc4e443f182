//! Friction margins: how far the forces of sticking constraints are from their Coulomb limits.

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::dynamics::forces::Forces;
use crate::parts::friction_constraints::{ConstraintSet, FrictionConstraint};
use crate::parts::scalar::{Pair, Scalar, length, smaller};
use crate::parts::tolerances::{LIMIT_SLACK, SURELY_STICKS};
use crate::robot::Robot;
use crate::robot::mode::Mode;

/// Margins of the sticking constraints, each relative to its limit.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrictionMargin<S> {
    /// The smallest of them.
    pub(super) smallest: S,
    /// Constraints whose limit is exceeded.
    pub(super) exceeded: ConstraintSet,
}

impl<S: Scalar> FrictionMargin<S> {
    fn new(margin: S, constraint: FrictionConstraint) -> Self {
        Self {
            smallest: margin,
            exceeded: ConstraintSet::default(),
        }
        .and(margin, ConstraintSet::of(constraint))
    }

    fn and(self, margin: S, constraints: ConstraintSet) -> Self {
        let exceeded = if margin.value() < -LIMIT_SLACK {
            constraints
        } else {
            ConstraintSet::default()
        };
        Self {
            smallest: smaller(self.smallest, margin),
            exceeded: self.exceeded.union(exceeded),
        }
    }
}

/// The margin of the sticking constraints under `forces`; `None` if nothing sticks or all of it is
/// surely inside its limits. A redundant active set is left to the contact solver, except for the
/// driven wheels.
pub(super) fn friction_margin<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    dynamics: &ConstrainedDynamics<S>,
    forces: &Forces<S>,
) -> Option<FrictionMargin<S>> {
    let sticking = mode.active.intersection(mode.frictional);
    if sticking.is_empty() {
        return None;
    }
    let mut margin = wheel_margin(mode, forces);
    if dynamics.redundant {
        return margin;
    }
    let dry = sticking.intersection(robot.dry_friction.constraints);
    for constraint in dry.iter() {
        let [right, left] = forces.contact.normal_n;
        let caster = robot.load.total - right - left;
        let limit = robot.dry_friction.limit(constraint, caster);
        let multiplier = |row: usize| dynamics.multiplier(row, &forces.force);
        let force = match *constraint.rows() {
            [row] => [multiplier(row), S::constant(0.0)],
            [along, across, ..] => [multiplier(along), multiplier(across)],
            [] => [S::constant(0.0); 2],
        };
        let own = relative_margin(limit, length(force));
        margin = Some(match margin {
            None => FrictionMargin::new(own, constraint),
            Some(margin) => margin.and(own, ConstraintSet::of(constraint)),
        });
    }
    margin
}

/// Margin of the driven wheels that stick: each one's force stays inside its friction disc.
fn wheel_margin<S: Scalar>(mode: &Mode<S>, forces: &Forces<S>) -> Option<FrictionMargin<S>> {
    let contact = &forces.contact;
    let sticking = mode.active.intersection(mode.frictional);
    let limit = |i: usize| {
        let sticks = sticking.contains(FrictionConstraint::WHEELS[i]);
        let friction = mode.wheel_friction[i].filter(|_| sticks)?;
        Some(friction.friction_static * contact.normal_n[i])
    };
    // a wheel that cannot slide takes the whole lateral force from the one beside it
    let force = |i: usize| {
        let other = FrictionConstraint::WHEELS[1 - i];
        let lateral = if mode.frictional.contains(other) {
            contact.lateral_n
        } else {
            S::constant(0.0)
        };
        length([contact.longitudinal_n[i], lateral])
    };
    match [limit(0), limit(1)] {
        [None, None] => None,
        [Some(right), Some(left)] => both_wheels_margin(mode, forces, [right, left]),
        [Some(right), None] => {
            let margin = relative_margin(right, force(0));
            Some(FrictionMargin::new(margin, FrictionConstraint::WheelRight))
        }
        [None, Some(left)] => {
            let margin = relative_margin(left, force(1));
            Some(FrictionMargin::new(margin, FrictionConstraint::WheelLeft))
        }
    }
}

/// Margin of two sticking wheels: their lateral force may be shared in any way that keeps both
/// forces inside their discs of radius `limits` (N).
fn both_wheels_margin<S: Scalar>(
    mode: &Mode<S>,
    forces: &Forces<S>,
    limits: Pair<S>,
) -> Option<FrictionMargin<S>> {
    let contact = &forces.contact;
    let longitudinal = contact.longitudinal_n;
    let lateral_square = contact.lateral_n * contact.lateral_n;
    let carries_all = |i: usize| {
        let square = longitudinal[i] * longitudinal[i];
        (square + lateral_square).value() <= (limits[i] * limits[i]).value() * SURELY_STICKS
    };
    if carries_all(0) && carries_all(1) {
        return None;
    }
    let along = [0, 1].map(|i| relative_margin(limits[i], longitudinal[i].abs()));
    let left = ConstraintSet::of(FrictionConstraint::WheelLeft);
    let margin = FrictionMargin::new(along[0], FrictionConstraint::WheelRight).and(along[1], left);
    if margin.smallest.value() <= 0.0 {
        return Some(margin);
    }
    // lateral force that each wheel can carry beside its longitudinal one
    let spare = [0, 1].map(|i| (limits[i] * limits[i] - longitudinal[i] * longitudinal[i]).sqrt());
    let across = relative_margin(spare[0] + spare[1], contact.lateral_n.abs());
    Some(margin.and(across, first_to_break_away(mode, spare)))
}

/// Which wheels break away when the lateral force exceeds what both can carry, `spare` (N) each. If
/// friction drops when sliding begins, it is the one with less to spare: the other then has to
/// carry the rest under static friction, and may be able to.
fn first_to_break_away<S: Scalar>(mode: &Mode<S>, spare: Pair<S>) -> ConstraintSet {
    let [right, left] = spare.map(|spare| spare.value());
    let first = usize::from(left < right);
    let friction_drops = mode.wheel_friction[first].is_some_and(|friction| {
        friction.friction_static.value() > friction.friction_kinetic.value()
    });
    if friction_drops && right != left {
        ConstraintSet::of(FrictionConstraint::WHEELS[first])
    } else {
        ConstraintSet::WHEELS
    }
}

/// What is left of `limit` beside `force`, relative to it. A limit of zero is exceeded by any
/// force.
fn relative_margin<S: Scalar>(limit: S, force: S) -> S {
    if limit.value() > 0.0 {
        (limit - force) / limit
    } else {
        -force
    }
}
