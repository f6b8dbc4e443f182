//! The wheels among the joints of a joint state, by their names or by a description of the robot.

use std::collections::BTreeMap;

use super::description::WheelJoints;
use super::survey::Joint;
use crate::decode::MessageSelector;
use crate::sides::{Side, side_of, words};

/// Parts of names of joints that are no driven wheels.
const NOT_DRIVEN: [&str; 7] = [
    "caster", "castor", "steer", "swivel", "gripper", "finger", "arm",
];

/// The joints of the driven wheels; several on one side for skid steering. Where the names do not tell, those that a
/// description of the robot has. `None` if neither does.
pub(super) fn wheels(
    joints: &BTreeMap<String, Joint>,
    described: &[WheelJoints],
) -> Option<MessageSelector> {
    named_wheels(joints).or_else(|| {
        let is_here = |sides: &&WheelJoints| {
            let mut names = sides.iter().flatten();
            names.all(|name| joints.contains_key(name)) && sides.iter().all(|own| !own.is_empty())
        };
        described.iter().find(is_here).map(|own| MessageSelector {
            joints: own.clone(),
            ..MessageSelector::default()
        })
    })
}

/// The joints of the driven wheels, if the names tell.
fn named_wheels(joints: &BTreeMap<String, Joint>) -> Option<MessageSelector> {
    let driven = |name: &&String| {
        let name = name.to_lowercase();
        !NOT_DRIVEN
            .iter()
            .any(|other| words(&name).any(|word| word.starts_with(other)))
    };
    let names: Vec<&String> = joints.keys().filter(driven).collect();
    let wheel = |name: &&String| {
        let name = name.to_lowercase();
        name.contains("wheel") || name.contains("drive")
    };
    let wheels: Vec<&String> = names.iter().copied().filter(wheel).collect();
    let candidates = if wheels.is_empty() { names } else { wheels };
    let side = |side: Side| -> Vec<String> {
        let of_side = |name: &&&String| side_of(name) == Some(side);
        candidates
            .iter()
            .filter(of_side)
            .map(|name| (*name).clone())
            .collect()
    };
    let joints = Side::BOTH.map(side);
    let [right, left] = joints.each_ref().map(Vec::len);
    // Unequal numbers: not all of them are wheels.
    (right > 0 && right == left).then_some(MessageSelector {
        joints,
        ..MessageSelector::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides(names: &[&str]) -> Option<[Vec<String>; 2]> {
        let joints = names
            .iter()
            .map(|name| ((*name).to_owned(), Joint::default()));
        wheels(&joints.collect(), &[]).map(|selector| selector.joints)
    }

    #[test]
    fn names_tell_the_sides_of_wheels() {
        let pair = |right: &str, left: &str| Some([vec![right.to_owned()], vec![left.to_owned()]]);
        assert_eq!(
            sides(&["arm_left", "wheel_left_joint", "wheel_right_joint"]),
            pair("wheel_right_joint", "wheel_left_joint")
        );
        assert_eq!(sides(&["wheel_l", "wheel_r"]), pair("wheel_r", "wheel_l"));
        assert_eq!(
            sides(&["caster_left_wheel", "caster_right_wheel", "left", "right"]),
            pair("right", "left")
        );
        let four = ["fl_wheel", "fr_wheel", "rl_wheel", "rr_wheel"].map(str::to_owned);
        let [fl, fr, rl, rr] = four.clone();
        let names: Vec<&str> = four.iter().map(String::as_str).collect();
        assert_eq!(sides(&names), Some([vec![fr, rr], vec![fl, rl]]));
    }

    #[test]
    fn a_description_tells_the_sides_where_names_do_not() {
        let joints =
            ["motor_1", "motor_2", "motor_3"].map(|name| (name.to_owned(), Joint::default()));
        let joints = BTreeMap::from(joints);
        let side = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let sides: WheelJoints = [side(&["motor_2"]), side(&["motor_1"])];
        let others: WheelJoints = [side(&["motor_7"]), side(&["motor_1"])];
        let found = wheels(&joints, &[others.clone(), sides.clone()]);
        assert_eq!(found.map(|own| own.joints), Some(sides));
        assert!(wheels(&joints, &[others]).is_none());
    }

    #[test]
    fn names_that_tell_nothing_are_no_wheels() {
        assert_eq!(sides(&["joint_1", "joint_2"]), None);
        assert_eq!(sides(&["wheel_left", "wheel_right", "wheel_left_2"]), None);
    }
}
