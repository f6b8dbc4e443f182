//! One recording in every form, written by other programs, and damaged forms of it: all whole ones are the same
//! recording, and of damaged ones everything is read that there is.

#![expect(clippy::panic, clippy::unwrap_used, reason = "helpers of tests")]

#[path = "external/python.rs"]
mod python;

use std::fmt::Write as _;
use std::path::Path;

use slipstream_recording::recording::{Robot, Wheels};
use slipstream_recording::{Import, Map, Severity, TopicMap, check, read, read_mapped};

/// Rows of each stream.
const ROWS: usize = 400;

/// A folder of CSV files: a robot that drives a curve.
fn write_folder(folder: &Path) {
    let robot = folder.join("r1");
    std::fs::create_dir_all(&robot).unwrap();
    std::fs::write(
        folder.join("recording.toml"),
        "format = 1\n[robots.r1]\npose_point = \"axle\"\nencoder_counts_per_rev = 4096\n",
    )
    .unwrap();
    let mut wheels = String::from("t_s,ticks_right,ticks_left\n");
    let mut pose = String::from("t_s,x_m,y_m,yaw_rad\n");
    for k in 0..ROWS {
        let t_s = k as f64 * 0.05;
        let _ = writeln!(wheels, "{},{},{}", t_s + 0.25, 130 * k, 120 * k);
        let yaw_rad = 0.3 * (0.5 * t_s).sin();
        let _ = writeln!(
            pose,
            "{},{},{},{yaw_rad}",
            t_s + 0.26,
            0.1 * t_s,
            0.02 * t_s
        );
    }
    std::fs::write(robot.join("wheels.csv"), wheels).unwrap();
    std::fs::write(robot.join("pose.csv"), pose).unwrap();
}

/// Writes bags with a script; `None`, with a message, without Python.
fn written(script: &str) -> Option<tempfile::TempDir> {
    let folder = tempfile::tempdir().unwrap();
    write_folder(&folder.path().join("given"));
    let (given, out) = (folder.path().join("given"), folder.path().join("out"));
    python::script(script, &[&given, &out])?;
    Some(folder)
}

fn only_robot(import: &Import) -> &Robot {
    let [robot] = &import.recording.robots[..] else {
        panic!("{} robots", import.recording.robots.len());
    };
    robot
}

/// Times, angles and poses of a robot.
fn rows(robot: &Robot) -> [Vec<f64>; 7] {
    let wheels = robot.wheels.as_ref().unwrap();
    let Wheels::Angle {
        right_rad,
        left_rad,
    } = &wheels.values
    else {
        panic!("no angles");
    };
    let pose = robot.pose.as_ref().unwrap();
    [
        wheels.t_s.clone(),
        right_rad.clone(),
        left_rad.clone(),
        pose.t_s.clone(),
        pose.values.x_m.clone(),
        pose.values.y_m.clone(),
        pose.values.yaw_rad.clone().unwrap(),
    ]
}

#[test]
fn one_recording_is_the_same_in_every_form() {
    let Some(folder) = written("write_formats.py") else {
        return;
    };
    let form = |name: &str| read(&folder.path().join("out").join(name)).unwrap();
    let csv = rows(only_robot(&form("csv")));
    assert_eq!(csv[0].len(), ROWS);
    let plain = rows(only_robot(&form("plain.mcap")));
    for (mine, theirs) in plain.iter().zip(&csv) {
        // A quaternion holds a yaw to the last digits.
        let differ = mine.iter().zip(theirs).map(|(a, b)| (a - b).abs());
        assert!(differ.fold(0.0, f64::max) < 1e-15);
    }
    let forms = [
        "plain.db3",
        "whole_mcap",
        "whole_db3",
        "split_mcap",
        "split_db3_zstd",
        "messages_zstd",
        "ros1.bag",
        "ros1_lz4.bag",
        "ros1_bz2.bag",
    ];
    for name in forms {
        let import = form(name);
        assert_eq!(rows(only_robot(&import)), plain, "{name}");
        assert!(!import.loss.unwrap().any(), "{name}");
    }
}

#[test]
fn of_a_damaged_bag_everything_is_read_that_there_is() {
    let Some(folder) = written("write_broken.py") else {
        return;
    };
    let out = folder.path().join("out");
    // Name, fewest wheel rows, whether something was lost.
    let cases = [
        ("cut.mcap", ROWS / 4, true),
        ("cut.db3", ROWS / 4, true),
        ("cut.bag", ROWS / 4, true),
        ("cut_lz4.bag", 1, true),
        ("index_lost.mcap", ROWS * 9 / 10, true),
        ("index_lost.bag", ROWS, false),
        ("damaged.db3", ROWS * 3 / 4, true),
        ("damaged_lz4.bag", 1, true),
        ("part_missing", ROWS / 2, true),
        ("no_metadata", ROWS, true),
        ("stamps_zero.mcap", ROWS, false),
        ("simulated_time.mcap", ROWS, false),
    ];
    for (name, fewest, is_lossy) in cases {
        let import = read(&out.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let rows = rows(only_robot(&import))[0].len();
        assert!((fewest..=ROWS).contains(&rows), "{name}: {rows} rows");
        assert_eq!(import.loss.unwrap().any(), is_lossy, "{name}");
    }
    let zero = read(&out.join("stamps_zero.mcap")).unwrap().warnings;
    assert!(
        zero.iter().any(|w| w.contains("400 of 400 stamps are 0")),
        "{zero:?}"
    );
    let none = read(&out.join("no_values.mcap")).unwrap();
    assert!(only_robot(&none).wheels.is_none());
    assert!(
        none.warnings.iter().any(|w| w.contains("neither angle")),
        "{:?}",
        none.warnings
    );
    let two = check(&read(&out.join("two_robots.mcap")).unwrap().recording, None);
    assert!(
        two.findings
            .iter()
            .any(|finding| finding.severity == Severity::Error && finding.id == "two_sources")
    );
}

#[test]
fn a_wrong_map_is_refused_in_words() {
    let Some(folder) = written("write_formats.py") else {
        return;
    };
    let bag = folder.path().join("out/plain.mcap");
    let joints = "topic = \"/base/joint_states\", right = \"wheel_right_joint\", left";
    let cases = [
        (
            "pose = \"/pose\"".to_owned(),
            "has no topic /pose; name one of",
        ),
        (
            "imu = \"/vicon/cart/pose\"".to_owned(),
            "which cannot provide imu",
        ),
        (
            format!("wheels = {{ {joints} = \"lefty\" }}"),
            "has no joint lefty; name one of: pan_tilt_joint",
        ),
        (
            format!("wheels = {{ {joints} = \"wheel_left_joint\", quantity = \"speed\" }}"),
            "gives no value for speed_right_rad_s",
        ),
        (format!("wheels = {{ {joints} = [] }}"), "names no joint"),
        (
            format!("wheels = {{ {joints} = \"a\", quantity = \"turns\" }}"),
            "is not a quantity",
        ),
        (
            format!("wheels = {{ {joints} = \"a\", quantity = \"ticks\" }}"),
            "which cannot provide wheels",
        ),
        (
            "wheels = \"/base/joint_states\"".to_owned(),
            "has no joint wheel_right, wheel_left",
        ),
        ("position = \"/vicon/cart/pose\"".to_owned(), "is not a key"),
        (
            "pose_point = \"nose\"\npose = \"/vicon/cart/pose\"".to_owned(),
            "is not valid",
        ),
        (String::new(), "maps no topic"),
    ];
    for (text, expected) in cases {
        let text = format!("format = 1\n[robots.r1]\n{text}\n");
        let error = match TopicMap::parse(&text, Path::new("map.toml")) {
            Ok(map) => read_mapped(&bag, &Map::Topics(map))
                .unwrap_err()
                .to_string(),
            Err(error) => error.to_string(),
        };
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
}
