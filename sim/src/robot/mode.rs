//! Mode of the hybrid system: which friction constraints stick, which slide, and how the gears are
//! engaged. Constant between two events.

use super::constants::Robot;
use crate::parts::command::CommandKind;
use crate::parts::friction_constraints::{ConstraintSet, FRICTION_CONSTRAINTS, FrictionConstraint};
use crate::parts::parameters::Friction;
use crate::parts::scalar::{Pair, Scalar};

/// The discrete part of the state. The sliding set is `frictional` without `active`.
#[derive(Debug, Clone)]
pub(crate) struct Mode<S> {
    /// What the command prescribes.
    pub(crate) kind: CommandKind,
    /// Active set: constraints that hold, because they stick or because they cannot slide.
    /// Prescribed wheel speeds are not in it; they follow from `kind` and `gear`.
    pub(crate) active: ConstraintSet,
    /// Constraints with a friction limit: they stick or slide. The others never slide.
    pub(crate) frictional: ConstraintSet,
    /// Unit direction of each constraint's sliding, kept from when it began.
    pub(crate) direction: [Pair<S>; FRICTION_CONSTRAINTS],
    /// Friction under each driven wheel; `None`: it cannot slide.
    pub(crate) wheel_friction: Pair<Option<Friction<S>>>,
    /// Contact between each motor and its wheel.
    pub(crate) gear: [Gear; 2],
}

impl<S: Scalar> Mode<S> {
    /// The key of the dynamics with `active` as active set, for a step of `over_s` (s).
    pub(crate) fn dynamics_key(&self, active: ConstraintSet, over_s: f64) -> DynamicsKey {
        DynamicsKey {
            active,
            gear: self.gear,
            kind: self.kind,
            over_s,
        }
    }

    /// Whether the constraint is in the sliding set.
    pub(crate) fn slides(&self, constraint: FrictionConstraint) -> bool {
        self.frictional.contains(constraint) && !self.active.contains(constraint)
    }

    /// Whether the other driven wheel sticks: both share the lateral slip, so this one can slide
    /// longitudinally only.
    #[inline]
    pub(crate) fn slides_longitudinally_only(&self, constraint: FrictionConstraint) -> bool {
        match constraint {
            FrictionConstraint::WheelRight => self.active.contains(FrictionConstraint::WheelLeft),
            FrictionConstraint::WheelLeft => self.active.contains(FrictionConstraint::WheelRight),
            _ => false,
        }
    }
}

/// Contact between a motor and its wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gear {
    /// No backlash: motor and wheel turn as one.
    Rigid,
    /// θ_m − θ_w = gap / 2; the motor drives the wheel forward.
    Forward,
    /// θ_m − θ_w = −gap / 2; the motor drives the wheel backward.
    Backward,
    /// |θ_m − θ_w| < gap / 2; the motor transmits nothing.
    Free,
}

impl Gear {
    /// Whether motor and wheel turn as one.
    pub(crate) fn is_engaged(self) -> bool {
        self != Self::Free
    }
}

/// What the constrained dynamics depend on besides the robot: they are computed anew only when this
/// changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DynamicsKey {
    pub(crate) active: ConstraintSet,
    pub(crate) gear: [Gear; 2],
    pub(crate) kind: CommandKind,
    /// Length of the step (s) if damping makes it matter, else 0.
    pub(crate) over_s: f64,
}

/// The constraints with a friction limit under a command of `kind`, with `wheel_friction` under the
/// driven wheels. Prescribed wheel speeds fix the axles; if the wheels cannot slide either, they
/// fix the whole robot.
pub(crate) fn frictional_constraints<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    wheel_friction: Pair<Option<Friction<S>>>,
) -> ConstraintSet {
    let wheels = FrictionConstraint::WHEELS.into_iter().zip(wheel_friction);
    let wheels: ConstraintSet = wheels
        .filter_map(|(wheel, friction)| friction.map(|_| wheel))
        .collect();
    let dry = robot.dry_friction.constraints;
    match kind {
        CommandKind::Speed if wheels.is_empty() => ConstraintSet::default(),
        CommandKind::Speed => wheels.union(
            dry.without(FrictionConstraint::AxleRight)
                .without(FrictionConstraint::AxleLeft),
        ),
        CommandKind::Torque | CommandKind::Voltage => wheels.union(dry),
    }
}
