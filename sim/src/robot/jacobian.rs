//! Contact Jacobian J: constraint k has the slip velocity J_k ν, and its force p acts as the
//! generalised force J_kᵀ p. In the body frame J is constant.

use super::constants::Robot;
use crate::parts::friction_constraints::{
    AXLE_LEFT, AXLE_RIGHT, CASTER_LATERAL, FrictionConstraint, LATERAL, LONGITUDINAL_LEFT,
    LONGITUDINAL_RIGHT, YAW,
};
use crate::parts::scalar::{Pair, Scalar, Vector};

impl<S: Scalar> Robot<S> {
    /// One row of the contact Jacobian.
    pub(crate) fn jacobian_row(&self, row: usize) -> Vector<S> {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let [right, left] = self.radius;
        let (b, d, e) = (self.half_track, self.com_to_axle, self.com_to_caster);
        Vector::from(match row {
            LONGITUDINAL_RIGHT => [one, zero, b, -right, zero],
            LONGITUDINAL_LEFT => [one, zero, -b, zero, -left],
            LATERAL => [zero, one, -d, zero, zero],
            AXLE_RIGHT => [zero, zero, zero, one, zero],
            AXLE_LEFT => [zero, zero, zero, zero, one],
            YAW => [zero, zero, one, zero, zero],
            CASTER_LATERAL => [zero, one, e, zero, zero],
            // surge and the caster's longitudinal velocity
            _ => [one, zero, zero, zero, zero],
        })
    }

    /// Slip velocities of the driven wheels' contacts (m/s): longitudinal right and left, and the
    /// lateral one of both. Eq. 1 sets all three to zero.
    #[inline]
    pub(crate) fn wheel_slip(&self, nu: &Vector<S>) -> [S; 3] {
        let turn = self.half_track * nu[2];
        [
            nu[0] + turn - self.radius[0] * nu[3],
            nu[0] - turn - self.radius[1] * nu[4],
            nu[1] - self.com_to_axle * nu[2],
        ]
    }

    /// Slip velocity of a constraint along its one or two rows (m/s or rad/s).
    #[inline]
    pub(crate) fn slip_velocity(&self, constraint: FrictionConstraint, nu: &Vector<S>) -> Pair<S> {
        let zero = S::constant(0.0);
        match constraint {
            FrictionConstraint::WheelRight => {
                let [right, _, lateral] = self.wheel_slip(nu);
                [right, lateral]
            }
            FrictionConstraint::WheelLeft => {
                let [_, left, lateral] = self.wheel_slip(nu);
                [left, lateral]
            }
            FrictionConstraint::AxleRight => [nu[3], zero],
            FrictionConstraint::AxleLeft => [nu[4], zero],
            FrictionConstraint::Surge => [nu[0], zero],
            FrictionConstraint::Yaw => [nu[2], zero],
            FrictionConstraint::Caster => [nu[0], nu[1] + self.com_to_caster * nu[2]],
        }
    }
}
