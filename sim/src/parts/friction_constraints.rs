//! Friction constraints: the contacts and bearings with Coulomb friction, and their rows of the
//! contact Jacobian.
//!
//! Indices and sets only; the rows themselves belong to a robot (`robot/jacobian.rs`).

/// Number of rows of the contact Jacobian.
pub(crate) const JACOBIAN_ROWS: usize = 9;

/// Row of the right contact's longitudinal slip, ρ̇_r − r θ̇_r (Eq. 2).
pub(crate) const LONGITUDINAL_RIGHT: usize = 0;
/// Row of the left contact's longitudinal slip, ρ̇_l − r θ̇_l (Eq. 2).
pub(crate) const LONGITUDINAL_LEFT: usize = 1;
/// Row of the lateral slip η̇ (Eq. 2), which both contacts share.
pub(crate) const LATERAL: usize = 2;
/// Row of the right wheel's speed θ̇_r.
pub(crate) const AXLE_RIGHT: usize = 3;
/// Row of the left wheel's speed θ̇_l.
pub(crate) const AXLE_LEFT: usize = 4;
/// Row of the surge velocity of c.
pub(crate) const SURGE: usize = 5;
/// Row of the yaw rate.
pub(crate) const YAW: usize = 6;
/// Row of the caster contact's longitudinal velocity.
pub(crate) const CASTER_LONGITUDINAL: usize = 7;
/// Row of the caster contact's lateral velocity.
pub(crate) const CASTER_LATERAL: usize = 8;

/// Number of friction constraints.
pub(crate) const FRICTION_CONSTRAINTS: usize = 7;

/// A place with Coulomb friction in one or two directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FrictionConstraint {
    /// Contact of the right driven wheel.
    WheelRight,
    /// Contact of the left driven wheel.
    WheelLeft,
    /// Bearing of the right wheel (`axle_friction`).
    AxleRight,
    /// Bearing of the left wheel (`axle_friction`).
    AxleLeft,
    /// Motion along the body (`rolling_resistance`).
    Surge,
    /// Rotation about the vertical (`yaw_scrub`).
    Yaw,
    /// Contact of the caster (`caster_drag`).
    Caster,
}

impl FrictionConstraint {
    pub(crate) const ALL: [Self; FRICTION_CONSTRAINTS] = [
        Self::WheelRight,
        Self::WheelLeft,
        Self::AxleRight,
        Self::AxleLeft,
        Self::Surge,
        Self::Yaw,
        Self::Caster,
    ];
    /// The contacts of the driven wheels, right and left.
    pub(crate) const WHEELS: [Self; 2] = [Self::WheelRight, Self::WheelLeft];
    /// The bearings of the driven wheels, right and left.
    pub(crate) const AXLES: [Self; 2] = [Self::AxleRight, Self::AxleLeft];

    /// Its one or two rows of the contact Jacobian.
    pub(crate) fn rows(self) -> &'static [usize] {
        match self {
            Self::WheelRight => &[LONGITUDINAL_RIGHT, LATERAL],
            Self::WheelLeft => &[LONGITUDINAL_LEFT, LATERAL],
            Self::AxleRight => &[AXLE_RIGHT],
            Self::AxleLeft => &[AXLE_LEFT],
            Self::Surge => &[SURGE],
            Self::Yaw => &[YAW],
            Self::Caster => &[CASTER_LONGITUDINAL, CASTER_LATERAL],
        }
    }
}

/// A set of friction constraints, as a bit mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct ConstraintSet(u8);

impl ConstraintSet {
    /// Both driven wheels.
    pub(crate) const WHEELS: Self = Self(0b11);

    /// The set of one constraint.
    pub(crate) fn of(constraint: FrictionConstraint) -> Self {
        Self::default().with(constraint)
    }

    pub(crate) fn with(self, constraint: FrictionConstraint) -> Self {
        Self(self.0 | 1 << constraint as u8)
    }

    pub(crate) fn without(self, constraint: FrictionConstraint) -> Self {
        Self(self.0 & !(1 << constraint as u8))
    }

    pub(crate) fn contains(self, constraint: FrictionConstraint) -> bool {
        self.0 & (1 << constraint as u8) != 0
    }

    pub(crate) fn difference(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    pub(crate) fn intersection(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = FrictionConstraint> {
        FrictionConstraint::ALL
            .into_iter()
            .filter(move |&constraint| self.contains(constraint))
    }

    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl FromIterator<FrictionConstraint> for ConstraintSet {
    fn from_iter<I: IntoIterator<Item = FrictionConstraint>>(constraints: I) -> Self {
        constraints.into_iter().fold(Self::default(), Self::with)
    }
}
