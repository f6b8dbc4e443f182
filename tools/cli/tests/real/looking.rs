//! Before anything moves: what is said of robots that are heard, and of those that are not.

use crate::common::slipstream;
use crate::lab::Lab;

const LOOK: [&str; 6] = ["run", "platoon", "--clock", "wall", "--real", "robots.toml"];

#[test]
fn without_arm_nothing_is_told_and_robots_are_listed() {
    let mut lab = Lab::of(&["", ""]);
    let said = lab.succeeds(&LOOK);
    assert!(
        said.contains("Nothing has moved: add --arm to drive."),
        "{said}"
    );
    let row = said.lines().find(|line| line.starts_with("r2")).unwrap();
    assert!(row.contains("Hz"), "{said}");
    lab.end_boxes();
    let seen = crate::common::read_json(&lab.file("r1.json"));
    assert_eq!(seen["commands"], 0);
}

#[test]
fn a_robot_that_is_not_there_is_said_before_any_moves() {
    let mut lab = Lab::of(&["", ""]);
    let robots = std::fs::read_to_string(lab.file("robots.toml")).unwrap();
    let wrong = robots.replace("tb2/joint_states", "tb2/joint_angles");
    std::fs::write(lab.file("robots.toml"), wrong).unwrap();
    let looked = lab.runs(&LOOK);
    let said = String::from_utf8_lossy(&looked.stdout);
    assert_eq!(looked.status.code(), Some(1), "{said}");
    assert!(
        said.contains("r2: nothing came from /tb2/joint_angles"),
        "{said}"
    );
    let run = lab.runs(&[&LOOK[..], &["--arm", "--no-recording"]].concat());
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(1), "{said}");
    assert!(
        said.contains("nothing came from /tb2/joint_angles for 10 s"),
        "{said}"
    );
    lab.end_boxes();
    for robot in ["r1.json", "r2.json"] {
        assert_eq!(crate::common::read_json(&lab.file(robot))["commands"], 0);
    }
}

#[test]
fn fewer_robots_than_the_lab_has_may_drive() {
    let lab = Lab::of(&["", ""]);
    let said = lab.succeeds(&[&LOOK[..], &["--robots", "1"]].concat());
    assert!(said.contains("r1") && !said.contains("r2"), "{said}");
}

#[test]
fn what_cannot_be_driven_is_refused_in_one_line() {
    let lab = Lab::of(&[""]);
    for (arguments, expected) in [
        (
            &["run", "platoon", "--real", "robots.toml"][..],
            "add --clock wall",
        ),
        (
            &["run", "single", "--clock", "wall", "--real", "robots.toml"],
            "open_loop.enabled",
        ),
        (&["run", "--clock", "wall", "--real", "no.toml"], "no.toml"),
        (
            &[
                "run",
                "--clock",
                "wall",
                "--real",
                "robots.toml",
                "--robots",
                "2",
            ],
            "fewer --robots",
        ),
        (&["robot-in-a-box", "robots.toml", "r7"], "give one of r1"),
    ] {
        let output = slipstream(lab.folder(), arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains(expected) && said.lines().count() == 1,
            "{said}"
        );
    }
}
