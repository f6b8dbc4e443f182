//! A robot of others: a Python program with `eclipse-zenoh` and `rosbags` takes the commands and sends joint states and
//! poses. What it heard and sent is what the recording has.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::common::{command, read_json, skipped};
use crate::lab::{LIMITS, port};

/// The Python with the packages: of the variable, else the system's.
fn python() -> Option<String> {
    let python = std::env::var("SLIPSTREAM_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let packages = Command::new(&python)
        .args(["-c", "import zenoh, rosbags, numpy"])
        .output();
    packages
        .is_ok_and(|own| own.status.success())
        .then_some(python)
}

#[test]
fn a_robot_of_others_is_driven_and_recorded() {
    let Some(python) = python() else {
        let reason =
            "needs Python with eclipse-zenoh, rosbags and numpy (SLIPSTREAM_PYTHON names it)";
        return skipped(reason);
    };
    for wire in ["ros2dds", "rmw_zenoh"] {
        let folder = tempfile::tempdir().unwrap();
        let port = port();
        write_files(folder.path(), wire, port);
        let mut peer = peer(&python, folder.path(), wire, port);
        let all = [
            "run",
            "lane_change",
            "--clock",
            "wall",
            "--real",
            "robots.toml",
            "--arm",
        ];
        let out = ["--out", "real.mcap", "--set", "duration_s=9"];
        let run = command(folder.path(), &[&all[..], &out].concat())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{wire}: {said}");
        drop(peer.stdin.take());
        assert!(peer.wait().unwrap().success());
        let export = ["export", "real.mcap", "--out", "csv"];
        assert!(
            command(folder.path(), &export)
                .output()
                .unwrap()
                .status
                .success()
        );
        compare(folder.path(), wire);
    }
}

fn write_files(folder: &Path, wire: &str, port: u16) {
    let [v, w, a, alpha] = LIMITS;
    let text = format!(
        "format = 1\nwire = \"{wire}\"\ndomain = 7\nconnect = \"tcp/127.0.0.1:{port}\"\n[limits]\nspeed_m_s = {v}\n\
         yaw_rate_rad_s = {w}\nacceleration_m_s2 = {a}\nyaw_acceleration_rad_s2 = {alpha}\n[robots.r1]\nmodel = \"tb.toml\"\n\
         command = {{ topic = \"/tb1/cmd_vel\", type = \"geometry_msgs/msg/TwistStamped\" }}\n\
         wheels = {{ topic = \"/tb1/joint_states\", right = \"wheel_right_joint\", left = \"wheel_left_joint\" }}\n\
         pose = {{ topic = \"/vrpn/tb1/pose\" }}\n"
    );
    std::fs::write(folder.join("robots.toml"), text).unwrap();
    let model = "format = 1\n[robot]\nwheel_radius_m = 0.033\nhalf_track_m = 0.08\n";
    std::fs::write(folder.join("tb.toml"), model).unwrap();
}

fn peer(python: &str, folder: &Path, wire: &str, port: u16) -> Child {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/real/peer.py");
    let mut command = Command::new(python);
    command
        .arg(script)
        .args([&port.to_string(), wire, "peer.json"]);
    command
        .current_dir(folder)
        .stdin(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Commands and poses of the recording are those of the peer.
fn compare(folder: &Path, wire: &str) {
    let peer = read_json(&folder.join("peer.json"));
    let pairs = |key: &str| -> Vec<[f64; 2]> {
        let rows = peer[key].as_array().unwrap().iter();
        rows.map(|row| [0, 1].map(|i| row[i].as_f64().unwrap()))
            .collect()
    };
    let (heard, sent) = (pairs("heard"), pairs("sent"));
    let told = rows(&folder.join("csv/r1/command.csv"));
    assert!(told.len() > 100, "{wire}: {} commands", told.len());
    // While it stands it is told so again and again, which is recorded once.
    let moving = |all: &[[f64; 2]]| -> Vec<[f64; 2]> {
        all.iter().copied().filter(|own| *own != [0.0; 2]).collect()
    };
    let [moved, wanted] = [moving(&heard), moving(&told)];
    assert!(
        moved == wanted,
        "{wire}: {} commands of {}",
        moved.len(),
        wanted.len()
    );
    let poses = rows(&folder.join("csv/r1/pose.csv"));
    assert!(poses.len() > 300, "{wire}: {} poses", poses.len());
    let is_part = sent.windows(poses.len()).any(|part| *part == poses[..]);
    assert!(
        is_part,
        "{wire}: {} poses of {} sent",
        poses.len(),
        sent.len()
    );
    // It follows without error, so it ends in the next lane.
    let [_, y] = poses[poses.len() - 1];
    assert!((0.1..0.6).contains(&y), "{wire}: {y}");
    let attachments = peer["attachments"].as_array().unwrap();
    match wire {
        "ros2dds" => assert!(attachments.is_empty()),
        _ => {
            assert_eq!(attachments.len(), heard.len());
            let first = attachments[0].as_str().unwrap();
            assert_eq!((first.len(), &first[32..34]), (66, "10"), "{first}");
        }
    }
}

/// The first two columns after the time.
fn rows(path: &Path) -> Vec<[f64; 2]> {
    let text = std::fs::read_to_string(path).unwrap();
    let row = |line: &str| {
        let mut cells = line.split(',').skip(1).map(|own| own.parse().unwrap());
        [cells.next().unwrap(), cells.next().unwrap()]
    };
    text.lines().skip(1).map(row).collect()
}
