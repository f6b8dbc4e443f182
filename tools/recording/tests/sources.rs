//! Wheels that are told in other ways than as joints with sides in their names, in bags that another program wrote.

#![expect(clippy::panic, clippy::unwrap_used, reason = "helpers of tests")]

#[path = "external/python.rs"]
mod python;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use slipstream_recording::recording::{Robot, Wheels};
use slipstream_recording::{Import, Map, TopicMap, draft_map, read, read_mapped, read_spooled};

/// A bag; `None` if there is no Python environment. The tests of this file share them.
fn bag(name: &str) -> Option<PathBuf> {
    static OUT: OnceLock<Option<PathBuf>> = OnceLock::new();
    let out = OUT.get_or_init(|| {
        let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sources");
        // It does not exist the first time.
        let _ = std::fs::remove_dir_all(&out);
        python::script("write_sources.py", &[&out]).map(|_| out)
    });
    out.as_ref().map(|out| out.join(name))
}

/// The line of a stream in the guessed map.
fn line(import: &Import, stream: &str) -> Option<String> {
    let start = format!("{stream} = ");
    let mut lines = import.guesses.iter().flat_map(|note| note.lines());
    lines.find_map(|line| Some(line.strip_prefix(&start)?.to_owned()))
}

fn only_robot(import: &Import) -> &Robot {
    assert_eq!(import.recording.robots.len(), 1);
    &import.recording.robots[0]
}

/// Times, and counts right and left.
fn ticks(import: &Import) -> (&[f64], Vec<[i64; 2]>) {
    let wheels = only_robot(import).wheels.as_ref().unwrap();
    let Wheels::Ticks { right, left } = &wheels.values else {
        panic!("no ticks");
    };
    let pairs = right.iter().zip(left);
    let pairs = pairs.map(|(right, left)| [right.unwrap(), left.unwrap()]);
    (&wheels.t_s, pairs.collect())
}

/// Angles right and left.
fn angles(import: &Import) -> Vec<[f64; 2]> {
    let wheels = only_robot(import).wheels.as_ref().unwrap();
    let Wheels::Angle {
        right_rad,
        left_rad,
    } = &wheels.values
    else {
        panic!("no angles");
    };
    let pairs = right_rad.iter().zip(left_rad);
    pairs.map(|(right, left)| [*right, *left]).collect()
}

fn map(lines: &str) -> Map {
    let text = format!("format = 1\n[robots.r1]\n{lines}\n");
    Map::Topics(TopicMap::parse(&text, Path::new("map.toml")).unwrap())
}

#[test]
fn of_every_kind_of_source_the_best_is_taken_and_the_others_are_named() {
    let Some(everything) = bag("everything") else {
        return;
    };
    let import = read(&everything).unwrap();
    let expected = [
        ("command", "\"/cmd_vel\""),
        (
            "wheels",
            "{ topic = \"/joint_states\", right = \"wheel_2\", left = \"wheel_1\", quantity = \"angle\" }",
        ),
        ("odometry", "\"/odom\""),
        ("pose", "\"/mocap/pose\""),
        ("imu", "\"/imu/data\""),
    ];
    for (stream, source) in expected {
        assert_eq!(line(&import, stream).as_deref(), Some(source));
    }
    let robot = only_robot(&import);
    let odometry = robot.odometry.as_ref().unwrap();
    assert!((odometry.values.v_m_s[5] - 0.2).abs() < 1e-6);
    assert_eq!(
        import.guesses[1..],
        ["not used, though each might be a source: \
            /amcl_pose (PoseWithCovarianceStamped, 100 messages; /mocap/pose is used), \
            /cmd_vel_mux/input/teleop (Twist, 100 messages; /cmd_vel is used), \
            /imu/data_raw (Imu, 100 messages; /imu/data is used), \
            /right_ticks and /left_ticks (Int32, 100 messages; /joint_states is used), \
            /tf (map to base_link; /mocap/pose is used), \
            /tf (the wheels right_wheel_link and left_wheel_link; /joint_states is used); \
            map them with --topics"]
    );
}

#[test]
fn other_names_of_worse_wheels_are_no_other_robots() {
    let Some(prefixed) = bag("prefixed") else {
        return;
    };
    let import = read(&prefixed).unwrap();
    assert_eq!(only_robot(&import).name, "robot");
    assert!(only_robot(&import).pose.is_some());
    assert_eq!(angles(&import)[3], [0.1 * 3.0 + 1.0, 0.1 * 3.0]);
}

#[test]
fn the_joints_that_a_user_names_are_the_wheels() {
    let Some(numbered) = bag("numbered") else {
        return;
    };
    let without = read(&numbered).unwrap();
    assert!(only_robot(&without).wheels.is_none());
    let said = "/joint_states: left out: no name of its joints wheel_1, wheel_2 tells a side; give the robot's URDF or controller \
        YAML with --robot, or map them in a file for --topics (`slipstream check BAG --write-topics FILE.toml` writes one)";
    assert_eq!(without.warnings, [said]);

    let side = |name: &str| vec![name.to_owned()];
    let others = [side("right_motor"), side("left_motor")];
    let own = [side("wheel_2"), side("wheel_1")];
    let with = read_spooled(&numbered, &Map::None, &[others, own.clone()]).unwrap();
    let with = with.load().unwrap();
    // The joints' angles are apart by 1 rad.
    assert_eq!(angles(&with)[3], [0.1 * 3.0 + 1.0, 0.1 * 3.0]);
    let draft = draft_map(&numbered, &[own]).unwrap();
    assert!(
        draft.contains("right = \"wheel_2\", left = \"wheel_1\""),
        "{draft}"
    );
}

#[test]
fn the_places_of_their_frames_tell_the_sides_of_joints() {
    let Some(placed) = bag("placed") else { return };
    let import = read(&placed).unwrap();
    // drive_b lies on the right.
    assert_eq!(angles(&import)[3], [0.1 * 3.0 + 1.0, 0.1 * 3.0]);
}

#[test]
fn counters_with_a_topic_each_become_rows_at_the_times_of_the_right_one() {
    for name in ["apart", "apart_database"] {
        let Some(path) = bag(name) else { return };
        let import = read(&path).unwrap();
        let (t_s, pairs) = ticks(&import);
        // The right counter is 10 ms late in 50 ms; the left one goes 10 counts from row to row.
        assert!((t_s[3] - 0.16).abs() < 1e-9, "{}", t_s[3]);
        assert_eq!(pairs[3], [60, 30 + 2]);
        // After the last value of the left one there is no row.
        assert_eq!(pairs.len(), 99);
        let again = read_mapped(
            &path,
            &map(&format!("wheels = {}", line(&import, "wheels").unwrap())),
        );
        assert_eq!(ticks(&again.unwrap()).1, pairs);
    }
}

/// What `check` says about wheels that count backwards can be done.
#[test]
fn a_map_turns_the_sign_of_wheels_and_tells_their_counts() {
    let Some(path) = bag("apart") else { return };
    let import = read(&path).unwrap();
    let (_, pairs) = ticks(&import);
    let own = line(&import, "wheels").unwrap();
    let own = own.trim_end_matches('}');
    let reversed = |side: &str| {
        let lines =
            format!("encoder_counts_per_rev = 2578.33\nwheels = {own}, reversed = \"{side}\" }}");
        let import = read_mapped(&path, &map(&lines)).unwrap();
        let counts = only_robot(&import).encoder_counts_per_rev;
        assert_eq!(counts, Some(2578.33));
        ticks(&import).1
    };
    assert_eq!(reversed("left")[3], [pairs[3][0], -pairs[3][1]]);
    assert_eq!(reversed("both")[3], pairs[3].map(|count| -count));
}

#[test]
fn each_robot_has_its_own_counters() {
    let Some(two) = bag("two") else { return };
    let import = read(&two).unwrap();
    let first = |robot: &Robot| match &robot.wheels.as_ref().unwrap().values {
        Wheels::Ticks { right, .. } => right[1],
        _ => None,
    };
    let robots = import.recording.robots.iter();
    let found: Vec<_> = robots
        .map(|own| (own.name.as_str(), first(own), own.pose.is_some()))
        .collect();
    assert_eq!(found, [("r1", Some(20), true), ("r2", Some(200), true)]);
}

#[test]
fn where_a_counter_wraps_nothing_lies_between() {
    let Some(short) = bag("short") else { return };
    let import = read(&short).unwrap();
    let (_, pairs) = ticks(&import);
    let wrapped = |count: i64| (count + 32768).rem_euclid(65536) - 32768;
    for (k, [right, left]) in pairs.iter().enumerate() {
        let k = i64::try_from(k).unwrap();
        assert_eq!(*right, wrapped(2000 * k));
        // Interpolated, or the value before the wrap.
        assert!(
            [1000 * k + 200, 1000 * k].map(wrapped).contains(left),
            "{k}: {left}"
        );
    }
}

#[test]
fn stamps_of_own_messages_count() {
    let Some(stamped) = bag("stamped") else {
        return;
    };
    let import = read(&stamped).unwrap();
    assert_eq!(only_robot(&import).name, "duckie");
    let (t_s, pairs) = ticks(&import);
    assert_eq!((t_s[3], pairs[3]), (0.15, [60, 30]));
}

#[test]
fn fields_of_a_message_are_read_by_its_definition() {
    for name in [
        "sensor_state",
        "state_database",
        "state.bag",
        "state_ros1.mcap",
    ] {
        let Some(path) = bag(name) else { return };
        let import = read(&path).unwrap();
        let wheels = "{ topic = \"/sensor_state\", right = \"right_encoder\", left = \"left_encoder\", quantity = \"ticks\" }";
        assert_eq!(line(&import, "wheels").as_deref(), Some(wheels));
        let (t_s, pairs) = ticks(&import);
        assert_eq!((t_s[3], pairs[3]), (0.15, [60, 30]), "{name}");
    }
    let undefined = read(&bag("state_undefined").unwrap()).unwrap();
    let said = "not read, because the bag has no definition of their types: /sensor_state (SensorState, 100 messages); if";
    assert!(
        undefined.guesses[1].starts_with(said),
        "{:?}",
        undefined.guesses
    );
}

#[test]
fn messages_in_another_encoding_are_named() {
    let Some(path) = bag("json.mcap") else { return };
    let import = read(&path).unwrap();
    let said = "not read, because messages are neither in CDR nor in the encoding of ROS 1: /wheels (json)";
    assert_eq!(import.guesses[1..], [said]);
}

#[test]
fn speeds_and_angles_are_told_by_their_names() {
    let Some(speeds) = bag("speeds") else { return };
    let import = read(&speeds).unwrap();
    let wheels = only_robot(&import).wheels.as_ref().unwrap();
    let Wheels::Speed { right_rad_s, .. } = &wheels.values else {
        panic!("no speeds");
    };
    assert!((right_rad_s[0] - 4.0).abs() < 1e-6);

    let four = read(&bag("four").unwrap()).unwrap();
    assert_eq!(angles(&four)[10], [2.0, 1.0]);
    let said = "not used, though each might be a source: /drive (AckermannDriveStamped, 100 messages), \
        /wheel_states (rr_position and rl_position; /wheel_states is used); map them with --topics";
    assert_eq!(four.guesses[1..], [said]);
}

#[test]
fn numbers_whose_sides_no_name_tells_are_named_and_can_be_mapped() {
    for name in ["lists", "telemetry.bag"] {
        let Some(path) = bag(name) else { return };
        let import = read(&path).unwrap();
        assert!(only_robot(&import).wheels.is_none());
        let said = "not used, though each might be a source: /encoders (Int32MultiArray, 100 messages), \
            /telemetry (Telemetry, 100 messages); map them with --topics";
        assert_eq!(import.guesses[1..], [said]);
        let draft = draft_map(&path, &[]).unwrap();
        assert!(draft.contains("fields data[0], data[1]"), "{draft}");
        let lists = "wheels = { topic = \"/encoders\", right = \"data[1]\", left = \"data[0]\", quantity = \"ticks\" }";
        assert_eq!(
            ticks(&read_mapped(&path, &map(lists)).unwrap()).1[3],
            [60, 30]
        );
        let nested = "wheels = { right = { topic = \"/telemetry\", field = \"motors[1].counted\" }, \
            left = { topic = \"/encoders\", field = \"data[0]\" }, quantity = \"ticks\" }\n\
            command = { topic = \"/telemetry\", right = \"motors[1].volts\", left = \"motors[0].volts\", quantity = \"voltage\" }";
        let nested = read_mapped(&path, &map(nested)).unwrap();
        assert_eq!(ticks(&nested).1[3], [60, 30]);
        assert!(only_robot(&nested).command.is_some());
    }
}

#[test]
fn a_map_of_numbers_that_are_not_there_is_refused_in_words() {
    let Some(lists) = bag("lists") else { return };
    let cases = [
        (
            "wheels = { topic = \"/encoders\", right = \"data[2]\", left = \"data[0]\", quantity = \"ticks\" }",
            "/encoders has no field data[2]; name one of: data[0], data[1], layout.data_offset",
        ),
        (
            "wheels = { topic = \"/encoders\", right = \"data[1]\", left = \"data[0]\" }",
            "add quantity = \"ticks\", \"angle\" or \"speed\"",
        ),
        (
            "wheels = { topic = \"/encoders\", right = \"data[1]\", left = \"data[0]\", quantity = \"torque\" }",
            "the map no quantity that wheels has",
        ),
        ("pose = \"/encoders\"", "which cannot provide pose"),
    ];
    for (text, expected) in cases {
        let error = read_mapped(&lists, &map(text)).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn frames_that_turn_about_an_axle_are_wheels() {
    let Some(frames) = bag("frames") else { return };
    let import = read(&frames).unwrap();
    let wheels = "{ topic = \"/tf\", right = \"right_wheel_link\", left = \"left_wheel_link\", quantity = \"angle\" }";
    assert_eq!(line(&import, "wheels").as_deref(), Some(wheels));
    // Forward is positive, and goes on beyond half a turn.
    for (k, [right, left]) in angles(&import).iter().enumerate() {
        let k = k as f64;
        assert!((right - 0.2 * k).abs() < 1e-9 && (left - 0.1 * k).abs() < 1e-9);
    }
    let spins = "wheels = { topic = \"/tf\", right = \"right_wheel_link\", left = \"nose\", quantity = \"angle\" }";
    let error = read_mapped(&frames, &map(spins)).unwrap_err().to_string();
    assert!(
        error.contains("has no transform to nose; name one of"),
        "{error}"
    );
}

#[test]
fn an_odometry_of_poses_gives_speeds() {
    let Some(path) = bag("poses") else { return };
    let import = read(&path).unwrap();
    assert_eq!(line(&import, "odometry").as_deref(), Some("\"/odom_pose\""));
    assert_eq!(line(&import, "pose").as_deref(), Some("\"/mocap/pose\""));
    let odometry = only_robot(&import).odometry.as_ref().unwrap();
    assert!((odometry.values.v_m_s[5] - 0.2).abs() < 1e-6);
}

#[test]
fn arms_are_no_robots_beside_wheels() {
    let Some(arms) = bag("arms") else { return };
    let import = read(&arms).unwrap();
    assert_eq!(only_robot(&import).name, "robot");
    let wheels = line(&import, "wheels").unwrap();
    assert!(wheels.contains("left_wheel"), "{wheels}");
}

#[test]
fn a_twist_without_numbers_is_replaced_by_the_pose() {
    let Some(path) = bag("not_a_number") else {
        return;
    };
    let import = read(&path).unwrap();
    let odometry = only_robot(&import).odometry.as_ref().unwrap();
    assert!((odometry.values.v_m_s[5] - 0.2).abs() < 1e-6);
}
