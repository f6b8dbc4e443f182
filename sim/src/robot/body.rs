//! Bodily state: the continuous state, contact forces, and the mode (what sticks, what slides, how gears stand).

use super::constants::Robot;
use crate::parts::command::CommandKind;
use crate::parts::friction_elements::{ELEMENTS, Element, ElementSet};
use crate::parts::parameters::Friction;
use crate::parts::scalar::{Pair, Scalar, Vector};

/// The continuous part of the state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<S> {
    /// x and y of c (m) and heading φ (rad), world frame.
    pub(crate) pose: [S; 3],
    /// ν: surge and sway of c in the body frame (m/s), yaw rate and wheel speeds (rad/s).
    pub(crate) nu: Vector<S>,
    /// Wheel angles (rad).
    pub(crate) angle: Pair<S>,
    /// Angles of the motors' side of the gears (rad), where there is backlash.
    pub(crate) motor_angle: Pair<S>,
    /// Speeds of the motors' side of the gears (rad/s), where there is backlash.
    pub(crate) motor_speed: Pair<S>,
    /// Output of the actuators' lag, in the unit of the command.
    pub(crate) lagged: Pair<S>,
    /// dν/dt at the end of the last step.
    pub(crate) acceleration: Vector<S>,
    /// Mean torque at each wheel in the last step, motor curve and droop included (N m).
    pub(crate) torque: Pair<S>,
    /// Contact forces at the end of the last step.
    pub(crate) contact: Contact<S>,
}

/// Forces between floor and driven wheels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact<S = f64> {
    /// N_r and N_l (N). Zero where the robot rolls without slipping by assumption.
    pub normal_n: Pair<S>,
    /// F_long at each wheel (N).
    pub along_n: Pair<S>,
    /// F_lat of both wheels together (N). While both stick its split is not determined.
    pub across_n: S,
}

/// Which elements stick and which slide: constant between two events.
#[derive(Debug, Clone)]
pub(crate) struct Mode<S> {
    /// What the command sets.
    pub(crate) kind: CommandKind,
    /// Held elements, the axles of a speed command among them.
    pub(crate) held: ElementSet,
    /// ElementSet that can slide.
    pub(crate) loose: ElementSet,
    /// Direction in which each element slides, or began to.
    pub(crate) direction: [Pair<S>; ELEMENTS],
    /// Friction under each driven wheel.
    pub(crate) grip: Pair<Option<Friction<S>>>,
    /// How each motor stands to its wheel.
    pub(crate) gear: [Gear; 2],
}

/// How a motor stands to its wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gear {
    /// No play: they turn as one.
    Rigid,
    /// θ_m − θ_w = gap / 2 and the motor drives forward.
    Forward,
    /// θ_m − θ_w = −gap / 2 and the motor drives backward.
    Backward,
    /// |θ_m − θ_w| < gap / 2.
    Free,
}

impl Gear {
    /// Motor and wheel turn as one.
    pub(crate) fn is_engaged(self) -> bool {
        self != Self::Free
    }
}

/// What an operator depends on beside the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DynamicsKey {
    pub(crate) held: ElementSet,
    pub(crate) gear: [Gear; 2],
    pub(crate) kind: CommandKind,
    /// Length of the step (s) where damping matters, else 0.
    pub(crate) over_s: f64,
}

impl<S: Scalar> Mode<S> {
    pub(crate) fn slides(&self, element: Element) -> bool {
        self.loose.has(element) && !self.held.has(element)
    }

    /// Whether a wheel slides beside one that holds: their slip across the axle is the same, and
    /// none.
    #[inline]
    pub(crate) fn is_led(&self, element: Element) -> bool {
        match element {
            Element::WheelRight => self.held.has(Element::WheelLeft),
            Element::WheelLeft => self.held.has(Element::WheelRight),
            _ => false,
        }
    }
}

/// The elements that can slide under a command of `kind` on a floor of friction `grip`. Exact
/// wheel speeds leave the axles no choice, and a robot that rolls on them none at all.
pub(crate) fn can_slide<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    grip: Pair<Option<Friction<S>>>,
) -> ElementSet {
    let wheels = Element::WHEELS
        .into_iter()
        .zip(grip)
        .filter(|(_, grip)| grip.is_some());
    let wheels = wheels.fold(ElementSet::default(), |set, (wheel, _)| set.with(wheel));
    match kind {
        CommandKind::Speed if wheels.is_empty() => ElementSet::default(),
        CommandKind::Speed => wheels.either(
            robot
                .dry
                .elements
                .without(Element::AxleRight)
                .without(Element::AxleLeft),
        ),
        CommandKind::Torque | CommandKind::Voltage => wheels.either(robot.dry.elements),
    }
}
