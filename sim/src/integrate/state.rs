//! What changes while a robot drives.

use std::collections::VecDeque;

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::dynamics::inertia::constrained_dynamics;
use crate::integrate::fast::FastPath;
use crate::parts::command::CommandKind;
use crate::parts::friction_elements::{ELEMENTS, Element, ElementSet};
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::robot::Robot;
use crate::robot::body::{Body, Contact, DynamicsKey, Gear, Mode, can_slide};

/// Commands that a delay line holds before it has to allocate.
const HISTORY: usize = 1024;

/// One robot's state. Its constants are in [`Robot`].
#[derive(Debug, Clone)]
pub struct State<S = f64> {
    pub(crate) body: Body<S>,
    pub(crate) mode: Mode<S>,
    pub(crate) operator: ConstrainedDynamics<S>,
    /// What the operator was made for.
    pub(crate) dynamics_key: DynamicsKey,
    /// The short way through a step, where the mode allows it.
    pub(crate) short: Option<FastPath<S>>,
    /// The force under which all of redundantly held elements were last found to hold.
    pub(crate) redundant_force: Option<Vector<f64>>,
    /// Past commands, oldest first: from when (s) and what. Empty without a delay.
    pub(crate) history: VecDeque<(f64, Pair<S>)>,
    /// Forces from outside, beside those of the effects.
    pub(crate) load: Option<Vector<S>>,
}

impl<S: Scalar> Robot<S> {
    /// Velocities at which the right and the left contact slide along the wheel, and both across
    /// it (m/s).
    pub fn slip_m_s(&self, state: &State<S>) -> [S; 3] {
        self.slip(&state.body.nu)
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
        let loose = can_slide(self, kind, grip);
        let mode = Mode {
            kind,
            held: loose.either(ElementSet::WHEELS),
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
        let dynamics_key = DynamicsKey {
            held: mode.held,
            gear: mode.gear,
            kind,
            over_s: 0.0,
        };
        let operator = constrained_dynamics(self, &dynamics_key);
        let delayed = self.drive.delay_s.is_some();
        let history = VecDeque::with_capacity(if delayed { HISTORY } else { 0 });
        let short = FastPath::new(self, &mode, &operator);
        State {
            body,
            mode,
            operator,
            dynamics_key,
            short,
            redundant_force: None,
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
    pub fn set_external_force(&mut self, load: Option<[S; 5]>) {
        self.load = load.map(Vector::from);
    }

    /// Which of the driven wheels slide, right and left.
    pub fn slides(&self) -> [bool; 2] {
        Element::WHEELS.map(|wheel| self.mode.slides(wheel))
    }
}
