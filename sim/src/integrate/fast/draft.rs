//! Fast path for rolling at draft quality: Heun's method in surge and yaw rate under everything that may
//! act on a robot that rolls, forces from outside among it.
//!
//! It takes what [`super::rolling`] does not: effects on the command, slopes, drag, sliding dry
//! friction, voltages. Damping is linearly implicit over half a step. It equals the general step up to
//! the order of the method, not up to rounding, and serves robots of draft quality alone; it is
//! declined where an event may be near.

use crate::dynamics::applied::{applied_forces, outside_force};
use crate::dynamics::forces::add_dry_friction;
use crate::dynamics::inertia::wheel_inertias;
use crate::dynamics::motors::{damping_vector, is_damped, motor_damping, motor_torque};
use crate::integrate::floor::patch_event;
use crate::integrate::kinematics::predicted_pose;
use crate::integrate::state::State;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::CommandKind;
use crate::parts::friction_constraints::ConstraintSet;
use crate::parts::pose::advance_pose;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::{SLIP_DIRECTION_MIN, SURELY_STICKS, TURN_MAX};
use crate::robot::Robot;
use crate::robot::body::ContactForces;
use crate::robot::mode::Mode;
use crate::robot::rolling_motion::RollingMotion;

/// Accelerations over surge and yaw rate, and the forces that act besides those of the contacts.
struct DraftInstant<S> {
    acceleration: Pair<S>,
    force: Vector<S>,
}

/// What stays through a step.
struct Held<'a, S> {
    robot: &'a Robot<S>,
    motion: &'a RollingMotion<S>,
    mode: &'a Mode<S>,
    span: Pair<f64>,
    torque: Pair<S>,
    /// Forces from outside, less the damping at the start.
    force: Vector<S>,
    /// Damping of each velocity.
    damping: Vector<S>,
    inverse: [S; 3],
}

/// Advances a robot that rolls over `span` = [start (s), length (s)], or returns `false` without a
/// change where the general step has to decide.
pub(in crate::integrate) fn step<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
) -> bool {
    let Some(motion) = robot.rolling.as_ref().filter(|_| rolls(robot, &state.mode)) else {
        return false;
    };
    let held = Held::new(robot, motion, state, span, actuation);
    let (from, over_s) = (&state.body, span[1]);
    let velocity = [from.nu[0], from.nu[2]];
    let ahead =
        |rate: Pair<S>, share: f64| [0, 1].map(|i| velocity[i] + rate[i] * (share * over_s));
    let start = held.at(velocity, from.pose);
    let guess = ahead(start.acceleration, 1.0);
    let guess_nu = motion.full(guess);
    let end = held.at(guess, predicted_pose(robot, from, &guess_nu, over_s));
    let both = [0, 1].map(|i| start.acceleration[i] + end.acceleration[i]);
    let nu = motion.full(ahead(both, 0.5));
    let contact = held.contact(&end);
    let holds = held.sticks(&held.contact(&start))
        && held.sticks(&contact)
        && held.keeps_sliding(&from.nu, [&guess_nu, &nu]);
    if !holds {
        return false;
    }
    let change = nu - from.nu;
    let mean = from.nu + change * S::constant(0.5);
    let lost = motor_damping(robot, state.mode.kind);
    let mut body = *from;
    body.pose = advance_pose(body.pose, &mean, &change, over_s);
    for i in 0..2 {
        body.angle[i] += mean[3 + i] * over_s;
        body.torque[i] = held.torque[i] - lost * mean[3 + i];
    }
    body.nu = nu;
    body.lagged = actuation.lagged;
    body.acceleration = motion.full(end.acceleration);
    body.contact = contact;
    if robot.effects.has_floor && patch_event(robot, from, &body).is_some() {
        return false;
    }
    state.body = body;
    true
}

/// Whether nothing but the two driven wheels' contacts holds the robot, and they roll.
fn rolls<S: Scalar>(robot: &Robot<S>, mode: &Mode<S>) -> bool {
    let loads_matter = mode.wheel_friction[0].is_some() || robot.dry_friction.caster.is_some();
    mode.kind != CommandKind::Speed
        && mode.active == ConstraintSet::WHEELS
        && robot.actuator.gap_rad.is_none()
        && !robot.effects.has_carry
        && mode.wheel_friction[0].is_some() == mode.wheel_friction[1].is_some()
        && !(loads_matter && robot.load.transfer.is_some())
}

impl<'a, S: Scalar> Held<'a, S> {
    #[inline]
    fn new(
        robot: &'a Robot<S>,
        motion: &'a RollingMotion<S>,
        state: &'a State<S>,
        span: Pair<f64>,
        actuation: &ActuatorOutput<S>,
    ) -> Self {
        let mode = &state.mode;
        let outside = state.external_force;
        let mut force = outside.map_or(Vector::zeros(), |own| outside_force(robot, own));
        let mut damping = Vector::zeros();
        if is_damped(robot, mode.kind) {
            damping = damping_vector(robot, mode.kind, mode.gear);
            force -= damping.component_mul(&state.body.nu);
        }
        Self {
            robot,
            motion,
            mode,
            span,
            torque: motor_torque(robot, mode.kind, actuation.mean),
            force,
            damping,
            inverse: motion.inverse(&damping, 0.5 * span[1]),
        }
    }

    #[inline]
    fn at(&self, velocity: Pair<S>, pose: [S; 3]) -> DraftInstant<S> {
        let robot = self.robot;
        let nu = self.motion.full(velocity);
        let mut force = self.force + applied_forces(robot, &nu, pose, self.span, self.torque);
        if !robot.dry_friction.constraints.is_empty() {
            force = add_dry_friction(robot, self.mode, &nu, force, robot.load.caster());
        }
        let [surge, yaw] = self.motion.reduced(&force);
        let [a, b, c] = self.inverse;
        DraftInstant {
            acceleration: [a * surge + b * yaw, b * surge + c * yaw],
            force,
        }
    }

    /// Forces at the driven wheels: what the rolling motion needs beyond all other forces.
    #[inline]
    fn contact(&self, at: &DraftInstant<S>) -> ContactForces<S> {
        let (robot, over_s) = (self.robot, 0.5 * self.span[1]);
        let rate = self.motion.full(at.acceleration);
        let wheels = wheel_inertias(robot, self.mode.gear);
        let damped = |i: usize| self.damping[i] * over_s * rate[i];
        let longitudinal_n = [0, 1].map(|i| {
            let spin = wheels[i] * rate[3 + i] + damped(3 + i);
            (at.force[3 + i] - spin) / robot.radius[i]
        });
        let lateral_n =
            robot.mass * rate[1] + robot.first_moment[0] * rate[2] + damped(1) - at.force[1];
        let mut normal_n = [S::constant(0.0); 2];
        if self.mode.wheel_friction[0].is_some() {
            normal_n = robot.load.of_wheels(lateral_n);
        }
        ContactForces {
            normal_n,
            longitudinal_n,
            lateral_n,
        }
    }

    /// Whether both wheels surely stick, each under the whole lateral force.
    #[inline]
    fn sticks(&self, contact: &ContactForces<S>) -> bool {
        let lateral = contact.lateral_n.value();
        (0..2).all(|i| {
            let Some(friction) = self.mode.wheel_friction[i] else {
                return true;
            };
            let along = contact.longitudinal_n[i].value();
            let normal = contact.normal_n[i].value();
            let limit = friction.friction_static.value() * normal;
            along * along + lateral * lateral <= SURELY_STICKS * limit * limit && normal > 0.0
        })
    }

    /// Whether dry friction keeps its direction from `start` through both velocities of `then`.
    #[inline]
    fn keeps_sliding(&self, start: &Vector<S>, then: [&Vector<S>; 2]) -> bool {
        let mut constraints = self.robot.dry_friction.constraints.iter();
        constraints.all(|constraint| {
            let slip = |nu: &Vector<S>| self.robot.slip_velocity(constraint, nu).map(|v| v.value());
            let [x, y] = slip(start);
            let square = x * x + y * y;
            square > SLIP_DIRECTION_MIN * SLIP_DIRECTION_MIN
                && then.iter().all(|nu| {
                    let [along, across] = slip(nu);
                    let cross = x * across - y * along;
                    x * along + y * across > 0.0
                        && cross * cross <= TURN_MAX * square * (along * along + across * across)
                })
        })
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use crate::parts::command::Command;
    use crate::robot::Robot;

    /// A robot under much that a fit may try, with and without the fast path.
    #[test]
    fn it_follows_the_general_step() {
        let effects: [(&str, &[(&str, f64)]); 6] = [
            ("rolling_resistance", &[("coefficient", 0.01)]),
            ("viscous_drag", &[("coefficient", 0.4)]),
            ("caster_drag", &[("friction", 0.05)]),
            ("torque_speed_droop", &[("coefficient", 0.001)]),
            ("actuator_lag", &[("time_constant_s", 0.05)]),
            ("floor_slope", &[("grade", 0.02), ("downhill_rad", 1.0)]),
        ];
        for count in 0..=effects.len() {
            let mut model = RobotModel::default();
            for (id, values) in &effects[..count] {
                model = model.with(id, values);
            }
            let general = Robot::new(&model).expect("a robot");
            let draft = general.clone().draft();
            let [mut a, mut b] = [general.start([0.0; 3]), draft.start([0.0; 3])];
            for k in 0..2000 {
                let t_s = f64::from(k) * 0.005;
                let outside = Some([0.05 * t_s.sin(), 0.0, 0.002 * t_s.cos(), 1e-3, -1e-3]);
                let [right_nm, left_nm] =
                    [0.05 + 0.03 * (2.0 * t_s).sin(), 0.05 + 0.03 * t_s.cos()];
                for (robot, state) in [(&general, &mut a), (&draft, &mut b)] {
                    state.set_external_force(outside);
                    robot.step(state, t_s, 0.005, &Command::Torque { right_nm, left_nm });
                }
            }
            for (one, other) in a.pose().into_iter().zip(b.pose()) {
                assert!((one - other).abs() < 2e-4, "{count} effects: {one} {other}");
            }
            for (one, other) in a.velocity().into_iter().zip(b.velocity()) {
                assert!((one - other).abs() < 2e-4, "{count} effects: {one} {other}");
            }
        }
    }
}
