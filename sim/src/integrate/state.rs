//! State of one robot: everything that changes while it drives.

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::dynamics::inertia::constrained_dynamics;
use crate::integrate::carried::carried_at_rest;
use crate::integrate::fast::FastPath;
use crate::integrate::floor::friction_at;
use crate::parts::command::CommandKind;
use crate::parts::command_history::CommandHistory;
use crate::parts::friction_constraints::{ConstraintSet, FRICTION_CONSTRAINTS, FrictionConstraint};
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::robot::Robot;
use crate::robot::body::{Body, ContactForces};
use crate::robot::mode::{DynamicsKey, Gear, Mode, frictional_constraints};

/// One robot's state. Its constants are in [`Robot`], which starts and steps it.
#[derive(Debug, Clone)]
pub struct State<S = f64> {
    pub(crate) body: Body<S>,
    pub(crate) mode: Mode<S>,
    /// Constrained dynamics of the current mode.
    pub(crate) dynamics: ConstrainedDynamics<S>,
    /// What `dynamics` were computed for.
    pub(crate) dynamics_key: DynamicsKey,
    /// The fast path through a step, if the mode has one.
    pub(crate) fast_path: Option<FastPath<S>>,
    /// The applied force for which a redundant active set was last solved.
    pub(crate) redundant_force: Option<Vector<f64>>,
    /// Past commands; empty without a delay.
    pub(crate) history: CommandHistory<S>,
    /// Force from outside, besides those of effects.
    pub(crate) external_force: Option<Vector<S>>,
}

impl<S: Scalar> Robot<S> {
    /// The robot at rest at `pose`: x and y of c (m) and heading φ (rad), world frame.
    pub fn start(&self, pose: [S; 3]) -> State<S> {
        let gear = if self.actuator.gap_rad.is_some() {
            Gear::Free
        } else {
            Gear::Rigid
        };
        let kind = CommandKind::Torque;
        let wheel_friction = friction_at(self, pose);
        let frictional = frictional_constraints(self, kind, wheel_friction);
        let mode = Mode {
            kind,
            active: frictional.union(ConstraintSet::WHEELS),
            frictional,
            direction: [[S::constant(0.0); 2]; FRICTION_CONSTRAINTS],
            wheel_friction,
            gear: [gear; 2],
        };
        let dynamics_key = mode.dynamics_key(mode.active, 0.0);
        let dynamics = constrained_dynamics(self, &dynamics_key);
        let fast_path = FastPath::new(self, &mode, &dynamics);
        let mut body = Body::at_rest(pose);
        body.carried = carried_at_rest(self, &body);
        State {
            body,
            mode,
            dynamics,
            dynamics_key,
            fast_path,
            redundant_force: None,
            history: CommandHistory::new(self.actuator.delay_s.is_some()),
            external_force: None,
        }
    }

    /// Slip velocities of the driven wheels' contacts (m/s): longitudinal right and left, ρ̇ − r
    /// θ̇, and the lateral one of both, η̇ (Eq. 2).
    pub fn slip_m_s(&self, state: &State<S>) -> [S; 3] {
        self.wheel_slip(&state.body.nu)
    }
}

impl<S: Scalar> State<S> {
    /// x and y of c (m) and heading φ (rad), world frame. The heading is not wrapped.
    pub fn pose(&self) -> [S; 3] {
        self.body.pose
    }

    /// Velocity of c along and across the body (m/s) and yaw rate (rad/s).
    pub fn velocity(&self) -> [S; 3] {
        self.body.velocity()
    }

    /// Wheel angles θ, right and left (rad).
    pub fn wheel_angle(&self) -> Pair<S> {
        self.body.angle
    }

    /// Wheel speeds θ̇, right and left (rad/s).
    pub fn wheel_speed(&self) -> Pair<S> {
        [self.body.nu[3], self.body.nu[4]]
    }

    /// Mean torque at each wheel over the last step, right and left (N m).
    pub fn applied_torque(&self) -> Pair<S> {
        self.body.torque
    }

    /// Acceleration of c relative to the floor, resolved along and across the body (m/s²), and yaw
    /// acceleration (rad/s²), at the end of the last step.
    pub fn acceleration(&self) -> [S; 3] {
        let (a, nu) = (self.body.velocity_rate(), self.body.velocity());
        [a[0] - nu[1] * nu[2], a[1] + nu[0] * nu[2], a[2]]
    }

    /// Forces between the floor and the driven wheels at the end of the last step.
    pub fn contact_forces(&self) -> ContactForces<S> {
        self.body.contact
    }

    /// Whether each of the driven wheels slides, right and left.
    pub fn slides(&self) -> [bool; 2] {
        FrictionConstraint::WHEELS.map(|wheel| self.mode.slides(wheel))
    }

    /// Whether each motor and its wheel turn as one, right and left: true without backlash.
    pub fn engaged(&self) -> [bool; 2] {
        self.mode.gear.map(Gear::is_engaged)
    }

    /// Sets a constant external force for all steps to come; `None` removes it. The five entries
    /// are forces along and across the body (N) and the moment about the vertical (N m), all at c,
    /// and torques at the right and the left wheel (N m). Used to probe which force a model lacks.
    pub fn set_external_force(&mut self, force: Option<[S; 5]>) {
        self.external_force = force.map(Vector::from);
    }
}
