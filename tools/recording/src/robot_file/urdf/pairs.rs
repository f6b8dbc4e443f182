//! Wheels opposite of each other: of equal radius, at mirrored places.

use super::candidates::Wheel;
use crate::robot_file::described::Described;
use crate::robot_file::words::{in_words, list};

/// How far wheels of a pair may lie apart along the robot and in height, in radii or, without radii, in tracks (1).
const APART: f64 = 0.5;
/// How much the radii of a pair may differ (1).
const RADII: f64 = 0.1;
/// Pairs of a smaller radius, as a share of that of the largest, are rollers, idlers or castors (1).
const SMALL: f64 = 0.7;

/// The pairs among the wheels of both sides, right and left, each from the front. One wheel on each side is a pair,
/// wherever they are.
pub(super) fn opposite<'a>(
    [mut right, mut left]: [Vec<Wheel<'a>>; 2],
    described: &mut Described,
) -> [Vec<Wheel<'a>>; 2] {
    for side in [&mut right, &mut left] {
        side.sort_by(|a, b| b.joint_at.x.total_cmp(&a.joint_at.x));
    }
    if right.len() == 1 && left.len() == 1 {
        return [right, left];
    }
    let mut pairs = Vec::new();
    let mut alone = Vec::new();
    for one in right {
        let apart = |other: &Wheel<'a>| distance(&one, other);
        let nearest = (0..left.len())
            .filter(|place| {
                left.get(*place)
                    .is_some_and(|other| are_opposite(&one, other))
            })
            .min_by(|a, b| apart(&left[*a]).total_cmp(&apart(&left[*b])));
        match nearest {
            Some(place) => pairs.push((one, left.remove(place))),
            None => alone.push(one),
        }
    }
    alone.extend(left);
    if !alone.is_empty() {
        let names = list(alone.iter().map(|own| own.joint));
        described.note(format!(
            "No wheel of the same size lies opposite of {names}, so the model leaves them out"
        ));
    }
    without_small(&mut pairs, described);
    pairs.into_iter().unzip::<_, _, Vec<_>, Vec<_>>().into()
}

/// Leaves out pairs that are much smaller than the largest.
fn without_small(pairs: &mut Vec<(Wheel<'_>, Wheel<'_>)>, described: &mut Described) {
    let radius = |pair: &(Wheel<'_>, Wheel<'_>)| pair.0.radius_m();
    let largest_m = pairs.iter().filter_map(radius).fold(0.0, f64::max);
    let is_small =
        |pair: &(Wheel<'_>, Wheel<'_>)| radius(pair).is_some_and(|own| own < SMALL * largest_m);
    let small: Vec<&str> = pairs
        .iter()
        .filter(|pair| is_small(pair))
        .flat_map(|(right, left)| [right.joint, left.joint])
        .collect();
    if !small.is_empty() {
        described.note(format!(
            "Smaller than the largest wheels ({}), so no wheels of the model: {}",
            in_words(largest_m),
            list(small.iter().copied())
        ));
    }
    pairs.retain(|pair| !is_small(pair));
}

fn are_opposite(right: &Wheel<'_>, left: &Wheel<'_>) -> bool {
    let size_m = match (right.radius_m(), left.radius_m()) {
        (Some(a), Some(b)) if (a - b).abs() > RADII * a.max(b) => return false,
        (Some(a), Some(b)) => a.max(b),
        _ => (left.middle().y - right.middle().y).abs(),
    };
    distance(right, left) <= APART * size_m
}

/// How far two wheels are from being opposite of each other (m).
fn distance(right: &Wheel<'_>, left: &Wheel<'_>) -> f64 {
    let apart = left.joint_at - right.joint_at;
    apart.x.hypot(apart.z)
}
