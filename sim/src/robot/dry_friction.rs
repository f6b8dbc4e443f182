//! Coulomb friction limits of axles, body and caster: all dry friction except that of the driven
//! wheels' contacts.

use crate::parts::friction_constraints::{ConstraintSet, FrictionConstraint};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::{Pair, Scalar};

/// Friction limits; `None` where there is no friction.
#[derive(Debug, Clone)]
pub(crate) struct DryFriction<S> {
    /// The constraints that have friction.
    pub(crate) constraints: ConstraintSet,
    /// Torque limit at each axle, times 1 - s of its wheel (N m).
    axle: Option<Pair<S>>,
    /// Force limit along the body (N).
    surge: Option<S>,
    /// Moment limit about the vertical (N m).
    yaw: Option<S>,
    /// Friction coefficient of the caster's contact (1).
    pub(crate) caster: Option<S>,
}

impl<S: Scalar> DryFriction<S> {
    pub(super) fn new(parameters: &RobotParameters<S>, weight: S, travel: Pair<S>) -> Self {
        let present = [
            (
                parameters.axle_torque.is_some(),
                FrictionConstraint::AxleRight,
            ),
            (
                parameters.axle_torque.is_some(),
                FrictionConstraint::AxleLeft,
            ),
            (
                parameters.rolling_coefficient.is_some(),
                FrictionConstraint::Surge,
            ),
            (parameters.yaw_moment.is_some(), FrictionConstraint::Yaw),
            (
                parameters.caster_friction.is_some(),
                FrictionConstraint::Caster,
            ),
        ];
        Self {
            constraints: present
                .into_iter()
                .filter_map(|(present, constraint)| present.then_some(constraint))
                .collect(),
            axle: parameters
                .axle_torque
                .map(|torque| travel.map(|t| torque * t)),
            surge: parameters.rolling_coefficient.map(|c| c * weight),
            yaw: parameters.yaw_moment,
            caster: parameters.caster_friction,
        }
    }

    /// Friction limit of a constraint (N or N m) when the caster carries `caster_normal` (N). Zero
    /// without friction, and for the driven wheels, whose limits depend on the floor.
    pub(crate) fn limit(&self, constraint: FrictionConstraint, caster_normal: S) -> S {
        match constraint {
            FrictionConstraint::WheelRight | FrictionConstraint::WheelLeft => None,
            FrictionConstraint::AxleRight => self.axle.map(|[right, _]| right),
            FrictionConstraint::AxleLeft => self.axle.map(|[_, left]| left),
            FrictionConstraint::Surge => self.surge,
            FrictionConstraint::Yaw => self.yaw,
            FrictionConstraint::Caster => self.caster.map(|friction| friction * caster_normal),
        }
        .unwrap_or(S::constant(0.0))
    }
}
