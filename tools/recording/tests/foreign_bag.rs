//! A bag written by another program, as another robot would: read with a guessed map and with a given
//! map.

#![expect(clippy::panic, reason = "helpers of tests")]

#[path = "external/python.rs"]
mod python;

use std::path::Path;

use slipstream_recording::recording::{Command, Wheels};
use slipstream_recording::{Map, TopicMap, read, read_mapped};

#[test]
fn the_guess_finds_the_streams_and_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.mcap");
    if python::script("write_bag.py", &[&file]).is_none() {
        return;
    }
    let import = read(&file).unwrap();
    let [guess] = &import.guesses[..] else {
        panic!("{:?}", import.guesses);
    };
    assert_eq!(import.warnings, Vec::<String>::new());
    let topics = [
        "command = \"/cmd_vel\"\n",
        "wheels = { topic = \"/joint_states\", right = \"right_wheel_joint\", \
         left = \"left_wheel_joint\", quantity = \"angle\" }\n",
        "odometry = \"/odom\"\n",
        "pose = \"/vicon/robot/pose\"\n",
    ];
    for topic in topics {
        assert!(guess.contains(topic), "{guess}");
    }
    assert_eq!(
        import.left_out.into_iter().collect::<Vec<_>>(),
        [("/chatter".to_owned(), 100)]
    );

    let robot = import.recording.robot("robot").unwrap();
    let command = robot.command.as_ref().unwrap();
    // Messages without stamp get their log time; all times count from the first message.
    assert_eq!(command.t_s[..2], [0.002, 0.052]);
    let Command::Twist { v_m_s, w_rad_s } = &command.values else {
        panic!("no twist");
    };
    assert_eq!((v_m_s[99], w_rad_s[99]), (0.5, 0.1));
    let wheels = robot.wheels.as_ref().unwrap();
    let Wheels::Angle {
        right_rad,
        left_rad,
    } = &wheels.values
    else {
        panic!("no angles");
    };
    assert_eq!(
        (wheels.t_s[3], right_rad[3], left_rad[3]),
        (0.15, 0.2 * 3.0, 0.1 * 3.0)
    );
    let pose = robot.pose.as_ref().unwrap();
    assert_eq!(pose.values.x_m[4], 0.1);
    let yaw_rad = pose.values.yaw_rad.as_ref().unwrap();
    assert!((yaw_rad[99] - 0.495).abs() < 1e-15);
    assert_eq!(robot.odometry.as_ref().unwrap().values.v_m_s[0], 0.5);

    // A folder with one MCAP file, as `ros2 bag record` writes it.
    let in_folder = read(folder.path()).unwrap();
    assert_eq!(
        in_folder.recording.robots[0].pose.as_ref().unwrap().t_s,
        pose.t_s
    );

    // The guess can be used as a map and gives the same recording.
    let map = guess.split_once('\n').unwrap().1;
    let map = TopicMap::parse(map, Path::new("map.toml")).unwrap();
    let again = read_mapped(&file, &Map::Topics(map)).unwrap();
    assert_eq!(
        [again.guesses, again.warnings].concat(),
        Vec::<String>::new()
    );
    assert_eq!(
        again.recording.robots[0].pose.as_ref().unwrap().t_s,
        pose.t_s
    );
}

/// A driver fills the pose of its odometry and leaves the twist zero.
#[test]
fn the_speeds_of_an_odometry_with_a_zero_twist_are_those_of_its_pose() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.mcap");
    if python::script("write_bag.py", &[&file, Path::new("idle")]).is_none() {
        return;
    }
    let import = read(&file).unwrap();
    let said = "the twist of /odom is zero throughout although its pose moves";
    let warned = import.warnings.iter().any(|own| own.contains(said));
    assert!(warned, "{:?}", import.warnings);
    let odometry = import.recording.robots[0].odometry.as_ref().unwrap();
    // one row between each two of a hundred poses, in their middle
    assert_eq!(odometry.t_s.len(), 99);
    assert!(
        (odometry.t_s[0] - 0.025).abs() < 1e-6,
        "{}",
        odometry.t_s[0]
    );
    let w_rad_s = odometry.values.w_rad_s.as_ref().unwrap();
    assert!((odometry.values.v_m_s[0] - 0.5).abs() < 1e-4);
    assert!((w_rad_s[50] - 0.1).abs() < 1e-9, "{}", w_rad_s[50]);
}

#[test]
fn a_map_is_followed_and_its_errors_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.mcap");
    if python::script("write_bag.py", &[&file]).is_none() {
        return;
    }
    let map = |text: &str| {
        let text = format!("format = 1\n[robots.husky]\n{text}\n");
        TopicMap::parse(&text, Path::new("map.toml")).unwrap()
    };
    let speeds = map(
        "wheels = { topic = \"/joint_states\", right = \"right_wheel_joint\", \
                      left = \"left_wheel_joint\", quantity = \"speed\" }\npose = \"/odom\"",
    );
    let import = read_mapped(&file, &Map::Topics(speeds)).unwrap();
    let husky = import.recording.robot("husky").unwrap();
    let Wheels::Speed { right_rad_s, .. } = &husky.wheels.as_ref().unwrap().values else {
        panic!("no speeds");
    };
    assert_eq!(right_rad_s[0], 4.0);
    assert_eq!(husky.pose.as_ref().unwrap().values.x_m[4], 0.1);

    let missing = read_mapped(&file, &Map::Topics(map("imu = \"/imu\""))).unwrap_err();
    assert!(
        missing
            .to_string()
            .contains("has no topic /imu; name one of: /chatter, /cmd_vel")
    );
    let wrong = read_mapped(&file, &Map::Topics(map("imu = \"/odom\""))).unwrap_err();
    assert!(
        wrong
            .to_string()
            .contains("/odom is a nav_msgs/msg/Odometry, which cannot provide imu")
    );
}
