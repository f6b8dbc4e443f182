//! Coulomb friction at acceleration level, solved by block Gauss-Seidel with projection on the
//! friction discs.
//!
//! At one instant the accelerations minimise ½ (a − a₀)ᵀ M (a − a₀) + Σ limit |J a|, summed over
//! the constraints at rest: Gauss's principle of least constraint (1829) with Coulomb friction. The
//! minimum is unique. A sweep gives each constraint in turn the force inside its disc that fits the
//! forces of the others. An outer fixed-point iteration makes the friction limits agree with the
//! normal forces.
//!
//! The solver computes with plain numbers, because its result is discrete: the active set. What
//! follows from it is computed with derivatives by the dynamics of the new set.

use super::friction_disc::{InverseMass, project_on_disc, project_on_interval};
use crate::parts::friction_constraints::{ConstraintSet, FRICTION_CONSTRAINTS, FrictionConstraint};
use crate::parts::scalar::{Matrix, Pair, Scalar, Vector};
use crate::parts::tolerances::{NORMAL_CONVERGED, SWEEP_CONVERGED, ZERO_ACCELERATION};
use crate::robot::mode::Mode;
use crate::robot::{GRAVITY_M_S2, Robot};

/// The friction problem at one instant.
pub(crate) struct FrictionProblem<'a, S> {
    pub(crate) robot: &'a Robot<S>,
    pub(crate) mode: &'a Mode<S>,
    /// A: M⁻¹ projected on the motions that the constraints without friction limit leave free.
    pub(crate) mobility: Matrix<f64>,
    /// Generalised force without any friction.
    pub(crate) applied: Vector<f64>,
    /// Acceleration that prescribed wheel speeds force on the robot.
    pub(crate) prescribed: Vector<f64>,
    /// Velocity ν.
    pub(crate) nu: Vector<f64>,
    /// Frictional constraints at rest: each sticks or begins to slide.
    pub(crate) at_rest: ConstraintSet,
    /// Lateral force of wheels that cannot slide, per unit of each force.
    pub(crate) lateral: Vector<f64>,
}

/// The solution: constraints that stick, and the directions in which the others begin to slide.
pub(crate) struct ContactModes {
    pub(crate) sticking: ConstraintSet,
    /// Unit vector for each constraint that begins to slide, else zero.
    pub(crate) direction: [Pair<f64>; FRICTION_CONSTRAINTS],
}

/// Response of the robot to unit forces at one constraint.
#[derive(Clone, Copy, Default)]
struct ConstraintResponse {
    /// Rows of the contact Jacobian.
    jacobian: [Vector<f64>; 2],
    /// Acceleration of the robot per unit force along each row.
    acceleration: [Vector<f64>; 2],
    /// Slip acceleration of the constraint per unit force of its own.
    inverse_mass: InverseMass,
}

type ConstraintForces = [Pair<f64>; FRICTION_CONSTRAINTS];
type ForceLimits = [f64; FRICTION_CONSTRAINTS];
type Responses = [ConstraintResponse; FRICTION_CONSTRAINTS];

impl<S: Scalar> FrictionProblem<'_, S> {
    /// Decides for each constraint at rest whether it sticks. Those in `broken_away` have exceeded
    /// their static limit and have kinetic friction from the start; others join them when they
    /// accelerate, until none does.
    pub(crate) fn solve(&self, broken_away: ConstraintSet) -> ContactModes {
        let mut responses = Responses::default();
        for constraint in self.at_rest.iter() {
            responses[constraint as usize] = self.response(constraint);
        }
        let mut force = ConstraintForces::default();
        let mut sliding = self.at_rest.intersection(broken_away);
        loop {
            let acceleration = self.accelerations(sliding, &responses, &mut force);
            let scale = self.acceleration_scale();
            let accelerates = |&constraint: &FrictionConstraint| {
                let [along, across] = self.slip_velocity(constraint, &acceleration);
                along.hypot(across) > ZERO_ACCELERATION * scale
            };
            let starting = self.at_rest.iter().filter(accelerates);
            let next = starting.fold(sliding, ConstraintSet::with);
            if next == sliding {
                return self.modes(&force, sliding);
            }
            sliding = next;
        }
    }

    fn response(&self, constraint: FrictionConstraint) -> ConstraintResponse {
        let mut response = ConstraintResponse::default();
        for (i, &row) in constraint.rows().iter().enumerate() {
            response.jacobian[i] = self.jacobian_row(row);
            response.acceleration[i] = self.mobility * response.jacobian[i];
        }
        let entry = |i: usize, j: usize| response.jacobian[i].dot(&response.acceleration[j]);
        response.inverse_mass = [entry(0, 0), entry(0, 1), entry(1, 1)];
        response
    }

    /// The active set and the sliding directions, opposite to the friction forces.
    fn modes(&self, force: &ConstraintForces, sliding: ConstraintSet) -> ContactModes {
        let mut modes = ContactModes {
            sticking: self.at_rest,
            direction: [[0.0; 2]; FRICTION_CONSTRAINTS],
        };
        for constraint in sliding.iter() {
            let [along, across] = force[constraint as usize];
            let size = along.hypot(across);
            if size > 0.0 {
                modes.sticking = modes.sticking.without(constraint);
                modes.direction[constraint as usize] = [-along / size, -across / size];
            }
        }
        modes
    }

    /// Size of the accelerations in play (m/s² or rad/s²), by which to judge what counts as zero.
    fn acceleration_scale(&self) -> f64 {
        let free = self.mobility * self.applied;
        free.iter()
            .fold(GRAVITY_M_S2 * 1e-3, |most: f64, a| most.max(a.abs()))
    }

    /// The accelerations, with normal forces that agree with the lateral forces.
    fn accelerations(
        &self,
        sliding: ConstraintSet,
        responses: &Responses,
        force: &mut ConstraintForces,
    ) -> Vector<f64> {
        let load = &self.robot.load;
        let mut normal = [load.driven.value() / 2.0; 2];
        for _ in 0..self.robot.tolerances.normal_iterations {
            let limits = self.friction_limits(sliding, normal);
            let acceleration = self.gauss_seidel(&limits, responses, force);
            let next = self.normal_forces(&limits, force, &acceleration);
            let change = (next[0] - normal[0]).abs().max((next[1] - normal[1]).abs());
            normal = next;
            if change <= NORMAL_CONVERGED * load.total.value() {
                return acceleration;
            }
        }
        self.gauss_seidel(&self.friction_limits(sliding, normal), responses, force)
    }

    /// N_r and N_l (Eq. 4 to 6) under these forces and accelerations (N).
    fn normal_forces(
        &self,
        limits: &ForceLimits,
        force: &mut ConstraintForces,
        acceleration: &Vector<f64>,
    ) -> Pair<f64> {
        let load = &self.robot.load;
        let total = self.total_force(limits, force);
        let lateral: f64 = FrictionConstraint::WHEELS
            .iter()
            .map(|&wheel| force[wheel as usize][1])
            .sum();
        let lateral = lateral + self.lateral.dot(&total);
        let surge = acceleration[0] - self.nu[1] * self.nu[2];
        let transfer = load.transfer.map_or(0.0, |t| t.value() * surge);
        // `max` and `min`, for `clamp` panics where a state is not a number
        let sum = (load.driven.value() + transfer)
            .max(0.0)
            .min(load.total.value());
        let difference = load.lateral.value() * lateral + load.offset.value();
        let difference = difference.max(-sum).min(sum);
        [(sum + difference) / 2.0, (sum - difference) / 2.0]
    }

    /// Friction limit of each constraint (N or N m) under these normal forces: static for those at
    /// rest that are not in `sliding`, else kinetic.
    fn friction_limits(&self, sliding: ConstraintSet, normal: Pair<f64>) -> ForceLimits {
        let mut limits = ForceLimits::default();
        let caster = self.robot.load.total.value() - normal[0] - normal[1];
        for constraint in self.mode.frictional.iter() {
            let i = constraint as usize;
            limits[i] = match (constraint, self.mode.wheel_friction.get(i)) {
                (
                    FrictionConstraint::WheelRight | FrictionConstraint::WheelLeft,
                    Some(Some(friction)),
                ) => {
                    let sticks = self.at_rest.contains(constraint) && !sliding.contains(constraint);
                    let coefficient = if sticks {
                        friction.friction_static
                    } else {
                        friction.friction_kinetic
                    };
                    coefficient.value() * normal[i]
                }
                _ => {
                    let caster = S::constant(caster);
                    self.robot.dry_friction.limit(constraint, caster).value()
                }
            };
        }
        limits
    }

    /// Sum of the applied force and all friction, as a generalised force. Sets the entries of
    /// `force` for constraints that are not at rest: kinetic friction against their slip.
    fn total_force(&self, limits: &ForceLimits, force: &mut ConstraintForces) -> Vector<f64> {
        let mut total = self.applied;
        for constraint in self.mode.frictional.iter() {
            let i = constraint as usize;
            if !self.at_rest.contains(constraint) {
                let [along, across] = self.slip_velocity(constraint, &self.nu);
                let size = along.hypot(across).max(f64::MIN_POSITIVE);
                force[i] = [-limits[i] * along / size, -limits[i] * across / size];
            }
            for (&row, part) in constraint.rows().iter().zip(force[i]) {
                total += self.jacobian_row(row) * part;
            }
        }
        total
    }

    /// Sweeps over the constraints at rest until no force changes; returns the accelerations.
    fn gauss_seidel(
        &self,
        limits: &ForceLimits,
        responses: &Responses,
        force: &mut ConstraintForces,
    ) -> Vector<f64> {
        let total = self.total_force(limits, force);
        let mut acceleration = self.mobility * total + self.prescribed;
        let scale = self.acceleration_scale();
        for _ in 0..self.robot.tolerances.sweeps {
            let mut change: f64 = 0.0;
            for constraint in self.at_rest.iter() {
                let i = constraint as usize;
                let response = &responses[i];
                let next = self.project(constraint, response, limits[i], force[i], &acceleration);
                let per_force = &response.acceleration[..constraint.rows().len()];
                for (k, per_force) in per_force.iter().enumerate() {
                    let more = next[k] - force[i][k];
                    force[i][k] = next[k];
                    let effect = per_force * more;
                    acceleration += effect;
                    change = change.max(effect.amax());
                }
            }
            if change <= SWEEP_CONVERGED * scale {
                break;
            }
        }
        acceleration
    }

    /// The force of one constraint that fits the forces of all others.
    fn project(
        &self,
        constraint: FrictionConstraint,
        response: &ConstraintResponse,
        limit: f64,
        force: Pair<f64>,
        acceleration: &Vector<f64>,
    ) -> Pair<f64> {
        let [along, ..] = response.inverse_mass;
        let slip_along = response.jacobian[0].dot(acceleration);
        if constraint.rows().len() == 1 || self.is_laterally_fixed(constraint) {
            return if along > 0.0 {
                [project_on_interval(along, limit, force[0], slip_along), 0.0]
            } else {
                force
            };
        }
        let slip = [slip_along, response.jacobian[1].dot(acceleration)];
        project_on_disc(response.inverse_mass, limit, force, slip)
    }

    fn jacobian_row(&self, row: usize) -> Vector<f64> {
        self.robot.jacobian_row(row).map(|entry| entry.value())
    }

    /// Whether the constraint is a wheel beside one that cannot slide, which fixes the lateral slip
    /// of both.
    fn is_laterally_fixed(&self, constraint: FrictionConstraint) -> bool {
        let frictional = self.mode.frictional;
        match constraint {
            FrictionConstraint::WheelRight => !frictional.contains(FrictionConstraint::WheelLeft),
            FrictionConstraint::WheelLeft => !frictional.contains(FrictionConstraint::WheelRight),
            _ => false,
        }
    }

    /// Slip velocity of a constraint at velocity `nu`, or slip acceleration at an acceleration.
    fn slip_velocity(&self, constraint: FrictionConstraint, nu: &Vector<f64>) -> Pair<f64> {
        let rows = constraint.rows();
        let along = self.jacobian_row(rows[0]).dot(nu);
        let across = rows
            .get(1)
            .filter(|_| !self.is_laterally_fixed(constraint))
            .map_or(0.0, |&row| self.jacobian_row(row).dot(nu));
        [along, across]
    }
}
