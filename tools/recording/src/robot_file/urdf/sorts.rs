//! What kind of drive a robot has, where it is not two wheels: tracks, mecanum or omni wheels, steering.

use super::candidates::{Wheel, is_track};
use super::parts::Parts;
use super::wheels::Wheels;
use crate::robot_file::drive::{Drive, Sort};

/// From so many joints below a wheel on, it has rollers.
const ROLLERS: usize = 4;
/// The sort of a robot, from its drives, the structure of its wheels, and their names.
pub(super) fn of(parts: &Parts<'_>, wheels: &Wheels<'_>, drives: &[&Drive]) -> Sort {
    let mut told = drives.iter().map(|drive| drive.sort);
    if let Some(sort) = told.find(|sort| *sort != Sort::Differential) {
        return sort;
    }
    let is_mecanum = |wheel: &Wheel<'_>| {
        let rollers = parts.descendants(wheel.link);
        let rollers = rollers.iter().flat_map(|link| parts.joints_below(*link));
        rollers.filter(|joint| joint.is_endless).count() >= ROLLERS
    };
    if wheels.all().any(is_mecanum) {
        return Sort::Mecanum;
    }
    // Of some wheels of several, omni wheels are those that are not driven.
    let mut named = wheels.all().map(|wheel| by_name(parts, wheel));
    if let Some(Some(sort)) = named.next()
        && named.all(|own| own == Some(sort))
    {
        return sort;
    }
    if !wheels.steered.is_empty() {
        return Sort::Steered;
    }
    if wheels.askew.len() >= 3 {
        return Sort::Omni;
    }
    let tracks = parts.links.iter().filter(|link| is_track(link.name));
    if tracks.count() >= 2 {
        return Sort::Tracked;
    }
    Sort::Differential
}

/// Mecanum and omni wheels by the names of joint, link and mesh.
fn by_name(parts: &Parts<'_>, wheel: &Wheel<'_>) -> Option<Sort> {
    let link = parts.links.get(wheel.link)?;
    let meshes = link.element.below("mesh");
    let mut names = meshes.filter_map(|mesh| mesh.attribute("filename"));
    let of = |name: &str| {
        let sort = Sort::of_words(name)?;
        [Sort::Mecanum, Sort::Omni].contains(&sort).then_some(sort)
    };
    of(wheel.joint)
        .or_else(|| of(link.name))
        .or_else(|| names.find_map(of))
}
