//! The wheels among the joints of a joint state: by descriptions of the robot, by their places, or by their names.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::description::WheelJoints;
use super::frames::{Frames, Link};
use super::places::{are_mirrored, side_of_place, turns_across};
use super::survey::{Joint, Topic};
use crate::decode::MessageSelector;
use crate::sides::{Side, side_of, words, words_of};

/// Words of joints and frames that are no driven wheels.
const NOT_DRIVEN: [&str; 26] = [
    "caster", "castor", "steer", "swivel", "gripper", "finger", "arm", "shoulder", "elbow",
    "wrist", "hand", "hip", "knee", "ankle", "leg", "foot", "thigh", "calf", "head", "neck",
    "torso", "pan", "tilt", "lift", "flipper", "camera",
];

/// Wheels that were found.
pub(super) struct Wheels {
    pub(super) selector: MessageSelector,
    /// Whether a description names them, or their names say that they are wheels.
    pub(super) are_named: bool,
}

/// The joints of the driven wheels; several on one side for skid steering. `known` are wheels that descriptions name; the first
/// whose joints are all here count. `None` if nothing tells.
pub(super) fn wheels(
    joints: &BTreeMap<String, Joint>,
    known: &[WheelJoints],
    frames: &Frames<'_>,
) -> Option<Wheels> {
    let is_here = |sides: &&WheelJoints| {
        let mut names = sides.iter().flatten();
        names.all(|name| joints.contains_key(name)) && sides.iter().all(|own| !own.is_empty())
    };
    if let Some(own) = known.iter().find(is_here) {
        return Some(found(own.clone(), true));
    }
    let candidates = candidates(joints);
    let are_named = candidates.iter().any(|name| is_called_wheel(name));
    let by_place = by_place(&candidates, frames);
    let sides = by_place.or_else(|| by_name(&candidates))?;
    Some(found(sides, are_named))
}

fn found(joints: WheelJoints, are_named: bool) -> Wheels {
    Wheels {
        selector: MessageSelector {
            joints,
            ..MessageSelector::default()
        },
        are_named,
    }
}

/// Whether the name of a joint or frame may be that of a driven wheel.
pub(super) fn is_driven(name: &str) -> bool {
    let is_other = |word: &String| {
        let is_it = |other: &&str| word == other || other.len() > 4 && word.starts_with(*other);
        NOT_DRIVEN.iter().any(is_it)
    };
    !words_of(name).iter().any(is_other)
}

fn is_called_wheel(name: &str) -> bool {
    let name = name.to_lowercase();
    name.contains("wheel") || words(&name).any(|word| word.starts_with("drive"))
}

/// The joints that may be driven wheels: those that are called so; without any, all that are not called something else.
fn candidates(joints: &BTreeMap<String, Joint>) -> Vec<&str> {
    let names = joints.keys().map(String::as_str);
    let driven: Vec<&str> = names.filter(|name| is_driven(name)).collect();
    let wheels: Vec<&str> = driven
        .iter()
        .copied()
        .filter(|name| is_called_wheel(name))
        .collect();
    if wheels.is_empty() { driven } else { wheels }
}

/// The sides by the places of the joints' frames in the base, if these mirror each other.
fn by_place(candidates: &[&str], frames: &Frames<'_>) -> Option<WheelJoints> {
    let mut sides: [Vec<(&str, Vector3<f64>)>; 2] = Default::default();
    for name in candidates {
        let link = frames.links().find(|link| are_of_one(name, link.child));
        let place = link.and_then(|link| place_of_wheel(frames, link));
        if let Some((place, side)) = place.and_then(|own| Some((own, side_of_place(&own)?))) {
            sides[usize::from(side == Side::Left)].push((name, place));
        }
    }
    let [right, left] = &sides;
    let has_mirror =
        |(_, own): &(&str, Vector3<f64>)| left.iter().any(|(_, other)| are_mirrored(own, other));
    let are_pairs = !right.is_empty() && right.len() == left.len() && right.iter().all(has_mirror);
    are_pairs.then(|| sides.map(|side| side.iter().map(|(name, _)| (*name).to_owned()).collect()))
}

/// The middle of a wheel in the base (m); `None` if the frame turns otherwise than a wheel does.
fn place_of_wheel(frames: &Frames<'_>, link: Link<'_>) -> Option<Vector3<f64>> {
    if link.seen.varies && !turns_across(frames, link, 0.0) {
        return None;
    }
    Some(frames.in_base(link)?.place.translation.vector)
}

/// Whether a joint and a frame have one name, but for words such as `joint` and `link`.
fn are_of_one(joint: &str, frame: &str) -> bool {
    let own_words = |name: &str| -> Vec<String> {
        let name = name.rsplit('/').next().unwrap_or_default().to_lowercase();
        let words = name.split(|c: char| !c.is_ascii_alphanumeric());
        let is_own = |word: &&str| !matches!(*word, "" | "joint" | "link" | "frame");
        words.filter(is_own).map(str::to_owned).collect()
    };
    let words = own_words(joint);
    !words.is_empty() && words == own_words(frame)
}

/// The sides by the names, if these tell two alike.
fn by_name(candidates: &[&str]) -> Option<WheelJoints> {
    let side = |side: Side| -> Vec<String> {
        let of_side = |name: &&&str| side_of(name) == Some(side);
        let own = candidates.iter().filter(of_side);
        own.map(|name| (*name).to_owned()).collect()
    };
    let joints = Side::BOTH.map(side);
    let [right, left] = joints.each_ref().map(Vec::len);
    // Unequal numbers: not all of them are wheels.
    (right > 0 && right == left).then_some(joints)
}

/// The joints of a topic that turn and may be wheels; empty if it has none.
pub(super) fn turning(topic: &Topic) -> Vec<&str> {
    let turns = |name: &&str| {
        let joint = topic.joints.get(*name);
        joint.is_some_and(|joint| joint.angle.vary || joint.speed.vary)
    };
    let mut names = candidates(&topic.joints);
    names.retain(turns);
    names
}

/// What to say of joint states whose joints may be wheels on unknown sides.
pub(super) fn without_sides(topic: &Topic) -> Option<String> {
    const MOST: usize = 8;
    let names = turning(topic);
    let topic = &topic.channel.topic;
    if names.len() < 2 {
        return None;
    }
    let are_unequal = names.iter().any(|name| side_of(name).is_some());
    let more = names.len().saturating_sub(MOST);
    let mut listed = names.into_iter().take(MOST).collect::<Vec<_>>().join(", ");
    if more > 0 {
        listed.push_str(&format!(" and {more} more"));
    }
    let why = match are_unequal {
        true => {
            format!("the names of its joints {listed} do not tell as many right as left wheels")
        }
        false => format!("no name of its joints {listed} tells a side"),
    };
    Some(format!(
        "{topic}: left out: {why}; give the robot's URDF or controller YAML with --robot, or map them in a file for --topics \
         (`slipstream check BAG --write-topics FILE.toml` writes one)"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(names: &[&str], known: &[WheelJoints]) -> Option<WheelJoints> {
        let joints = names
            .iter()
            .map(|name| ((*name).to_owned(), Joint::default()));
        let found = wheels(&joints.collect(), known, &Frames::of(&[]));
        found.map(|found| found.selector.joints)
    }

    #[test]
    fn names_tell_the_sides_of_wheels() {
        let pair = |right: &str, left: &str| Some([vec![right.to_owned()], vec![left.to_owned()]]);
        assert_eq!(
            sides(&["arm_left", "wheel_left_joint", "wheel_right_joint"], &[]),
            pair("wheel_right_joint", "wheel_left_joint")
        );
        assert_eq!(
            sides(&["wheel_l", "wheel_r"], &[]),
            pair("wheel_r", "wheel_l")
        );
        let with_caster = ["caster_left_wheel", "caster_right_wheel", "left", "right"];
        assert_eq!(sides(&with_caster, &[]), pair("right", "left"));
        let four = ["fl_wheel", "fr_wheel", "rl_wheel", "rr_wheel"].map(str::to_owned);
        let [fl, fr, rl, rr] = four.clone();
        let names: Vec<&str> = four.iter().map(String::as_str).collect();
        assert_eq!(sides(&names, &[]), Some([vec![fr, rr], vec![fl, rl]]));
    }

    #[test]
    fn descriptions_tell_the_sides_whatever_the_names() {
        let side = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let own: WheelJoints = [side(&["motor_2"]), side(&["motor_1"])];
        let others: WheelJoints = [side(&["motor_7"]), side(&["motor_1"])];
        let motors = ["motor_1", "motor_2", "motor_3"];
        assert_eq!(sides(&motors, &[others.clone(), own.clone()]), Some(own));
        assert!(sides(&motors, &[others]).is_none());
        // As an arm of its own name would.
        let named: WheelJoints = [side(&["base_a"]), side(&["base_b"])];
        let names = ["base_a", "base_b", "left_wheel", "right_wheel"];
        assert_eq!(sides(&names, std::slice::from_ref(&named)), Some(named));
    }

    #[test]
    fn names_that_tell_nothing_are_no_wheels() {
        assert_eq!(sides(&["joint_1", "joint_2"], &[]), None);
        assert_eq!(
            sides(&["wheel_left", "wheel_right", "wheel_left_2"], &[]),
            None
        );
        let arms = [
            "left_shoulder",
            "right_shoulder",
            "left_elbow",
            "right_elbow",
        ];
        assert_eq!(sides(&arms, &[]), None);
    }

    #[test]
    fn joints_belong_to_frames_of_their_names() {
        assert!(are_of_one("wheel_1_joint", "base/wheel_1_link"));
        assert!(!are_of_one("wheel_1", "wheel_12"));
        assert!(!are_of_one("joint", "link"));
    }
}
