//! Controllers as people write them.

use std::path::Path;

use crate::robot_file::{Described, parse};

fn described(text: &str) -> Described {
    parse(text, Path::new("c.yaml")).unwrap()
}

fn error(text: &str) -> String {
    let described = parse(text, Path::new("c.yaml"));
    described
        .and_then(|own| own.model())
        .unwrap_err()
        .to_string()
}

/// Radius and half track of a file that has both (m).
fn lengths(text: &str) -> [f64; 2] {
    let body = described(text).model().unwrap().robot;
    [body.wheel_radius_m, body.half_track_m]
}

/// A controller with these lines of parameters.
fn controller(lines: &[&str]) -> String {
    format!("diff:\n  ros__parameters:\n    {}\n", lines.join("\n    "))
}

#[test]
fn multipliers_of_track_and_both_wheels_change_the_lengths() {
    let text = controller(&[
        "wheel_separation: 0.4",
        "wheel_radius: 0.1",
        "wheel_separation_multiplier: 1.25",
        "left_wheel_radius_multiplier: 0.5",
        "right_wheel_radius_multiplier: 0.5",
    ]);
    let model = described(&text).model().unwrap();
    assert_eq!(model.robot.half_track_m, 0.25);
    assert_eq!(model.robot.wheel_radius_m, 0.05);
    assert_eq!(model.effects, []);
}

#[test]
fn wheels_that_differ_are_an_effect() {
    let text = controller(&[
        "wheel_separation: 0.4",
        "wheel_radius: 0.1",
        "left_wheel_radius_multiplier: 0.75",
        "right_wheel_radius_multiplier: 1.25",
    ]);
    let own = described(&text);
    let model = own.model().unwrap();
    assert_eq!(model.robot.wheel_radius_m, 0.1);
    let scales = slipstream_bus::EffectSpec::new(
        "wheel_radius",
        &[("right_scale", 1.25), ("left_scale", 0.75)],
    );
    assert_eq!(model.effects, [scales]);
    assert!(own.notes[0].contains("differ"));
    assert_eq!(own.taken[3].key, "effects.wheel_radius.left_scale");
}

#[test]
fn the_controller_of_ros_1_has_other_names() {
    let text = "base_controller:\n  type: \"diff_drive_controller/DiffDriveController\"\n  left_wheel: 'l'\n  \
                right_wheel: ['r1', 'r2']\n  wheel_radius: 0.11\n  wheel_radius_multiplier: 2\n  \
                wheel_separation: 0.54\n";
    let own = described(text);
    assert_eq!(
        own.wheel_joints,
        [vec!["r1".to_owned(), "r2".to_owned()], vec!["l".to_owned()]]
    );
    assert_eq!(own.model().unwrap().robot.wheel_radius_m, 0.22);
    assert_eq!(own.notes.len(), 1);
    let text = text.replace("  wheel_separation: 0.54\n", "");
    let problem = described(&text).model().unwrap_err().problem;
    assert_eq!(
        problem,
        "gives no half_track_m: base_controller has no wheel_separation"
    );
}

#[test]
fn errors_name_line_key_and_remedy() {
    let ok = "wheel_separation: 0.4";
    let cases = [
        (
            controller(&["x: 1"]),
            "c.yaml: has no controller with wheel_separation; give a robot.toml",
        ),
        (
            controller(&["wheel_separation: wide"]),
            "c.yaml:3: wheel_separation is \"wide\"; give a number",
        ),
        (
            controller(&["wheel_separation: '0.4'"]),
            "c.yaml:3: wheel_separation is in quotes; remove",
        ),
        (
            controller(&["wheel_separation: [0.4]"]),
            "c.yaml:3: wheel_separation is a list; give a number",
        ),
        (
            controller(&["wheel_separation: .inf"]),
            "c.yaml:3: wheel_separation is \".inf\"; give",
        ),
        (
            controller(&[ok, "wheel_radius: -1"]),
            "c.yaml: wheel_radius_m is -1 (wheel_radius of diff); give a",
        ),
        (
            controller(&[ok, "wheel_radius: &r 1", "wheel_separation_multiplier: *r"]),
            "c.yaml:5: wheel_separation_multiplier is an alias; give a number",
        ),
        (
            controller(&[ok, "wheel_radius: 1", "left_wheel_radius_multiplier: 0"]),
            "c.yaml:5: left_wheel_radius_multiplier is 0; give a number above 0",
        ),
        (
            controller(&[ok, "left_wheel_names: [[a]]"]),
            "c.yaml:4: left_wheel_names has a list; give the name",
        ),
        (
            format!("{}other:\n  wheel_separation: 0.5\n", controller(&[ok])),
            "c.yaml:5: has several controllers with wheels: diff, other; leave one",
        ),
        (format!("a: [1\n{ok}\n"), "c.yaml:"),
    ];
    for (text, message) in cases {
        let error = error(&text);
        assert!(error.starts_with(message), "{error}\n wanted {message}");
    }
}

#[test]
fn nodes_that_reckon_themselves_have_other_words() {
    let turtlebot = "turtlebot3_node:\n  ros__parameters:\n    wheels:\n      separation: 0.16\n      radius: 0.033\n\
                     diff_drive_controller:\n  ros__parameters:\n    wheels:\n      separation: 0.16\n      radius: 0.033\n";
    assert_eq!(lengths(turtlebot), [0.033, 0.08]);
    assert_eq!(
        lengths("driver: {wheels.separation: 0.2, wheels.radius: 0.05}"),
        [0.05, 0.1]
    );
    let arduino =
        "wheel_diameter: 0.1\nwheel_track: 0.3\nencoder_resolution: 8384\nport: /dev/ttyUSB0\n";
    assert_eq!(lengths(arduino), [0.05, 0.15]);
    assert_eq!(
        lengths("node:\n  base_width: 0.4\n  wheel_radius: 0.1\n"),
        [0.1, 0.2]
    );
    // The settings of a program for robots of a contest, as JSON.
    assert_eq!(
        lengths(
            "{\"robotTrackwidth\": 0.546, \"driveWheelRadius\": 0.048, \"holonomicMode\": false}"
        ),
        [0.048, 0.273]
    );
    let own = described("node:\n  wheel_base: 0.4\n  wheel_radius: 0.1\n");
    assert!(own.notes[0].contains("wheel_base of node counts as the distance between"));
}

#[test]
fn a_controller_without_lengths_says_what_is_missing_and_where_it_is() {
    let husky = "husky_velocity_controller:\n  type: \"diff_drive_controller/DiffDriveController\"\n  \
                 left_wheel: ['front_left_wheel', 'rear_left_wheel']\n  right_wheel: ['front_right_wheel', 'rear_right_wheel']\n  \
                 wheel_separation_multiplier: 1.875\n";
    let own = described(husky);
    assert_eq!(own.wheel_joints[1], ["front_left_wheel", "rear_left_wheel"]);
    let problem = error(husky);
    assert!(problem.starts_with(
        "c.yaml: gives no wheel_radius_m and no half_track_m: husky_velocity_controller has no wheel_radius, and \
         husky_velocity_controller has no wheel_separation; give the robot's URDF, too (--robot robot.urdf --robot c.yaml)"
    ), "{problem}");
    let kobuki = "mobile_base:\n  wheel_left_joint_name: wheel_left_joint\n  wheel_right_joint_name: wheel_right_joint\n";
    assert_eq!(described(kobuki).wheel_joints[0], ["wheel_right_joint"]);
}

#[test]
fn other_types_are_named_as_what_they_are() {
    let mecanum = "base:\n  ros__parameters:\n    type: mecanum_drive_controller/MecanumDriveController\n    \
                   wheel_separation: 0.3\n    wheel_radius: 0.05\n";
    let own = described(mecanum);
    assert_eq!(
        own.sources[0].title,
        "mecanum_drive_controller/MecanumDriveController YAML"
    );
    assert!(
        own.notes[0].contains("Mecanum wheels are no differential drive"),
        "{:?}",
        own.notes
    );
    // In ROS 2 the type stands beside the manager, not beside the parameters.
    let ackermann = "controller_manager:\n  ros__parameters:\n    car:\n      type: ackermann_steering_controller/AckermannSteeringController\n\
                     car:\n  ros__parameters:\n    wheel_separation: 0.3\n    wheel_radius: 0.05\n";
    assert!(described(ackermann).notes[0].contains("steered wheels"));
    let without = "m:\n  type: mecanum_drive_controller/MecanumDriveController\n  rate: 5\n";
    assert!(
        error(without).starts_with("c.yaml: has m, a mecanum_drive_controller/"),
        "{}",
        error(without)
    );
}

#[test]
fn millimetres_are_recognised_and_unclear_units_refused() {
    let own = described(&controller(&["wheel_separation: 300", "wheel_radius: 50"]));
    let body = own.model().unwrap().robot;
    assert_eq!([body.wheel_radius_m, body.half_track_m], [0.05, 0.15]);
    assert!(
        own.notes
            .iter()
            .any(|note| note.contains("wheel_separation of diff is 300: it counts as millimetres"))
    );
    let unclear = error(&controller(&["wheel_separation: 30", "wheel_radius: 0.05"]));
    assert!(unclear.starts_with(
        "c.yaml:3: wheel_separation is 30, which no robot has in metres; give it in metres"
    ));
}
