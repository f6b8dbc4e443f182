//! What changes while a robot drives.

use std::collections::VecDeque;

use crate::command::CommandKind;
use crate::operator::Operator;
use crate::parts::Grip;
use crate::robot::Robot;
use crate::rows::{ELEMENTS, Element, Elements};
use crate::scalar::{Pair, Scalar, Vector};
use crate::short::Short;

/// Commands that a delay line holds before it has to allocate.
const HISTORY: usize = 1024;

/// One robot's state. Its constants are in [`Robot`].
#[derive(Debug, Clone)]
pub struct State<S = f64> {
    pub(crate) body: Body<S>,
    pub(crate) mode: Mode<S>,
    pub(crate) operator: Operator<S>,
    /// What the operator was made for.
    pub(crate) made_for: OperatorKey,
    /// The short way through a step, where the mode allows it.
    pub(crate) short: Option<Short<S>>,
    /// The force under which all of redundantly held elements were last found to hold.
    pub(crate) held_under: Option<Vector<f64>>,
    /// Past commands, oldest first: from when (s) and what. Empty without a delay.
    pub(crate) history: VecDeque<(f64, Pair<S>)>,
    /// Forces from outside, beside those of the effects.
    pub(crate) load: Option<Vector<S>>,
}

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
    pub(crate) held: Elements,
    /// Elements that can slide.
    pub(crate) loose: Elements,
    /// Direction in which each element slides, or began to.
    pub(crate) direction: [Pair<S>; ELEMENTS],
    /// Friction under each driven wheel.
    pub(crate) grip: Pair<Option<Grip<S>>>,
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
pub(crate) struct OperatorKey {
    pub(crate) held: Elements,
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

impl<S: Scalar> Robot<S> {
    /// The elements that can slide under a command of `kind` on a floor of friction `grip`. Exact
    /// wheel speeds leave the axles no choice, and a robot that rolls on them none at all.
    pub(crate) fn loose(&self, kind: CommandKind, grip: Pair<Option<Grip<S>>>) -> Elements {
        let wheels = Element::WHEELS
            .into_iter()
            .zip(grip)
            .filter(|(_, grip)| grip.is_some());
        let wheels = wheels.fold(Elements::default(), |set, (wheel, _)| set.with(wheel));
        match kind {
            CommandKind::Speed if wheels.is_empty() => Elements::default(),
            CommandKind::Speed => wheels.either(
                self.dry
                    .elements
                    .without(Element::AxleRight)
                    .without(Element::AxleLeft),
            ),
            CommandKind::Torque | CommandKind::Voltage => wheels.either(self.dry.elements),
        }
    }

    /// The robot at rest with c at `pose` = [x (m), y (m), φ (rad)].
    pub fn start(&self, pose: [S; 3]) -> State<S> {
        let zero = S::constant(0.0);
        let gear = if self.drive.gap_rad.is_some() {
            Gear::Free
        } else {
            Gear::Rigid
        };
        let kind = CommandKind::Torque;
        let grip = [self.grip; 2];
        let loose = self.loose(kind, grip);
        let mode = Mode {
            kind,
            held: loose.either(Elements::WHEELS),
            loose,
            direction: [[zero; 2]; ELEMENTS],
            grip,
            gear: [gear; 2],
        };
        let contact = Contact {
            normal_n: [zero; 2],
            along_n: [zero; 2],
            across_n: zero,
        };
        let body = Body {
            pose,
            nu: Vector::from([zero; 5]),
            angle: [zero; 2],
            motor_angle: [zero; 2],
            motor_speed: [zero; 2],
            lagged: [zero; 2],
            acceleration: Vector::from([zero; 5]),
            torque: [zero; 2],
            contact,
        };
        let made_for = OperatorKey {
            held: mode.held,
            gear: mode.gear,
            kind,
            over_s: 0.0,
        };
        let operator = self.operator(&made_for);
        let delayed = self.drive.delay_s.is_some();
        let history = VecDeque::with_capacity(if delayed { HISTORY } else { 0 });
        let short = Short::new(self, &mode, &operator);
        State {
            body,
            mode,
            operator,
            made_for,
            short,
            held_under: None,
            history,
            load: None,
        }
    }
}

impl<S: Scalar> State<S> {
    /// x and y of c (m) and heading φ (rad), world frame. The heading is not wrapped.
    pub fn pose(&self) -> [S; 3] {
        self.body.pose
    }

    /// Velocity of c along and across the body (m/s) and yaw rate (rad/s).
    pub fn velocity(&self) -> [S; 3] {
        [self.body.nu[0], self.body.nu[1], self.body.nu[2]]
    }

    /// Wheel angles, right and left (rad).
    pub fn wheel_angle(&self) -> Pair<S> {
        self.body.angle
    }

    /// Wheel speeds, right and left (rad/s).
    pub fn wheel_speed(&self) -> Pair<S> {
        [self.body.nu[3], self.body.nu[4]]
    }

    /// Mean torque at each wheel in the last step (N m).
    pub fn applied_torque(&self) -> Pair<S> {
        self.body.torque
    }

    /// Acceleration of c, along and across the body, in the frame of the floor (m/s²), and yaw
    /// acceleration (rad/s²), at the end of the last step.
    pub fn acceleration(&self) -> [S; 3] {
        let (a, nu) = (&self.body.acceleration, &self.body.nu);
        [a[0] - nu[1] * nu[2], a[1] + nu[0] * nu[2], a[2]]
    }

    /// Forces between floor and driven wheels at the end of the last step.
    pub fn contact(&self) -> Contact<S> {
        self.body.contact
    }

    /// Lets an outside force act in all steps to come: along and across the body (N) and about the
    /// vertical (N m), all at c, and torques at the right and the left wheel (N m). For asking what
    /// force is missing; `None` ends it.
    pub fn set_load(&mut self, load: Option<[S; 5]>) {
        self.load = load.map(Vector::from);
    }

    /// Which of the driven wheels slide, right and left.
    pub fn slides(&self) -> [bool; 2] {
        Element::WHEELS.map(|wheel| self.mode.slides(wheel))
    }
}
