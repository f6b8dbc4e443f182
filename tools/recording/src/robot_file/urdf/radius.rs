//! The radius of the wheels, from the shapes of their links.

use slipstream_bus::InputError;

use super::frames::Frames;
use super::parts::{Parts, origin};
use super::wheels::{Wheel, Wheels};
use crate::robot_file::described::{Described, Missing, in_words};
use crate::robot_file::xml::Element;

/// Radii that differ by less are the same (m).
const SAME_M: f64 = 1e-6;
/// Least share of a cylinder's axis that lies along its axle (1).
const ALONG: f64 = 0.9;
/// How far a shape may lie beside its joint before it is said (m).
const BESIDE_M: f64 = 1e-3;

/// A shape that is round about the axle.
struct Round {
    radius_m: f64,
    from: String,
}

/// Takes the radius of the rear wheels.
///
/// # Errors
/// A number of a shape that is none.
pub(super) fn take(
    parts: &Parts<'_>,
    frames: &Frames,
    wheels: &Wheels<'_>,
    described: &mut Described,
) -> Result<(), InputError> {
    let mut found = Vec::new();
    for wheel in wheels.right.iter().chain(&wheels.left) {
        found.push((*wheel, round(parts, frames, wheel, described)?));
    }
    let of = |wheel: &Wheel<'_>| {
        let own = found.iter().find(|(other, _)| other.link == wheel.link);
        own.and_then(|(_, round)| round.as_ref())
    };
    let rear = wheels.rear();
    let (radius_m, from) = match rear.map(|[right, left]| (of(&right), of(&left))) {
        Some((Some(right), Some(left))) => match same(right, left) {
            true => (right.radius_m, right.from.clone()),
            false => {
                described.note(format!(
                    "The radii of the wheels differ: right {}, left {}; their mean is taken",
                    in_words(right.radius_m),
                    in_words(left.radius_m)
                ));
                let mean_m = right.radius_m / 2.0 + left.radius_m / 2.0;
                (mean_m, format!("mean of {} and {}", right.from, left.from))
            }
        },
        Some((Some(one), None) | (None, Some(one))) => (one.radius_m, one.from.clone()),
        _ => {
            let any = wheels.right.last().or(wheels.left.last());
            described.missing.push(missing(parts, frames, any));
            return Ok(());
        }
    };
    let others = found.iter().filter_map(|(_, round)| round.as_ref());
    if wheels.right.len() > 1
        && others
            .clone()
            .any(|other| (other.radius_m - radius_m).abs() > SAME_M)
    {
        described.note("The radius is that of the rear pair; other wheels have another");
    }
    described.take_radius(radius_m, from);
    Ok(())
}

fn same(one: &Round, other: &Round) -> bool {
    (one.radius_m - other.radius_m).abs() <= SAME_M
}

/// The largest round shape of a wheel and of what is fixed to it: what it collides with, else what is seen.
fn round(
    parts: &Parts<'_>,
    frames: &Frames,
    wheel: &Wheel<'_>,
    described: &mut Described,
) -> Result<Option<Round>, InputError> {
    for kind in ["collision", "visual"] {
        let mut largest: Option<(Round, f64, f64)> = None;
        for link in parts.descendants(wheel.link) {
            let Some(own) = parts.links.get(link) else {
                continue;
            };
            for shape in own.element.all(kind) {
                let Some((name, radius_m)) = radius_of(shape)? else {
                    continue;
                };
                let frame = frames
                    .get(link)
                    .unwrap_or_else(super::transform::Transform::identity);
                let frame = frame.then(&origin(shape)?);
                // A cylinder stands along z.
                let along = match name {
                    "sphere" => 1.0,
                    _ => (frame.rotation.column(2).dot(&wheel.axle)).abs(),
                };
                let beside_m = (frame.offset - wheel.centre).dot(&wheel.axle).abs();
                if largest
                    .as_ref()
                    .is_none_or(|(known, ..)| radius_m > known.radius_m)
                {
                    let from = format!("{name} of link {}, {kind}", own.name);
                    largest = Some((Round { radius_m, from }, along, beside_m));
                }
            }
        }
        if let Some((round, along, beside_m)) = largest {
            if along < ALONG {
                described.note(format!("The {} does not lie along its axle", round.from));
            }
            if beside_m > BESIDE_M {
                described.note(format!(
                    "The {} lies {} beside {}, from which the track is",
                    round.from,
                    in_words(beside_m),
                    wheel.joint
                ));
            }
            return Ok(Some(round));
        }
    }
    Ok(None)
}

/// Name and radius of a shape, if it is round.
fn radius_of(shape: Element<'_>) -> Result<Option<(&'static str, f64)>, InputError> {
    let Some(geometry) = shape.first("geometry") else {
        return Ok(None);
    };
    for name in ["cylinder", "sphere", "capsule"] {
        if let Some(round) = geometry.first(name) {
            return Ok(round.number("radius")?.map(|radius_m| (name, radius_m)));
        }
    }
    Ok(None)
}

/// What is to be done where no shape has a radius.
fn missing(parts: &Parts<'_>, frames: &Frames, wheel: Option<&Wheel<'_>>) -> Missing {
    let remedy = "measure the radius of the wheels under load and write it";
    let Some(wheel) = wheel else {
        let problem = "no joint turns a wheel about an axis across the robot";
        return Missing::new("wheel_radius_m", problem, remedy);
    };
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
    let footprint = parts
        .links
        .iter()
        .position(|link| link.name.ends_with("base_footprint"));
    let height = footprint.and_then(|link| frames.get(link));
    match height.map(|frame| wheel.centre.z - frame.offset.z) {
        Some(height_m) if height_m > SAME_M => {
            let height = in_words(height_m);
            let hint = format!(
                "{remedy} ({height} if base_footprint lies on the floor, from there to the axle)"
            );
            Missing::new("wheel_radius_m", problem, hint)
        }
        _ => Missing::new("wheel_radius_m", problem, remedy),
    }
}
