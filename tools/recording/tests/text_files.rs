//! Text files of strangers, read without a map: what they are is guessed, and said.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::f64::consts::PI;
use std::path::Path;

use slipstream_recording::recording::{Command, Robot, Wheels};
use slipstream_recording::{ColumnMap, Import, Map, draft_map, read, read_mapped};

/// Reads a file of this name; the map that was guessed is a map, and reads the same.
fn import(name: &str, text: &str) -> Import {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    std::fs::write(&file, text).unwrap();
    let import = read(&file).unwrap();
    let [guess, ..] = &import.guesses[..] else {
        unreachable!("a guess is said");
    };
    let (said, map) = guess.split_once('\n').unwrap();
    assert!(
        said.ends_with(&format!("{name}: guessed columns:")),
        "{said}"
    );
    assert!(map.contains("--write-columns"), "{map}");
    for map in [map, &draft_map(&file, &[]).unwrap()] {
        let map = ColumnMap::parse(map, Path::new("map.toml")).unwrap();
        let again = read_mapped(&file, &Map::Columns(map)).unwrap();
        assert_eq!(
            format!("{:?}", again.recording.robots),
            format!("{:?}", import.recording.robots)
        );
    }
    import
}

fn robot(import: &Import) -> &Robot {
    import.recording.robot("robot").unwrap()
}

/// The last row of the pose: time (s), x (m), y (m), yaw (rad).
fn last_pose(import: &Import) -> [f64; 4] {
    let pose = robot(import).pose.as_ref().unwrap();
    let last = |cells: &[f64]| *cells.last().unwrap();
    let yaw_rad = pose
        .values
        .yaw_rad
        .as_ref()
        .map_or(f64::NAN, |yaw| last(yaw));
    [
        last(&pose.t_s),
        last(&pose.values.x_m),
        last(&pose.values.y_m),
        yaw_rad,
    ]
}

/// The last row of the odometry: time (s), speed (m/s), rate (rad/s).
fn last_odometry(import: &Import) -> [f64; 3] {
    let odometry = robot(import).odometry.as_ref().unwrap();
    let w_rad_s = odometry.values.w_rad_s.as_ref().unwrap();
    [odometry.t_s[1], odometry.values.v_m_s[1], w_rad_s[1]]
}

#[track_caller]
fn near<const N: usize>(found: [f64; N], expected: [f64; N]) {
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6;
    assert!(
        found.iter().zip(&expected).all(is_near),
        "{found:?} {expected:?}"
    );
}

#[test]
fn names_in_latin_1_keep_their_units_and_zeros_at_the_end_are_a_cut_row() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.csv");
    let mut text = b"Zeit;x [m];y [m];Winkel [\xb0]\n0;1;2;0\n1;3;4;180\n".to_vec();
    text.extend([0; 500]);
    std::fs::write(&file, text).unwrap();
    let import = read(&file).unwrap();
    near(last_pose(&import), [1.0, 3.0, 4.0, PI]);
    assert!(
        import
            .warnings
            .join("\n")
            .contains("line 4, the last row, is cut"),
        "{:?}",
        import.warnings
    );
}

/// A quaternion of a quarter turn to the left: z and w.
const QUARTER: &str = "0.70710678 0.70710678";

#[test]
fn trajectories_of_tum_have_any_ending_and_header() {
    let rows = format!("1700000000.5 0 0 0 0 0 0 1\n1700000000.75 1.5 -2 0 0 0 {QUARTER}\n");
    let header = "# timestamp tx ty tz qx qy qz qw\n";
    for name in ["trajectory.tum", "trajectory", "trajectory.log", "t.txt"] {
        for header in [
            header,
            "",
            "Written by me\n",
            "# a drive of eight words in the lab\n",
            "# ground truth trajectory\n# file: 'a b'\n",
        ] {
            let import = import(name, &format!("{header}{rows}"));
            near(last_pose(&import), [0.25, 1.5, -2.0, PI / 2.0]);
        }
    }
}

#[test]
fn trajectories_may_be_stamped_in_nanoseconds() {
    let text =
        "1403636579758555392.000000 0 0 0 0 0 0 1\n1403636579858555392.000000 1 2 0 0 0 1 0\n";
    near(
        last_pose(&import("KeyFrameTrajectory.txt", text)),
        [0.1, 1.0, 2.0, PI],
    );
}

#[test]
fn poses_of_kitti_are_those_of_a_camera() {
    // 2 m ahead (z) and 1 m to the left (-x), turned to the left about the camera's y, which points down.
    let text = "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 -1 -1 0 1 0 0 1 0 0 2\n";
    let import = import("00.txt", text);
    near(last_pose(&import), [0.1, 2.0, 1.0, PI / 2.0]);
    assert!(
        import.guesses.join("\n").contains("correct period_s"),
        "{:?}",
        import.guesses
    );
}

/// A sequence of KITTI has the times of its poses in a file beside them.
#[test]
fn times_may_stand_in_a_file_beside_the_poses() {
    let folder = tempfile::tempdir().unwrap();
    let poses = "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 -1 -1 0 1 0 0 1 0 0 2\n";
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("00.txt", poses);
    write("times.txt", "0.000000e+00\n\n1.037302e-01\n");
    for path in [folder.path().to_owned(), folder.path().join("00.txt")] {
        let import = read(&path).unwrap();
        near(last_pose(&import), [0.103_730_2, 2.0, 1.0, PI / 2.0]);
        assert!(
            import.guesses[0].contains("times = \"times.txt\""),
            "{:?}",
            import.guesses
        );
    }
    write("times.txt", "0\nnone\n");
    let error = read(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("times.txt:2: has \"none\" where a time stands"),
        "{error}"
    );
    write("times.txt", "0\n");
    let error = read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("00.txt:2: has no time"), "{error}");
}

#[test]
fn columns_of_rostopic_echo_are_recognised() {
    let pose = "field.pose.pose.position.x,field.pose.pose.position.y,field.pose.pose.orientation.z,field.pose.pose.orientation.w";
    let text = format!(
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.child_frame_id,{pose},field.pose.covariance0,field.pose.covariance1,\
         field.twist.twist.linear.x,field.twist.twist.angular.z\n\
         1700000009000000000,0,1700000000500000000,odom,base_link,0,0,0,1,0.1,0.1,0,0\n\
         1700000009300000000,1,1700000000600000000,odom,base_link,1,2,0.70710678,0.70710678,0.1,0.1,0.5,-0.25\n"
    );
    let odometry = import("odom.csv", &text);
    near(last_pose(&odometry), [0.1, 1.0, 2.0, PI / 2.0]);
    near(last_odometry(&odometry), [0.1, 0.5, -0.25]);
    let notes = odometry.guesses.join("\n");
    assert!(notes.contains("robot's own estimate"), "{notes}");
    assert!(
        notes.contains("columns not used: time, field.header.seq")
            && notes.contains("field.pose.covariance0 to field.pose.covariance1"),
        "{notes}"
    );

    // A simulator's truth has the same type, and is a measurement.
    let truth = import("ground_truth_odom.csv", &text);
    assert!(robot(&truth).odometry.is_none() && robot(&truth).pose.is_some());
    assert!(!truth.guesses.join("\n").contains("own estimate"));

    let text = "%time,field.linear.x,field.linear.y,field.linear.z,field.angular.x,field.angular.y,field.angular.z\n\
                1700000000500000000,0,0,0,0,0,0\n1700000000600000000,0.5,0,0,0,0,1\n";
    let command = import("cmd.csv", text);
    let command = robot(&command).command.as_ref().unwrap();
    let Command::Twist { v_m_s, w_rad_s } = &command.values else {
        unreachable!("a twist");
    };
    near([command.t_s[1], v_m_s[1], w_rad_s[1]], [0.1, 0.5, 1.0]);

    let text = "%time,field.header.stamp,field.orientation.z,field.angular_velocity.z,field.linear_acceleration.x\n\
                5,1700000000500000000,0,0,9\n6,1700000000600000000,0,0.5,1\n";
    let imu = import("imu.csv", text);
    assert!(robot(&imu).pose.is_none());
    assert_eq!(
        robot(&imu)
            .imu
            .as_ref()
            .unwrap()
            .values
            .gz_rad_s
            .as_ref()
            .unwrap()[1],
        0.5
    );

    let text = "%time,field.header.stamp,field.name0,field.name1,field.name2,field.position0,field.position1,field.position2,field.velocity0\n\
                5,1700000000500000000,arm_left,wheel_left,wheel_right,7,1,2,0\n\
                6,1700000000600000000,arm_left,wheel_left,wheel_right,7,3,4,0\n";
    let joints = import("joint_states.csv", text);
    let wheels = robot(&joints).wheels.as_ref().unwrap();
    let Wheels::Angle {
        right_rad,
        left_rad,
    } = &wheels.values
    else {
        unreachable!("angles");
    };
    assert_eq!((right_rad[1], left_rad[1]), (4.0, 3.0));
}

#[test]
fn tables_of_messages_have_seconds_and_nanoseconds() {
    let text = "Time,header.seq,header.stamp.secs,header.stamp.nsecs,header.frame_id,pose.pose.position.x,pose.pose.position.y,\
                pose.pose.orientation.x,pose.pose.orientation.y,pose.pose.orientation.z,pose.pose.orientation.w,\
                twist.twist.linear.x,twist.twist.angular.z\n\
                1700000009.5,0,1700000000,500000000,odom,0,0,0,0,0,1,0,0\n\
                1700000009.7,1,1700000001,100000000,odom,1,2,0,0,1,0,0.5,0.25\n";
    let import = import("odom.csv", text);
    near(last_pose(&import), [0.6, 1.0, 2.0, PI]);
    near(last_odometry(&import), [0.6, 0.5, 0.25]);
}

#[test]
fn one_file_has_several_topics() {
    let text = "__time,/cmd_vel/linear/x,/cmd_vel/angular/z,/odom/header/stamp,/odom/pose/pose/position/x,\
                /odom/pose/pose/position/y,/odom/pose/pose/orientation/z,/odom/pose/pose/orientation/w,/odom/twist/twist/linear/x,\
                /odom/twist/twist/angular/z,/vicon/pose/position/x,/vicon/pose/position/y,/joint_states/left_wheel/velocity,\
                /joint_states/right_wheel/velocity\n\
                10.0,0.1,0,,,,,,,,,,,\n10.1,,,0.1,0,0,0,1,0.2,0,,,,\n10.2,,,,,,,,,,5,6,,\n10.3,,,,,,,,,,,,7,8\n\
                10.4,0.3,0.4,0.4,9,9,0,1,0.5,0.6,,,,\n";
    let import = import("plot.csv", text);
    let robot = robot(&import);
    // Commands have no stamp: all times are those of the file. The pose is the one that is no odometry.
    assert_eq!(robot.odometry.as_ref().unwrap().values.v_m_s, [0.2, 0.5]);
    near([robot.command.as_ref().unwrap().t_s[1]], [0.4]);
    near([robot.odometry.as_ref().unwrap().t_s[0]], [0.1]);
    assert_eq!(robot.pose.as_ref().unwrap().values.x_m, [5.0]);
    assert!(
        matches!(&robot.wheels.as_ref().unwrap().values, Wheels::Speed { right_rad_s, .. } if right_rad_s == &[8.0])
    );
}

#[test]
fn tables_of_euroc_say_their_units() {
    let text = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\r\n\
                1403636580838555648,0,0,0,1,0,0,0\r\n1403636580843555328,1,2,3,0.70710678,0,0,0.70710678\r\n";
    near(
        last_pose(&import("data.csv", text)),
        [0.00499968, 1.0, 2.0, PI / 2.0],
    );
    let text = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2]\n\
                1403636579758555392,0,0,0.25,8,-1\n";
    let imu = import("data.csv", text);
    let imu = robot(&imu).imu.as_ref().unwrap();
    assert_eq!(imu.values.gz_rad_s.as_ref().unwrap(), &[0.25]);
    assert_eq!(imu.values.ax_m_s2.as_ref().unwrap(), &[8.0]);
}

#[test]
fn messages_without_names_are_told_by_their_cells() {
    let covariance = "0,".repeat(36);
    let row = |ns: u32, x: f64, z: f64, w: f64| {
        let twist = format!("{x},0,0,0,0,0.5,{}", covariance.trim_end_matches(','));
        format!("1700000000,{ns},odom,base_link,{x},2,0,0,0,{z},{w},{covariance}{twist}\n")
    };
    let text = row(5, 0.0, 0.0, 1.0) + &row(100_000_005, 1.0, 1.0, 0.0);
    let odometry = import("odom.csv", &text);
    near(last_pose(&odometry), [0.1, 1.0, 2.0, PI]);
    near(last_odometry(&odometry), [0.1, 1.0, 0.5]);
    let text = "10,0,map,1,2,0,0,0,0,1\n10,500000000,map,3,4,0,0,0,1,0\n";
    near(last_pose(&import("pose.csv", text)), [0.5, 3.0, 4.0, PI]);
    let text = "10,0,base,1,0,0,0,0,0.5\n10,500000000,base,2,0,0,0,0,0.25\n";
    near(
        last_odometry(&import("base_twist.csv", text)),
        [0.5, 2.0, 0.25],
    );
    let command = import("cmd_vel.csv", text);
    assert!(robot(&command).command.is_some() && robot(&command).odometry.is_none());
    let text =
        "10,0,,left_wheel,right_wheel,1,2,3,4\n10,500000000,,left_wheel,right_wheel,5,6,7,8\n";
    let wheels = import("joints.csv", text);
    let wheels = robot(&wheels).wheels.as_ref().unwrap();
    assert!(matches!(&wheels.values, Wheels::Angle { right_rad, .. } if right_rad == &[2.0, 6.0]));
}

#[test]
fn logs_by_hand_have_units_commas_and_dates() {
    let text = "Zeit_nr;Time;x_mm;y_mm;heading_deg;left_rpm;right_rpm;gyro_z (deg/s)\n\
                1;2024-05-01 23:59:59,5;0;0;0;0;0;0\n2;2024-05-02 00:00:00,0;1500,5;-20;90,0;60;30;180\n";
    let import = import("log.csv", text);
    near(last_pose(&import), [0.5, 1.5005, -0.02, PI / 2.0]);
    let wheels = &robot(&import).wheels.as_ref().unwrap().values;
    let Wheels::Speed {
        right_rad_s,
        left_rad_s,
    } = wheels
    else {
        unreachable!("speeds");
    };
    near([right_rad_s[1], left_rad_s[1]], [PI, 2.0 * PI]);
    near(
        [robot(&import)
            .imu
            .as_ref()
            .unwrap()
            .values
            .gz_rad_s
            .as_ref()
            .unwrap()[1]],
        [PI],
    );
}

#[test]
fn names_by_hand_tell_sides_robots_and_references() {
    let text = "A log of mine\nt,encL,lwheel_vel [rpm],rwheel_vel [rpm],encR,u_l,u_r,I_left_mA,I_right_mA,vBat,odom_x,odom_y,odom_theta\n\
                0.5,1,2,3,4,5,6,7,8,12,0,0,0\n0.6,1,2,3,4,5,6,7,8,12.5,1,2,3\n";
    let file = import("log.csv", text);
    let only = robot(&file);
    assert!(
        matches!(&only.wheels.as_ref().unwrap().values, Wheels::Ticks { right, .. } if right == &[Some(4), Some(4)])
    );
    let command = &only.command.as_ref().unwrap().values;
    assert!(matches!(command, Command::Voltage { left_v, .. } if left_v == &[5.0, 5.0]));
    let motor = &only.motor.as_ref().unwrap().values;
    near(
        [
            motor.current_right_a.as_ref().unwrap()[1],
            motor.supply_v.as_ref().unwrap()[1],
        ],
        [0.008, 12.5],
    );
    near(last_pose(&file), [0.1, 1.0, 2.0, 3.0]);
    let warnings = file.warnings.join("\n");
    assert!(
        warnings.contains("the first 1 rows are no part of the table; left out"),
        "{warnings}"
    );
    let notes = file.guesses.join("\n");
    assert!(notes.contains("robot's own estimate"), "{notes}");

    // A pose that was measured outweighs the estimate, and each robot has its own columns.
    let text = "time,r1_odom_x,r1_odom_y,r1_odom_yaw,r1_vicon_x,r1_vicon_y,r1_vicon_yaw,r2_v_cmd,r2_w_cmd,gyro_z\n\
                0,0,0,0,5,6,0,1,2,9\n1,0,0,0,7,8,0,3,4,9\n";
    let file = import("two.csv", text);
    let r1 = file.recording.robot("r1").unwrap();
    assert_eq!(r1.pose.as_ref().unwrap().values.x_m, [5.0, 7.0]);
    let r2 = file.recording.robot("r2").unwrap();
    assert!(
        matches!(&r2.command.as_ref().unwrap().values, Command::Twist { v_m_s, .. } if v_m_s == &[1.0, 3.0])
    );
    assert!(r1.command.is_none() && r2.pose.is_none());
    // What names no robot is of none.
    assert!(r1.imu.is_none() && r2.imu.is_none());

    let text =
        "__time,/tb3_0/odom/twist/twist/linear/x,/tb3_1/odom/twist/twist/linear/x\n0,1,2\n1,3,4\n";
    let names: Vec<String> = import("plot.csv", text)
        .recording
        .robots
        .into_iter()
        .map(|own| own.name)
        .collect();
    assert_eq!(names, ["tb3_0", "tb3_1"]);
}

#[test]
fn a_last_row_that_was_cut_is_left_out_and_said() {
    let text = "t,x,y,yaw\n0,1,2,3\n1,2,3,4\n2,5";
    let file = import("log.csv", text);
    near(last_pose(&file), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
    assert!(
        file.warnings[0].ends_with("log.csv: line 4, the last row, is cut; left out"),
        "{:?}",
        file.warnings
    );
}

#[test]
fn a_folder_of_files_is_one_recording() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "cmd_vel.csv",
        "%time,field.linear.x,field.angular.z\n1700000000000000000,1,2\n1700000000100000000,3,4\n",
    );
    write(
        "vicon.txt",
        "# timestamp tx ty tz qx qy qz qw\n1700000000.05 1 2 0 0 0 0 1\n",
    );
    write("walk.csv", "t,x,y,yaw\n1,2,3,4\n");
    write("notes.txt", "It was on carpet.\n");
    let import = read(folder.path()).unwrap();
    let robot = robot(&import);
    near(
        [
            robot.pose.as_ref().unwrap().t_s[0],
            robot.command.as_ref().unwrap().t_s[1],
        ],
        [0.05, 0.1],
    );
    assert!(import.warnings.is_empty(), "{:?}", import.warnings);
    let notes = import.guesses.join("\n");
    for note in [
        "walk.csv: pose: left out, since another file has it",
        "notes.txt: not used, since its columns do not tell what they are",
    ] {
        assert!(notes.contains(note), "{notes}");
    }
    write("vicon.txt", "t x y yaw\n1.5 2 3 4\n");
    let warnings = read(folder.path()).unwrap().warnings.join("\n");
    assert!(
        warnings.contains("robot/command begins 1.7e9 s after robot/pose"),
        "{warnings}"
    );
}

#[test]
fn maps_take_directions_times_of_day_and_periods() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log");
    let read = |text: &str, map: &str| {
        std::fs::write(&file, text).unwrap();
        let map = format!("format = 1\n[robots.robot.pose]\n{map}");
        let map = ColumnMap::parse(&map, Path::new("map.toml")).unwrap();
        last_pose(&read_mapped(&file, &Map::Columns(map)).unwrap())
    };
    let pose = "x_m = 2\ny_m = 3\n";
    let text = "23:59:59.5 1 2 0 3\n00:00:01 4 5 0 -3\n";
    let turned = format!("t_s = 1\n{pose}forward_x = 4\nforward_y = 5\n");
    near(read(text, &turned), [1.5, 4.0, 5.0, -PI / 2.0]);
    // Rows without a position count, too.
    let text = "a,x,y\n0,1,1\n0,,\n0,2,3\n";
    near(
        read(text, "period_s = 0.25\nx_m = 2\ny_m = 3\nyaw_rad = 1\n")[..3]
            .try_into()
            .unwrap(),
        [0.5, 2.0, 3.0],
    );
    let text = "s ns x y\n10 900000000 0 0\n11 100000000 1 2\n";
    let map = "t_s = \"s\"\nt_ns = \"ns\"\nx_m = \"x\"\ny_m = \"y\"\nyaw_rad = \"x\"\n";
    near(read(text, map), [0.2, 1.0, 2.0, 1.0]);
}

#[test]
fn what_cannot_be_guessed_says_how_to_write_a_map() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.dat");
    let error = |content: &[u8]| {
        std::fs::write(&file, content).unwrap();
        let error = read(&file).unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    };
    for text in [
        ",x,y,yaw\n0,1,2,3\n1,2,3,4\n",
        "s,x,y,yaw\n0,1,2,3\n",
        "a,b\n1,2\n",
        "just words\n",
        "1 2 3\n4 5 6\n",
        "time,x\n",
    ] {
        let error = error(text.as_bytes());
        assert!(error.contains("needs a map of its columns"), "{error}");
        assert!(error.contains("--write-columns"), "{error}");
    }
    let damaged = error(b"t,x,y,yaw\n1,2,3,4\n2,oops,3,4\n");
    assert!(
        damaged.contains("run.dat:3: column x has \"oops\"; give numbers"),
        "{damaged}"
    );
    assert!(damaged.contains("the columns were guessed"), "{damaged}");
    assert!(error(b"\xff\xfet\0,\0x\0").contains("is text in UTF-16; save it as UTF-8"));
    assert!(error(&[7; 100]).contains("is not a bag of a known kind"));
    let long = error(&[b'1'; 2 << 20]);
    assert!(long.contains("has a line of more than"), "{long}");
}

#[test]
fn pointers_of_git_lfs_are_named() {
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 123456\n";
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().join("bag");
    std::fs::create_dir(&name).unwrap();
    let says_so = |path: &Path| {
        let error = read(path).unwrap_err().to_string();
        assert!(
            error.contains("is a pointer of Git LFS, not the file itself; run `git lfs pull`"),
            "{error}"
        );
    };
    for file in ["run.mcap", "log.csv", "run", "bag/bag_0.db3"] {
        let file = folder.path().join(file);
        std::fs::write(&file, pointer).unwrap();
        says_so(&file);
    }
    says_so(&name);
    let own = folder.path().join("own");
    std::fs::create_dir_all(own.join("r1")).unwrap();
    std::fs::write(own.join("recording.toml"), "format = 1\n[robots.r1]\n").unwrap();
    std::fs::write(own.join("r1/wheels.csv"), pointer).unwrap();
    says_so(&own);
}
