//! Friction margin: how far sticking elements are from sliding.

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::dynamics::forces::Forces;
use crate::parts::friction_elements::{Element, ElementSet};
use crate::parts::scalar::{Pair, Scalar, length, smaller};
use crate::parts::tolerances::{LIMIT_SLACK, SURELY_STICKS};
use crate::robot::Robot;
use crate::robot::body::Mode;

/// How far held elements are from sliding, as a share of their limits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margin<S> {
    /// The least of them.
    pub(super) least: S,
    /// Those that do not hold.
    pub(super) broken: ElementSet,
}

impl<S: Scalar> Margin<S> {
    fn new(least: S, element: Element) -> Self {
        Self {
            least,
            broken: ElementSet::default(),
        }
        .and(least, ElementSet::default().with(element))
    }

    fn and(self, own: S, elements: ElementSet) -> Self {
        let broken = if own.value() < -LIMIT_SLACK {
            elements
        } else {
            ElementSet::default()
        };
        Self {
            least: smaller(self.least, own),
            broken: self.broken.either(broken),
        }
    }
}

/// The margin of the held elements against sliding.
pub(crate) fn friction_margin<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    operator: &ConstrainedDynamics<S>,
    balance: &Forces<S>,
) -> Option<Margin<S>> {
    let held = mode.held.both(mode.loose);
    if held.is_empty() {
        return None;
    }
    let mut least = wheel_margin(mode, balance);
    if operator.redundant {
        return least;
    }
    for element in held.both(robot.dry.elements).iter() {
        let [right, left] = balance.contact.normal_n;
        let limit = robot.dry_limit(element, robot.load.total - right - left);
        let [along, across] = match *element.rows() {
            [row] => [operator.multiplier(row, &balance.force), S::constant(0.0)],
            [along, across, ..] => {
                [along, across].map(|row| operator.multiplier(row, &balance.force))
            }
            [] => [S::constant(0.0); 2],
        };
        let own = share(limit, length([along, across]));
        let alone = ElementSet::default().with(element);
        least = Some(least.map_or(Margin::new(own, element), |least| least.and(own, alone)));
    }
    least
}

/// The driven wheels: each one's force stays inside its cone. While both stick, the lateral
/// force may be shared in any way that keeps both inside.
fn wheel_margin<S: Scalar>(mode: &Mode<S>, balance: &Forces<S>) -> Option<Margin<S>> {
    let contact = &balance.contact;
    let limit = |i: usize| {
        let held = mode.held.both(mode.loose).has(Element::WHEELS[i]);
        let grip = mode.grip[i].filter(|_| held)?;
        Some(grip.friction_static * contact.normal_n[i])
    };
    // beside a wheel that cannot slide, that one takes what goes across
    let alone = |i: usize| {
        let shared = mode.loose.has(Element::WHEELS[1 - i]);
        let across = if shared {
            contact.across_n
        } else {
            S::constant(0.0)
        };
        length([contact.along_n[i], across])
    };
    match [limit(0), limit(1)] {
        [None, None] => None,
        [Some(right), Some(left)] => {
            let limits = [right, left];
            let across = contact.across_n * contact.across_n;
            let safe = |i: usize| {
                let along = contact.along_n[i] * contact.along_n[i];
                (along + across).value() <= (limits[i] * limits[i]).value() * SURELY_STICKS
            };
            if safe(0) && safe(1) {
                // each could carry all that goes across: no need to know how much is left
                return None;
            }
            let along = [0, 1].map(|i| share(limits[i], contact.along_n[i].abs()));
            let left = ElementSet::default().with(Element::WheelLeft);
            let margin = Margin::new(along[0], Element::WheelRight).and(along[1], left);
            if margin.least.value() <= 0.0 {
                return Some(margin);
            }
            let spare = [0, 1]
                .map(|i| (limits[i] * limits[i] - contact.along_n[i] * contact.along_n[i]).sqrt());
            let across = share(spare[0] + spare[1], contact.across_n.abs());
            Some(margin.and(across, first_to_break(mode, spare)))
        }
        [Some(own), None] => Some(Margin::new(share(own, alone(0)), Element::WheelRight)),
        [None, Some(own)] => Some(Margin::new(share(own, alone(1)), Element::WheelLeft)),
    }
}

/// Which wheels break away when what goes across is too much for both together. Where friction
/// weakens, that is the one with less `room` (N) beside its longitudinal force: the other then has to
/// hold what is across under static friction, and may.
fn first_to_break<S: Scalar>(mode: &Mode<S>, room: Pair<S>) -> ElementSet {
    let [right, left] = room.map(|room| room.value());
    let first = usize::from(left < right);
    let weakens = mode.grip[first]
        .is_some_and(|grip| grip.friction_static.value() > grip.friction_kinetic.value());
    if weakens && right != left {
        ElementSet::default().with(Element::WHEELS[first])
    } else {
        ElementSet::WHEELS
    }
}

/// How much of `limit` is left, as a share of it. A limit of nothing breaks under any force.
fn share<S: Scalar>(limit: S, used: S) -> S {
    if limit.value() > 0.0 {
        (limit - used) / limit
    } else {
        -used
    }
}
