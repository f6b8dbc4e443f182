//! Radius and track of the wheels, from their shapes and joints, and what is odd about them.

use super::candidates::Wheel;
use super::frames::Frames;
use super::parts::Parts;
use super::wheels::Wheels;
use crate::robot_file::described::{Described, Missing};
use crate::robot_file::drive::Length;
use crate::robot_file::lengths::{Geometry, MEASURE_RADIUS, MEASURE_TRACK, ONE_PAIR};
use crate::robot_file::words::{in_words, list};

/// Lengths that differ by less are the same (m).
const SAME_M: f64 = 1e-6;
/// How far the axle may lie from the base before it is said (m).
const AXLE_M: f64 = 1e-3;
/// How far a shape may lie beside its joint before it is said (m).
const BESIDE_M: f64 = 1e-3;

/// What the wheels tell.
pub(super) fn of_wheels(
    parts: &Parts<'_>,
    frames: &Frames,
    wheels: &Wheels<'_>,
    described: &mut Described,
) -> Geometry {
    let Some([right, left]) = wheels.rear() else {
        let problem = match wheels.steered.is_empty() {
            true => "no joint turns a wheel about an axis across the robot".to_owned(),
            false => format!(
                "all of its wheels steer: {}",
                list(wheels.steered.iter().copied())
            ),
        };
        let missing = |key, remedy| Missing::new(key, &problem, remedy);
        return Geometry {
            missing: vec![
                missing("wheel_radius_m", MEASURE_RADIUS),
                missing("half_track_m", MEASURE_TRACK),
            ],
            ..Geometry::default()
        };
    };
    let mut geometry = Geometry {
        radius: radius([right, left], wheels, described),
        missing: vec![missing_radius(parts, frames, right)],
        ..Geometry::default()
    };
    let half_m = half_track([right, left]);
    if let (Some(of_right), Some(of_left)) = (&right.round, &left.round) {
        let is_beside = [right, left]
            .iter()
            .any(|own| own.beside_m().abs() > BESIDE_M);
        let from = match is_beside {
            true => format!(
                "y of the middles of {} and of {}",
                of_right.from, of_left.from
            ),
            false => of_joints([right, left]),
        };
        geometry.half_track = Some(Length::new(half_m, from));
    } else {
        geometry.half_track_of_joints = Some(Length::new(half_m, of_joints([right, left])));
    }
    note_shapes(wheels, described);
    note_pairs(wheels, described);
    note_offsets([right, left], described);
    note_axle(wheels, described);
    geometry
}

fn of_joints([right, left]: [&Wheel<'_>; 2]) -> String {
    format!("y of the origins of {} and {}", right.joint, left.joint)
}

/// Half of the distance across the robot (m).
fn half_track([right, left]: [&Wheel<'_>; 2]) -> f64 {
    // Halves first: the sum of the largest numbers would not be finite.
    left.middle().y / 2.0 - right.middle().y / 2.0
}

/// The radius of the rear wheels.
fn radius(
    [right, left]: [&Wheel<'_>; 2],
    wheels: &Wheels<'_>,
    described: &mut Described,
) -> Option<Length> {
    let length = match (&right.round, &left.round) {
        (Some(right), Some(left)) if (right.radius_m - left.radius_m).abs() > SAME_M => {
            described.note(format!(
                "The radii of the wheels differ: right {}, left {}; their mean is taken",
                in_words(right.radius_m),
                in_words(left.radius_m)
            ));
            let mean_m = right.radius_m / 2.0 + left.radius_m / 2.0;
            Length::new(mean_m, format!("mean of {} and {}", right.from, left.from))
        }
        (Some(one), _) | (None, Some(one)) => Length::new(one.radius_m, one.from.clone()),
        (None, None) => return None,
    };
    let mut others = wheels.all().filter_map(Wheel::radius_m);
    if wheels.right.len() > 1 && others.any(|other| (other - length.value_m).abs() > SAME_M) {
        described.note("The radius is that of the rear pair; other wheels have another");
    }
    Some(length)
}

/// Shapes that do not stand as wheels do, or not at their joints.
fn note_shapes(wheels: &Wheels<'_>, described: &mut Described) {
    for round in wheels.all().filter_map(|wheel| wheel.round.as_ref()) {
        if !round.is_along {
            described.note(format!("The {} does not lie along its axle", round.from));
        }
    }
    let beside = wheels
        .all()
        .filter(|wheel| wheel.beside_m().abs() > BESIDE_M);
    let beside =
        beside.map(|wheel| format!("{} of {}", in_words(wheel.beside_m().abs()), wheel.joint));
    let beside: Vec<String> = beside.collect();
    if !beside.is_empty() {
        described.note(format!(
            "The shapes of wheels lie beside their joints, and the track is that of the shapes: {}",
            list(beside.into_iter())
        ));
    }
}

/// Of more wheels than the model has.
fn note_pairs(wheels: &Wheels<'_>, described: &mut Described) {
    let pairs = wheels.right.iter().zip(&wheels.left);
    let tracks: Vec<f64> = pairs
        .map(|(right, left)| half_track([right, left]))
        .collect();
    let Some((rear, others)) = tracks.split_last().filter(|(_, others)| !others.is_empty()) else {
        return;
    };
    described.note(format!("{} wheels: {ONE_PAIR}", wheels.all().count()));
    if others.iter().any(|own| (own - rear).abs() > SAME_M) {
        let others = list(others.iter().map(|own| in_words(*own)));
        described.note(format!(
            "The track is that of the rear pair; from the front, half_track_m of the others: {others}"
        ));
    }
}

/// Wheels that do not lie opposite of each other.
fn note_offsets([right, left]: [&Wheel<'_>; 2], described: &mut Described) {
    let [to_left, to_right] = [left.middle().y, -right.middle().y];
    if (to_left - to_right).abs() > SAME_M {
        described.note(format!(
            "The wheels lie {} to the left and {} to the right of the base's middle: half of their distance is taken",
            in_words(to_left),
            in_words(to_right)
        ));
    }
    let ahead_m = left.joint_at.x - right.joint_at.x;
    if ahead_m.abs() > SAME_M {
        described.note(format!(
            "{} lies {} ahead of {}, which the model leaves out",
            left.joint,
            in_words(ahead_m),
            right.joint
        ));
    }
}

/// An axle, or a middle of several, that does not lie at the base.
fn note_axle(wheels: &Wheels<'_>, described: &mut Described) {
    let count = wheels.all().count().max(1) as f64;
    let axle_m = wheels
        .all()
        .map(|wheel| wheel.joint_at.x / count)
        .sum::<f64>();
    if axle_m.abs() > AXLE_M {
        described.note(format!(
            "The axle lies at x = {} of the base: poses of the base are those of another point than the axle's middle",
            in_words(axle_m)
        ));
    }
}

/// What is to be done where no shape has a radius.
fn missing_radius(parts: &Parts<'_>, frames: &Frames, wheel: &Wheel<'_>) -> Missing {
    let links = parts.descendants(wheel.link);
    let has = |name: &'static str| {
        let mut links = links.iter().filter_map(|link| parts.links.get(*link));
        links.any(|link| link.element.below(name).next().is_some())
    };
    let shape = match () {
        () if has("mesh") => "is a mesh",
        () if has("box") => "is a box",
        () => "has no shape",
    };
    let problem = format!("the wheel of {} {shape}", wheel.joint);
    let mut named = parts.links.iter();
    let footprint = named.position(|link| link.name.ends_with("base_footprint"));
    let floor = footprint.and_then(|link| frames.get(link));
    let remedy = match floor.map(|floor| wheel.joint_at.z - floor.offset.z) {
        Some(height_m) if height_m > SAME_M => format!(
            "{MEASURE_RADIUS} ({} if base_footprint lies on the floor, from there to the axle)",
            in_words(height_m)
        ),
        _ => MEASURE_RADIUS.to_owned(),
    };
    Missing::new("wheel_radius_m", problem, remedy)
}
