//! Forces at one instant: what the floor answers to a motion and to the forces that act on it.

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::effects::{Motion, Wrench};
use crate::parts::friction_elements::{ACROSS, ALONG_LEFT, ALONG_RIGHT, Element, ElementSet};
use crate::parts::scalar::{Pair, Scalar, Vector, clamp, heading, length};
use crate::parts::tolerances::SLIP_DIRECTION_MIN;
use crate::robot::Robot;
use crate::robot::body::{Contact, Mode};

/// All forces on a robot at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Forces<S> {
    /// Generalised force without the multipliers of held rows.
    pub(crate) force: Vector<S>,
    /// Forces at the driven wheels.
    pub(crate) contact: Contact<S>,
}

/// Forces that do not depend on what sticks or slides: inertial forces of Eq. 3 in the body
/// frame, weight on a slope, effects, and the torque of the motors.
#[inline]
pub(crate) fn applied_forces<S: Scalar>(
    robot: &Robot<S>,
    nu: &Vector<S>,
    yaw: S,
    span: Pair<f64>,
    torque: Pair<S>,
) -> Vector<S> {
    let (m, [sx, sy]) = (robot.mass, robot.moment);
    let (u, w, rate) = (nu[0], nu[1], nu[2]);
    // m13, m23 and the φ̇² terms of Eq. 3, turned into the body frame
    let along = (m * w + sx * rate) * rate;
    let across = (sy * rate - m * u) * rate;
    let moment = -(sx * u + sy * w) * rate;
    let mut wrench = Wrench {
        along,
        across,
        moment,
    };
    if robot.pull.is_some() || robot.effects.has_force {
        external_forces(robot, nu, yaw, span, &mut wrench);
    }
    Vector::from([
        wrench.along,
        wrench.across,
        wrench.moment,
        torque[0],
        torque[1],
    ])
}

/// Weight on a slope and the forces of effects.
fn external_forces<S: Scalar>(
    robot: &Robot<S>,
    nu: &Vector<S>,
    yaw: S,
    span: Pair<f64>,
    wrench: &mut Wrench<S>,
) {
    let [cos, sin] = heading(yaw);
    if let Some([x, y]) = robot.pull {
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        let [sx, sy] = robot.moment;
        wrench.along += robot.mass * along;
        wrench.across += robot.mass * across;
        wrench.moment += sx * across - sy * along;
    }
    let [t_s, over_s] = span;
    let velocity = [nu[0], nu[1]];
    let motion = Motion {
        t_s,
        over_s,
        heading: [cos, sin],
        velocity,
    };
    robot.effects.force(&motion, wrench);
}

/// Adds dry friction of moving elements and the forces at the driven wheels to `applied`. `forced`
/// is the surge acceleration that no force of these gives (m/s²).
#[inline]
pub(crate) fn forces_at<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    operator: &ConstrainedDynamics<S>,
    nu: &Vector<S>,
    applied: Vector<S>,
    forced: S,
) -> Forces<S> {
    if robot.dry.elements.is_empty() {
        return wheel_forces(robot, mode, operator, nu, applied, forced);
    }
    if robot.load.transfer.is_none() {
        let caster = robot.load.total - robot.load.driven;
        let force = add_dry_friction(robot, mode, nu, applied, caster);
        return wheel_forces(robot, mode, operator, nu, force, forced);
    }
    // Caster friction and load transfer act on each other: a contraction by about μ h / (d + e)
    let mut caster = robot.load.total - robot.load.driven;
    loop {
        let force = add_dry_friction(robot, mode, nu, applied, caster);
        let balance = wheel_forces(robot, mode, operator, nu, force, forced);
        let [right, left] = balance.contact.normal_n;
        let next = robot.load.total - right - left;
        let change = (next - caster).value().abs();
        caster = next;
        if change <= 1e-13 * robot.load.total.value() || change.is_nan() {
            return balance;
        }
    }
}

/// Adds the friction of moving axles, body and caster.
fn add_dry_friction<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    nu: &Vector<S>,
    mut force: Vector<S>,
    caster_normal: S,
) -> Vector<S> {
    for element in robot.dry.elements.iter() {
        if !mode.slides(element) {
            continue;
        }
        let limit = robot.dry_limit(element, caster_normal);
        let direction = sliding_direction(robot, mode, element, nu);
        for (&row, part) in element.rows().iter().zip(direction) {
            force -= robot.row(row) * (limit * part);
        }
    }
    force
}

/// Unit direction in which a sliding element slides.
#[inline]
pub(crate) fn sliding_direction<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    element: Element,
    nu: &Vector<S>,
) -> Pair<S> {
    let mut seen = robot.seen(element, nu);
    if mode.is_led(element) {
        seen[1] = S::constant(0.0);
    }
    let size = length(seen);
    if size.value() <= SLIP_DIRECTION_MIN {
        return mode.direction[element as usize];
    }
    let per = size.recip();
    [seen[0] * per, seen[1] * per]
}

/// Normal forces, coupled with the contact forces of the same instant, and those forces.
#[inline]
fn wheel_forces<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    operator: &ConstrainedDynamics<S>,
    nu: &Vector<S>,
    force: Vector<S>,
    forced: S,
) -> Forces<S> {
    let zero = S::constant(0.0);
    let held = !mode.held.both(ElementSet::WHEELS).is_empty();
    let (mut along, mut across) = ([zero; 2], zero);
    if held {
        along = [
            operator.multiplier(ALONG_RIGHT, &force),
            operator.multiplier(ALONG_LEFT, &force),
        ];
        across = operator.multiplier(ACROSS, &force);
    }
    let slides = [
        mode.slides(Element::WheelRight),
        mode.slides(Element::WheelLeft),
    ];
    if slides == [false; 2] && robot.load.transfer.is_none() {
        let unneeded = mode.grip == [None; 2] && robot.dry.caster.is_none();
        let normal_n = if unneeded {
            [zero; 2]
        } else {
            let shift = robot.load.lateral * across + robot.load.offset;
            split_normal(robot.load.driven, shift)
        };
        let contact = Contact {
            normal_n,
            along_n: along,
            across_n: across,
        };
        return Forces { force, contact };
    }
    // Force per newton of normal force at each sliding wheel, and what held rows answer to it
    let mut per_newton = [[zero; 2]; 2];
    let mut pull = [Vector::from([zero; 5]); 2];
    let mut responds = [zero; 2];
    for i in 0..2 {
        if let (true, Some(grip)) = (slides[i], mode.grip[i]) {
            let [x, y] = sliding_direction(robot, mode, Element::WHEELS[i], nu);
            let friction = -grip.friction_kinetic;
            per_newton[i] = [friction * x, friction * y];
            pull[i] = contact_force(robot, i, per_newton[i]);
            responds[i] = per_newton[i][1];
            if held {
                responds[i] += operator.multiplier(ACROSS, &pull[i]);
            }
        }
    }
    let surge = robot.load.transfer.map(|transfer| {
        let rate = |f: &Vector<S>| operator.acceleration.row(0).transpose().dot(f);
        (
            transfer,
            forced + rate(&force) - nu[1] * nu[2],
            [rate(&pull[0]), rate(&pull[1])],
        )
    });
    let normal = normal_forces(robot, across, responds, surge);
    let force = force + pull[0] * normal[0] + pull[1] * normal[1];
    let mut along_n = [per_newton[0][0] * normal[0], per_newton[1][0] * normal[1]];
    if held {
        along_n[0] += operator.multiplier(ALONG_RIGHT, &force);
        along_n[1] += operator.multiplier(ALONG_LEFT, &force);
    }
    let across_n = across + responds[0] * normal[0] + responds[1] * normal[1];
    Forces {
        force,
        contact: Contact {
            normal_n: normal,
            along_n,
            across_n,
        },
    }
}

/// The generalised force of a force [along, across] at the contact of wheel `i`.
#[inline]
fn contact_force<S: Scalar>(robot: &Robot<S>, i: usize, [along, across]: Pair<S>) -> Vector<S> {
    let zero = S::constant(0.0);
    let lever = robot.half_track * along;
    let moment = if i == 0 { lever } else { -lever } - robot.com_to_axle * across;
    let spin = -robot.radius[i] * along;
    let spin = if i == 0 { [spin, zero] } else { [zero, spin] };
    Vector::from([along, across, moment, spin[0], spin[1]])
}

/// N_r and N_l (Eq. 4 to 6) when the lateral force is `across` + Σ `per_normal` N and, with
/// load transfer, the longitudinal acceleration is affine in N likewise.
#[inline]
fn normal_forces<S: Scalar>(
    robot: &Robot<S>,
    across: S,
    per_normal: Pair<S>,
    surge: Option<(S, S, Pair<S>)>,
) -> Pair<S> {
    let zero = S::constant(0.0);
    let half = |[a, b]: Pair<S>| ((a + b) * 0.5, (a - b) * 0.5);
    let (sum, difference) = half(per_normal);
    let lateral = robot.load.lateral;
    // N_r − N_l = shift + tilt (N_r + N_l)
    let own = (S::constant(1.0) - lateral * difference).recip();
    let shift = (lateral * across + robot.load.offset) * own;
    let tilt = lateral * sum * own;
    let driven = surge.map_or(robot.load.driven, |(transfer, free, per_normal)| {
        let (sum, difference) = half(per_normal);
        let rest = robot.load.driven + transfer * (free + difference * shift);
        let whole = rest / (S::constant(1.0) - transfer * (sum + difference * tilt));
        clamp(whole, zero, robot.load.total)
    });
    split_normal(driven, shift + tilt * driven)
}

/// N_r and N_l of this sum and difference. A wheel that would lift carries nothing.
#[inline]
fn split_normal<S: Scalar>(sum: S, difference: S) -> Pair<S> {
    let apart = clamp(difference, -sum, sum);
    [(sum + apart) * 0.5, (sum - apart) * 0.5]
}
