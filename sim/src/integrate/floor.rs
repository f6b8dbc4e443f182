//! Friction patches: which friction is under each driven wheel, and the events of entering and
//! leaving a patch.

use super::outcome::Event;
use crate::parts::parameters::Friction;
use crate::parts::scalar::{Pair, Scalar, heading};
use crate::robot::Robot;
use crate::robot::body::Body;

/// Contact points of the driven wheels, right and left (m, world frame).
fn contact_points<S: Scalar>(robot: &Robot<S>, pose: [S; 3]) -> [Pair<S>; 2] {
    let [cos, sin] = heading(pose[2]);
    let back = robot.com_to_axle;
    [-robot.half_track, robot.half_track].map(|left| {
        [
            pose[0] - back * cos - left * sin,
            pose[1] - back * sin + left * cos,
        ]
    })
}

/// Friction under each driven wheel. Where patches overlap, the last one listed counts.
pub(super) fn friction_at<S: Scalar>(robot: &Robot<S>, pose: [S; 3]) -> Pair<Option<Friction<S>>> {
    if !robot.effects.has_floor {
        return [robot.wheel_friction; 2];
    }
    contact_points(robot, pose).map(|contact| {
        let mut friction = robot.wheel_friction;
        robot.effects.floors(contact, |depth, patch| {
            if depth.value() > 0.0 {
                friction = Some(patch);
            }
        });
        friction
    })
}

/// A wheel that enters or leaves a patch between two states; the margin is its depth inside.
pub(super) fn patch_event<S: Scalar>(
    robot: &Robot<S>,
    from: &Body<S>,
    to: &Body<S>,
) -> Option<Event<S>> {
    let (before, after) = (
        contact_points(robot, from.pose),
        contact_points(robot, to.pose),
    );
    let mut event = None;
    for (before, after) in before.into_iter().zip(after) {
        let mut patch = 0;
        robot.effects.floors(before, |depth_before, _| {
            let mut i = 0;
            robot.effects.floors(after, |depth_after, _| {
                let crosses = (depth_before.value() > 0.0) != (depth_after.value() > 0.0);
                if i == patch && crosses {
                    event = Some(Event::new(depth_before, depth_after));
                }
                i += 1;
            });
            patch += 1;
        });
    }
    event
}
