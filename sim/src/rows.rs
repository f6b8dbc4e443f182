//! Where dry friction acts, as rows over the velocities: element k sees the velocity J_k ν and
//! answers with a generalised force J_kᵀ p.

use crate::robot::Robot;
use crate::scalar::{Scalar, Vector};

/// Rows of the contact Jacobian.
pub(crate) const ROWS: usize = 9;

/// Slip of the right contact along the wheel: ρ̇_r − r θ̇_r (Eq. 2).
pub(crate) const ALONG_RIGHT: usize = 0;
/// Slip of the left contact along the wheel.
pub(crate) const ALONG_LEFT: usize = 1;
/// Slip of both contacts along the axle: η̇ (Eq. 2).
pub(crate) const ACROSS: usize = 2;
const AXLE_RIGHT: usize = 3;
const AXLE_LEFT: usize = 4;
const SURGE: usize = 5;
const YAW: usize = 6;
const CASTER_ALONG: usize = 7;
const CASTER_ACROSS: usize = 8;

/// Number of elements with dry friction.
pub(crate) const ELEMENTS: usize = 7;

/// An element with dry friction of one or two directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Element {
    WheelRight,
    WheelLeft,
    AxleRight,
    AxleLeft,
    Surge,
    Yaw,
    Caster,
}

impl Element {
    pub(crate) const ALL: [Self; ELEMENTS] = [
        Self::WheelRight,
        Self::WheelLeft,
        Self::AxleRight,
        Self::AxleLeft,
        Self::Surge,
        Self::Yaw,
        Self::Caster,
    ];
    /// The driven wheels' contacts, right and left.
    pub(crate) const WHEELS: [Self; 2] = [Self::WheelRight, Self::WheelLeft];
    /// The axles, right and left.
    pub(crate) const AXLES: [Self; 2] = [Self::AxleRight, Self::AxleLeft];

    /// The element's rows.
    pub(crate) fn rows(self) -> &'static [usize] {
        match self {
            Self::WheelRight => &[ALONG_RIGHT, ACROSS],
            Self::WheelLeft => &[ALONG_LEFT, ACROSS],
            Self::AxleRight => &[AXLE_RIGHT],
            Self::AxleLeft => &[AXLE_LEFT],
            Self::Surge => &[SURGE],
            Self::Yaw => &[YAW],
            Self::Caster => &[CASTER_ALONG, CASTER_ACROSS],
        }
    }
}

/// A set of elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Elements(u8);

impl Elements {
    pub(crate) const WHEELS: Self = Self(0b11);

    pub(crate) fn with(self, element: Element) -> Self {
        Self(self.0 | 1 << element as u8)
    }

    pub(crate) fn without(self, element: Element) -> Self {
        Self(self.0 & !(1 << element as u8))
    }

    pub(crate) fn has(self, element: Element) -> bool {
        self.0 & (1 << element as u8) != 0
    }

    pub(crate) fn without_all(self, others: Self) -> Self {
        Self(self.0 & !others.0)
    }

    pub(crate) fn both(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    pub(crate) fn either(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = Element> {
        Element::ALL
            .into_iter()
            .filter(move |&element| self.has(element))
    }

    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }
}

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

    /// Velocities at which the right and the left contact slide along the wheel, and both across
    /// it (m/s).
    pub fn slip_m_s(&self, state: &crate::State<S>) -> [S; 3] {
        self.slip(&state.body.nu)
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
