//! What a guess makes of the topics of typical robots.

#![expect(clippy::panic, clippy::unwrap_used, reason = "helpers of tests")]

#[path = "external/python.rs"]
mod python;

use slipstream_recording::{describe_robot, read};

/// The lines of the guessed map of a bag, and what else was said.
fn guessed(path: &std::path::Path) -> (Vec<String>, Vec<String>) {
    let import = read(path).unwrap();
    let (maps, others): (Vec<String>, _) = import
        .guesses
        .into_iter()
        .chain(import.warnings)
        .partition(|note| note.contains("guessed topics"));
    let lines = maps[0].lines().skip(3).map(str::to_owned);
    (lines.collect(), others)
}

#[test]
fn references_and_own_estimates_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("bags");
    if python::script("write_guesses.py", &[&out]).is_none() {
        return;
    }
    const WHEELS: &str = "wheels = { topic = \"/joint_states\", right = \"wheel_right_joint\", \
        left = \"wheel_left_joint\", quantity = \"angle\" }";
    let lines = |name: &str| guessed(&out.join(name)).0;
    assert_eq!(
        lines("localised"),
        [
            "[robots.\"robot\"]",
            "command = \"/cmd_vel\"",
            WHEELS,
            "odometry = \"/odom\"",
            "pose = \"/amcl_pose\"",
        ]
    );
    assert_eq!(
        lines("captured"),
        [
            "[robots.\"robot\"]",
            "command = \"/cmd_vel\"",
            WHEELS,
            "pose = \"/vicon/turtle/turtle\"",
        ]
    );
    assert_eq!(
        lines("transforms"),
        [
            "[robots.\"robot\"]",
            WHEELS,
            "pose = { topic = \"/tf\", parent = \"optitrack\", frame = \"cart\" }",
        ]
    );
    let simulated = lines("simulated");
    assert!(
        simulated.contains(&"pose = \"/ground_truth/state\"".to_owned()),
        "{simulated:?}"
    );
    assert!(
        simulated.contains(&"odometry = \"/base/odom\"".to_owned()),
        "{simulated:?}"
    );

    let (two, notes) = guessed(&out.join("two"));
    assert_eq!(
        two.iter()
            .filter(|line| line.starts_with("[robots"))
            .count(),
        2
    );
    for robot in ["r1", "r2"] {
        assert!(
            two.contains(&format!("pose = \"/vicon/{robot}/pose\"")),
            "{two:?}"
        );
    }
    assert!(
        notes
            .iter()
            .any(|note| note.starts_with("/vicon/ball/pose: left out")),
        "{notes:?}"
    );

    let (skid, notes) = guessed(&out.join("skid"));
    assert!(
        skid[1].contains("right = [\"front_right_wheel\", \"rear_right_wheel\"]"),
        "{skid:?}"
    );
    assert!(
        notes
            .iter()
            .any(|note| note.contains("4 wheels: the right side is the mean of")),
        "{notes:?}"
    );
    let import = read(&out.join("skid")).unwrap();
    let wheels = import.recording.robots[0].wheels.as_ref().unwrap();
    assert_eq!(wheels.t_s.len(), 40);
}

#[test]
fn messages_without_a_stamp_are_moved_onto_the_clock_of_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("bags");
    if python::script("write_guesses.py", &[&out]).is_none() {
        return;
    }
    let import = read(&out.join("simulated")).unwrap();
    let warnings = import.warnings.join("\n");
    assert!(
        warnings.contains("40 messages without a stamp are moved"),
        "{warnings}"
    );
    let robot = &import.recording.robots[0];
    let (command, wheels) = (
        robot.command.as_ref().unwrap(),
        robot.wheels.as_ref().unwrap(),
    );
    assert_eq!(command.t_s[3], wheels.t_s[3]);
}

#[test]
fn a_description_in_the_bag_gives_the_model_and_the_wheels() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("bags");
    if python::script("write_guesses.py", &[&out]).is_none() {
        return;
    }
    let (lines, _) = guessed(&out.join("described"));
    let wheels = "wheels = { topic = \"/joint_states\", right = [\"motor_2\", \"motor_4\"], \
        left = [\"motor_1\", \"motor_3\"], quantity = \"angle\" }";
    assert!(lines.contains(&wheels.to_owned()), "{lines:?}");
    let import = read(&out.join("described")).unwrap();
    let body = import.recording.model.unwrap().robot;
    assert_eq!([body.wheel_radius_m, body.half_track_m], [0.1, 0.25]);
    let note =
        "robot model from /robot_description in the bag: wheel_radius_m = 0.1, half_track_m = 0.25";
    assert_eq!(import.on_model[0], note);
    assert!(!import.left_out.contains_key("/robot_description"));
    let described = describe_robot(&[&out.join("described")]).unwrap();
    assert_eq!(described.wheel_joints[1], ["motor_1", "motor_3"]);

    let import = read(&out.join("without_radius")).unwrap();
    assert!(import.recording.model.is_none());
    let note = "no robot model from /robot_description in the bag: it gives no wheel_radius_m";
    assert!(
        import.on_model[0].starts_with(note),
        "{:?}",
        import.on_model
    );

    let import = read(&out.join("two_robots")).unwrap();
    assert!(import.recording.model.is_none());
    let both = "/a/robot_description, /b/robot_description describe different robots";
    assert!(
        import.on_model[0].starts_with(both),
        "{:?}",
        import.on_model
    );
    let error = describe_robot(&[&out.join("two_robots")])
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("describes different robots in /a/"),
        "{error}"
    );
    let none = describe_robot(&[&out.join("skid")])
        .unwrap_err()
        .to_string();
    assert!(
        none.contains("is a bag without a robot_description"),
        "{none}"
    );
}
