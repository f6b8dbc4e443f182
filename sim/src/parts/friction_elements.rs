//! Friction elements: where dry friction acts, and the rows of the contact Jacobian that belong to each.

/// Rows of the contact Jacobian.
pub(crate) const ROWS: usize = 9;

/// Slip of the right contact along the wheel: ρ̇_r − r θ̇_r (Eq. 2).
pub(crate) const ALONG_RIGHT: usize = 0;
/// Slip of the left contact along the wheel.
pub(crate) const ALONG_LEFT: usize = 1;
/// Slip of both contacts along the axle: η̇ (Eq. 2).
pub(crate) const ACROSS: usize = 2;
pub(crate) const AXLE_RIGHT: usize = 3;
pub(crate) const AXLE_LEFT: usize = 4;
pub(crate) const SURGE: usize = 5;
pub(crate) const YAW: usize = 6;
pub(crate) const CASTER_ALONG: usize = 7;
pub(crate) const CASTER_ACROSS: usize = 8;

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
pub(crate) struct ElementSet(u8);

impl ElementSet {
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
