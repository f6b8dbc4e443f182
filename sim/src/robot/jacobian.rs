//! Contact Jacobian: element k sees the velocity J_k ν and answers with a generalised force J_kᵀ p.

use super::constants::Robot;
use crate::parts::friction_elements::{
    ACROSS, ALONG_LEFT, ALONG_RIGHT, AXLE_LEFT, AXLE_RIGHT, CASTER_ACROSS, Element, YAW,
};
use crate::parts::scalar::{Scalar, Vector};

impl<S: Scalar> Robot<S> {
    /// Row of the contact Jacobian.
    pub(crate) fn row(&self, row: usize) -> Vector<S> {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let [right, left] = self.radius;
        let (b, d, e) = (self.half_track, self.com_to_axle, self.com_to_caster);
        Vector::from(match row {
            ALONG_RIGHT => [one, zero, b, -right, zero],
            ALONG_LEFT => [one, zero, -b, zero, -left],
            ACROSS => [zero, one, -d, zero, zero],
            AXLE_RIGHT => [zero, zero, zero, one, zero],
            AXLE_LEFT => [zero, zero, zero, zero, one],
            YAW => [zero, zero, one, zero, zero],
            CASTER_ACROSS => [zero, one, e, zero, zero],
            _ => [one, zero, zero, zero, zero],
        })
    }

    /// Slip velocity of the right and the left contact along the wheel and of both along the axle
    /// (m/s): the differences that Eq. 1 sets to zero.
    #[inline]
    pub(crate) fn slip(&self, nu: &Vector<S>) -> [S; 3] {
        let turn = self.half_track * nu[2];
        [
            nu[0] + turn - self.radius[0] * nu[3],
            nu[0] - turn - self.radius[1] * nu[4],
            nu[1] - self.com_to_axle * nu[2],
        ]
    }

    /// Velocity that an element sees: along its one or two rows.
    #[inline]
    pub(crate) fn seen(&self, element: Element, nu: &Vector<S>) -> [S; 2] {
        let zero = S::constant(0.0);
        match element {
            Element::WheelRight => {
                let [right, _, across] = self.slip(nu);
                [right, across]
            }
            Element::WheelLeft => {
                let [_, left, across] = self.slip(nu);
                [left, across]
            }
            Element::AxleRight => [nu[3], zero],
            Element::AxleLeft => [nu[4], zero],
            Element::Surge => [nu[0], zero],
            Element::Yaw => [nu[2], zero],
            Element::Caster => [nu[0], nu[1] + self.com_to_caster * nu[2]],
        }
    }

    /// Limit of the dry friction at an element that is not a driven wheel's contact (N or N m),
    /// when the caster carries `caster_normal`. Zero where there is none.
    pub(crate) fn dry_limit(&self, element: Element, caster_normal: S) -> S {
        match element {
            Element::WheelRight | Element::WheelLeft => None,
            Element::AxleRight | Element::AxleLeft => self.dry.axle,
            Element::Surge => self.dry.surge,
            Element::Yaw => self.dry.yaw,
            Element::Caster => self.dry.caster.map(|friction| friction * caster_normal),
        }
        .unwrap_or(S::constant(0.0))
    }
}
