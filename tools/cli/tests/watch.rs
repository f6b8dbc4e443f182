//! `slipstream watch` and `slipstream trial --on RECORDING --watch` on the command line: a small simulated robot, one of whose
//! wheels grows while it drives, whose streams stop, or that stands.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant};

use common::schemas::violations;
use common::viewer::{Socket, connected};
use common::{command, read_json, slipstream};
use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::Message;

/// Radii (right, left), half track and place of the camera of a robot whose model has 0.05, 0.05, 0.12 and none (m).
const RADII_M: [f64; 2] = [0.048, 0.049];
const HALF_TRACK_M: f64 = 0.126;
const CAMERA_M: [f64; 2] = [0.1, 0.02];
/// Factor of the right wheel where it grows, and since when (s).
const GROWN: f64 = 1.05;
const GROWN_S: f64 = 4.0;
/// It stands for so long at first (s).
const STANDS_S: f64 = 2.0;

/// A drive.
#[derive(Clone, Copy)]
struct Drive {
    name: &'static str,
    seconds: u32,
    /// Whether the right wheel grows.
    grows: bool,
    moves: bool,
    /// Draws the noise of the camera.
    seed: f64,
}

const MONDAY: Drive = Drive {
    name: "monday",
    seconds: 16,
    grows: false,
    moves: true,
    seed: 0.0,
};

const TODAY: Drive = Drive {
    name: "today",
    seconds: 12,
    seed: 0.11,
    ..MONDAY
};

/// It ends before a diagnosis of the change is due.
const GROWS: Drive = Drive {
    name: "grows",
    seconds: 9,
    grows: true,
    ..TODAY
};

impl Drive {
    /// Surge (m/s) and yaw rate (rad/s) at a time (s), as the wheels of the baseline would have it.
    fn speeds(self, t_s: f64) -> [f64; 2] {
        if !self.moves || t_s < STANDS_S {
            return [0.0; 2];
        }
        let turn = 0.8 * (0.5 * t_s).sin() + 0.3 * (2.7 * t_s).cos();
        [0.3 + 0.15 * (0.9 * t_s).sin(), turn]
    }

    /// Rows of the wheels at 25 Hz, and of the camera at 10 Hz with 2 mm and 4 mrad.
    fn rows(self) -> [String; 2] {
        let noise = |k: f64| 2.0 * ((k * 12.9898).sin() * 43758.5453).rem_euclid(1.0) - 1.0;
        let mut wheels = "t_s,angle_right_rad,angle_left_rad\n".to_owned();
        let mut poses = "t_s,x_m,y_m,yaw_rad\n".to_owned();
        let (mut angles, [mut x, mut y, mut yaw]) = ([0.0_f64; 2], [0.0, 0.0, 0.2_f64]);
        for k in 0..1000 * self.seconds {
            let t_s = f64::from(k) * 1e-3;
            let (sin, cos) = yaw.sin_cos();
            if k % 40 == 0 {
                let _ = writeln!(wheels, "{t_s:.3},{:.9},{:.9}", angles[0], angles[1]);
            }
            if k % 100 == 0 {
                let noise = [0.0, 0.3, 0.7].map(|part| noise(f64::from(k) + part + self.seed));
                let at_x = x + CAMERA_M[0] * cos - CAMERA_M[1] * sin + 2e-3 * noise[0];
                let at_y = y + CAMERA_M[0] * sin + CAMERA_M[1] * cos + 2e-3 * noise[1];
                let seen = yaw + 4e-3 * noise[2];
                let _ = writeln!(poses, "{t_s:.3},{at_x:.6},{at_y:.6},{seen:.6}");
            }
            let [v, w] = self.speeds(t_s);
            let turned = [v + HALF_TRACK_M * w, v - HALF_TRACK_M * w];
            let turned = [0, 1].map(|i| 1e-3 * turned[i] / RADII_M[i]);
            angles = [0, 1].map(|i| angles[i] + turned[i]);
            let factor = if self.grows && t_s >= GROWN_S {
                GROWN
            } else {
                1.0
            };
            let ways = [factor * RADII_M[0] * turned[0], RADII_M[1] * turned[1]];
            let (way, turn) = (
                (ways[0] + ways[1]) / 2.0,
                (ways[0] - ways[1]) / (2.0 * HALF_TRACK_M),
            );
            let middle = yaw + turn / 2.0;
            (x, y, yaw) = (x + way * middle.cos(), y + way * middle.sin(), yaw + turn);
        }
        [wheels, poses]
    }

    /// Writes the recording.
    fn write(self, folder: &Path) {
        self.write_rows(folder, self.rows());
    }

    fn write_rows(self, folder: &Path, [wheels, poses]: [String; 2]) {
        let recording = folder.join(self.name);
        std::fs::create_dir_all(recording.join("r1")).unwrap();
        std::fs::write(recording.join("r1/wheels.csv"), wheels).unwrap();
        std::fs::write(recording.join("r1/pose.csv"), poses).unwrap();
        let about = format!(
            "format = 1\nname = \"{}\"\n[robots.r1]\npose_point = \"axle\"\n",
            self.name
        );
        std::fs::write(recording.join("recording.toml"), about).unwrap();
    }
}

/// A folder with a baseline, `monday`, a model, and a recording.
fn folder(drive: Drive) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    MONDAY.write(folder.path());
    drive.write(folder.path());
    let model = "format = 1\n[robot]\nwheel_radius_m = 0.05\nhalf_track_m = 0.12\n";
    std::fs::write(folder.path().join("robot.toml"), model).unwrap();
    folder
}

/// Arguments of a watch beside `monday`.
fn arguments<'a>(source: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [
        &[
            "watch",
            source,
            "--robot",
            "robot.toml",
            "--against",
            "monday",
        ],
        more,
    ]
    .concat()
}

/// Watches beside `monday`, which must end with this exit code; what is printed.
fn watch(folder: &TempDir, source: &str, more: &[&str], code: i32) -> String {
    let arguments = arguments(source, more);
    let output = slipstream(folder.path(), &arguments);
    let (stdout, stderr) = texts(&output);
    assert_eq!(
        output.status.code(),
        Some(code),
        "{arguments:?}: {stdout}{stderr}"
    );
    stdout
}

fn texts(output: &Output) -> (String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (text(&output.stdout), text(&output.stderr))
}

/// Lines of JSON that conform to the schema.
fn lines(text: &str) -> Vec<Value> {
    let all = text.lines().map(|line| serde_json::from_str(line).unwrap());
    let all: Vec<Value> = all.collect();
    for line in &all {
        let violations = violations("watch", line);
        assert!(violations.is_empty(), "{violations:?} in {line}");
    }
    all
}

/// Rows that a filter of their times (s) leaves.
fn kept(rows: &str, keeps: impl Fn(f64) -> bool) -> String {
    let is_kept = |line: &&str| {
        let first = line.split(',').next().unwrap_or_default();
        first.parse().map_or(true, &keeps)
    };
    rows.lines()
        .filter(is_kept)
        .fold(String::new(), |text, line| text + line + "\n")
}

#[test]
fn where_nothing_changed_nothing_is_said() {
    let folder = folder(TODAY);
    assert_eq!(
        watch(&folder, "today", &["--exit-on", "change"], 0),
        "No change.\n"
    );
    // the recording is the baseline itself: no change as a line of JSON is no line
    assert_eq!(watch(&folder, "monday", &["--json", "-"], 0), "");
}

/// The factor of the right wheel over what the baseline has, and its interval.
fn grown(change: &Value) -> (f64, [f64; 2]) {
    let parameters = change["finding"]["parameters"].as_array().unwrap();
    let right = parameters
        .iter()
        .find(|own| own["name"] == "right_scale")
        .unwrap();
    let was = right["nominal"].as_f64().unwrap();
    let over = |value: &Value| value.as_f64().unwrap() / was;
    let interval = [over(&right["ci95"][0]), over(&right["ci95"][1])];
    (over(&right["estimate"]), interval)
}

#[test]
fn a_wheel_that_grows_is_raised_and_confirmed_as_lines_of_json_alone() {
    let folder = folder(Drive {
        seconds: 17,
        ..GROWS
    });
    let (port, listen) = free_address();
    let arguments = arguments(
        "grows",
        &["--json", "-", "--exit-on", "change", "--listen", &listen],
    );
    let output = command(folder.path(), &arguments).spawn().unwrap();
    let sent = viewed(port);
    let output = output.wait_with_output().unwrap();
    let (stdout, stderr) = texts(&output);
    assert_eq!(output.status.code(), Some(3), "{stdout}{stderr}");
    let all = lines(&stdout);
    let states: Vec<&str> = all
        .iter()
        .map(|own| own["state"].as_str().unwrap())
        .collect();
    assert_eq!(states, ["raised", "confirmed"], "{stdout}");
    // the last message is sent although the watch ends with it
    assert_eq!(sent, all);
    for own in &all {
        assert_eq!(own["robot"], "r1");
        assert_eq!(own["finding"]["effect"], "wheel_radius", "{own}");
        let onset_s = own["onset_s"].as_f64().unwrap();
        assert!((onset_s - GROWN_S).abs() <= 1.0, "since {onset_s} s");
    }
    let raised_s = all[0]["t_s"].as_f64().unwrap();
    assert!(
        (GROWN_S..GROWN_S + 4.0).contains(&raised_s),
        "raised at {raised_s} s"
    );
    let (factor, [low, high]) = grown(&all[1]);
    assert!(low <= GROWN && GROWN <= high, "{factor} ({low} to {high})");
    assert!(low > 1.02, "{low}: from no change at all");
    // the schema does not accept everything
    let mut other = all[0].clone();
    other["state"] = "perhaps".into();
    assert_eq!(violations("watch", &other).len(), 1);
    let mut nothing = all[0].clone();
    nothing.as_object_mut().unwrap().remove("finding");
    assert!(!violations("watch", &nothing).is_empty());
}

/// What a viewer is sent until the server ends.
fn viewed(port: u16) -> Vec<Value> {
    let mut socket = connected(port);
    let mut sent = Vec::new();
    loop {
        match socket.read() {
            Ok(Message::Text(text)) => {
                subscribe(&mut socket, &serde_json::from_str(&text).unwrap())
            }
            // opcode, subscription, time, bytes
            Ok(Message::Binary(bytes)) if bytes[0] == 1 => {
                sent.push(serde_json::from_slice(&bytes[13..]).unwrap());
            }
            Ok(_) => {}
            Err(_) => return sent,
        }
    }
}

fn subscribe(socket: &mut Socket, said: &Value) {
    for channel in said["channels"].as_array().into_iter().flatten() {
        assert_eq!(channel["topic"], "/slipstream/changes");
        let wish =
            json!({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": channel["id"]}]});
        socket.send(Message::text(wish.to_string())).unwrap();
    }
}

/// A port where nobody listens, and its address.
fn free_address() -> (u16, String) {
    let port = free_port();
    (port, format!("127.0.0.1:{port}"))
}

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

/// The same rows lead to the same bytes; a viewer is sent what the file has.
#[test]
fn a_replay_says_the_same_every_time_and_to_a_viewer() {
    let folder = folder(GROWS);
    let first = watch(&folder, "grows", &["--json", "first.jsonl"], 0);
    let (port, listen) = free_address();
    let arguments = arguments("grows", &["--json", "again.jsonl", "--listen", &listen]);
    let again = command(folder.path(), &arguments).spawn().unwrap();
    let sent = viewed(port);
    let again = again.wait_with_output().unwrap();
    assert_eq!(texts(&again).0, first);
    assert!(first.contains("s, robot r1: since 4."), "{first}");
    assert!(first.contains("the right wheel is"), "{first}");
    let files =
        ["first.jsonl", "again.jsonl"].map(|own| std::fs::read(folder.path().join(own)).unwrap());
    assert!(files[0] == files[1], "other bytes");
    let of_file = lines(&String::from_utf8(files[0].clone()).unwrap());
    assert!(!of_file.is_empty());
    assert_eq!(sent, of_file);
}

#[test]
fn the_check_of_the_morning_is_green_or_says_the_change() {
    let folder = folder(TODAY);
    let green = watch(
        &folder,
        "today",
        &["--once", "10s", "--exit-on", "change"],
        0,
    );
    assert_eq!(green, "No change since monday, in 10 s of driving.\n");
    Drive {
        name: "flat",
        ..TODAY
    }
    .write_rows(folder.path(), flat());
    let once = [
        "--once",
        "10s",
        "--exit-on",
        "change",
        "--json",
        "once.jsonl",
    ];
    let changed = watch(&folder, "flat", &once, 3);
    assert!(
        changed.contains("the right wheel is") && changed.contains("% larger"),
        "{changed}"
    );
    let text = std::fs::read_to_string(folder.path().join("once.jsonl")).unwrap();
    let all = lines(&text);
    assert_eq!(all.len(), 1, "{text}");
    let (factor, [low, high]) = grown(&all[0]);
    assert!(low <= GROWN && GROWN <= high, "{factor} ({low} to {high})");
    // half of these seconds were before the change: no effect explains both halves
    GROWS.write(folder.path());
    let more = ["--once", "10s", "--exit-on", "change"];
    let changed = watch(&folder, "grows", &more, 4);
    assert!(changed.starts_with("Unexplained: "), "{changed}");
}

/// Rows of a robot whose wheel had grown before they begin.
fn flat() -> [String; 2] {
    Drive {
        seconds: 17,
        ..GROWS
    }
    .rows()
    .map(|rows| kept(&rows, |t_s| t_s >= GROWN_S))
}

/// A stream that stops is said as a fault, and as no physics.
#[test]
fn a_stream_that_stops_is_a_fault() {
    let folder = folder(TODAY);
    let [wheels, poses] = TODAY.rows();
    let stops = |rows: &str| kept(rows, |t_s| t_s < 6.0);
    let pauses = |rows: &str| kept(rows, |t_s| !(5.0..8.0).contains(&t_s));
    for (stream, ids, rows) in [
        (
            "pose",
            &["stream_silent", "stream_back"][..],
            [wheels.clone(), pauses(&poses)],
        ),
        (
            "wheels",
            &["stream_silent"],
            [stops(&wheels), poses.clone()],
        ),
    ] {
        TODAY.write_rows(folder.path(), rows);
        let all = lines(&watch(
            &folder,
            "today",
            &["--json", "-", "--exit-on", "change"],
            0,
        ));
        let found: Vec<&str> = all
            .iter()
            .map(|own| own["warning"]["id"].as_str().unwrap_or("physics"))
            .collect();
        assert_eq!(found, ids, "{stream}: {all:?}");
        let statement = all[0]["warning"]["statement"].as_str().unwrap();
        assert!(
            statement.starts_with(&format!("{stream}: no row for ")),
            "{statement}"
        );
    }
}

/// Runs a watch that must be refused with exit code 2 and one line that contains `expected`.
fn assert_refused(folder: &TempDir, arguments: &[&str], expected: &str) {
    let output = slipstream(folder.path(), arguments);
    let (stdout, stderr) = texts(&output);
    assert_eq!(
        output.status.code(),
        Some(2),
        "{arguments:?}: {stdout}{stderr}"
    );
    assert_eq!(
        stderr.trim_end().lines().count(),
        1,
        "{arguments:?}: {stderr}"
    );
    assert!(stderr.contains(expected), "no {expected:?} in {stderr}");
    assert!(stdout.is_empty(), "{arguments:?}: {stdout}");
}

#[test]
fn what_cannot_be_watched_is_refused_in_a_line() {
    let folder = folder(TODAY);
    let refused = |source: &str, more: &[&str], expected: &str| {
        assert_refused(&folder, &arguments(source, more), expected);
    };
    for speed in ["0", "NaN", "inf"] {
        refused(
            "today",
            &["--speed", speed],
            "is no speed; give a number above 0",
        );
    }
    refused("nothing", &[], "nothing: ");
    refused("today", &["--against", "nothing"], "nothing: ");
    let nobody = format!("ws://127.0.0.1:{}", free_port());
    refused(&nobody, &[], "cannot be connected to");
    refused("today", &["--listen", "nowhere"], "nowhere");
    refused(
        "today",
        &["--json", "nowhere/changes.jsonl"],
        "nowhere/changes.jsonl",
    );
    let without = ["watch", "today", "--robot", "robot.toml"];
    let expected =
        "today: ends before 60 s, which are the baseline; give a baseline with --against";
    assert_refused(&folder, &without, expected);
    assert_refused(
        &folder,
        &["watch", "today", "--against", "monday"],
        "has no model; give one with --robot",
    );
    let late = "0.400,0,0,0";
    let [wheels, poses] = TODAY.rows();
    TODAY.write_rows(folder.path(), [wheels, poses + late + "\n"]);
    refused("today", &[], "t_s runs backwards");
}

#[test]
fn a_robot_that_stands_says_nothing_and_is_no_baseline() {
    let folder = folder(Drive {
        name: "stands",
        moves: false,
        ..TODAY
    });
    assert_eq!(watch(&folder, "stands", &[], 0), "No change.\n");
    let as_baseline = [
        "watch",
        "monday",
        "--robot",
        "robot.toml",
        "--against",
        "stands",
    ];
    assert_refused(&folder, &as_baseline, "r1: has nothing to compare");
    let learnt = ["watch", "stands", "--robot", "robot.toml", "--learn", "5s"];
    assert_refused(&folder, &learnt, "r1: has nothing to compare");
}

#[test]
fn a_trial_of_changes_that_begin_while_a_robot_drives_conforms() {
    let folder = folder(TODAY);
    let trial = [
        "trial",
        "--on",
        "monday",
        "--watch",
        "--robot",
        "robot.toml",
        "--json",
        "trial.json",
    ];
    let output = slipstream(folder.path(), &trial);
    let (stdout, stderr) = texts(&output);
    assert!(output.status.success(), "{stderr}");
    let mut answer = read_json(&folder.path().join("trial.json"));
    let found = violations("watch-trial", &answer);
    assert!(found.is_empty(), "{found:?}");
    let cases = answer["cases"].as_array().unwrap();
    assert!(
        stdout.contains(&format!("before {} changes", cases.len())),
        "{stdout}"
    );
    let large = cases.iter().filter(|own| own["multiple"] == 8.0);
    let raised = large
        .clone()
        .filter(|own| own["delay_s"].is_number())
        .count();
    assert!(raised > 0 && 2 * raised >= large.count(), "{stdout}");
    // the schema does not accept everything
    answer["heard_s"] = "long".into();
    assert_eq!(violations("watch-trial", &answer).len(), 1);
    let alone = ["trial", "--watch"];
    assert_eq!(slipstream(folder.path(), &alone).status.code(), Some(2));
}

/// A platoon on the wall clock whose link from r1 to r2 becomes slower within the run.
const PLATOON: &str = "base = \"platoon\"
duration_s = 14
[profile]
times_s = [0.0, 2.0, 12.0, 14.0]
speeds_m_s = [0.0, 0.3, 0.3, 0.0]
yaw_rates_rad_s = [0.0, 0.1, 0.1, 0.0]
[links]
protocol = \"periodic\"
delay_s = 0.05
[sensors.camera]
rate_hz = 20.0
";
const SLOWER: &str = "changes=[{at_s=6, link='r1 to r2', delay_s=0.25}]";
/// The run takes 14 s; a busy machine may be late by much more.
const LIVE_TIMEOUT: Duration = Duration::from_secs(400);

/// A link that becomes slower is named while the platoon drives.
#[test]
fn a_live_platoon_has_its_slow_link_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("platoon.toml"), PLATOON).unwrap();
    let baseline = [
        "run",
        "platoon.toml",
        "--in-process",
        "--out",
        "baseline.mcap",
    ];
    assert!(slipstream(folder.path(), &baseline).status.success());
    let (port, listen) = free_address();
    let run = [
        &[
            "run",
            "platoon.toml",
            "--clock",
            "wall",
            "--live",
            &listen,
            "--live-wait",
        ][..],
        &["--set", SLOWER, "--out", "live.mcap"],
    ];
    let run = command(folder.path(), &run.concat()).spawn().unwrap();
    let began = Instant::now();
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(began.elapsed() < LIVE_TIMEOUT, "nobody listens");
        std::thread::sleep(Duration::from_millis(20));
    }
    let source = format!("ws://127.0.0.1:{port}");
    let watch = [
        "watch",
        &source,
        "--against",
        "baseline.mcap",
        "--json",
        "-",
    ];
    let mut watch = command(folder.path(), &watch).spawn().unwrap();
    let output = BufReader::new(watch.stdout.take().unwrap());
    let (sender, heard) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        output
            .lines()
            .map_while(Result::ok)
            .try_for_each(|own| sender.send(own))
    });
    let mut states = Vec::new();
    while states.last().is_none_or(|own| own != "confirmed") {
        let left = LIVE_TIMEOUT.saturating_sub(began.elapsed());
        let line = heard.recv_timeout(left).expect("a line about the link");
        let own = &lines(&line)[0];
        let finding = &own["finding"];
        if finding["effect"] != "link_delay" || finding["where"]["condition"] != "link r1 to r2" {
            continue;
        }
        assert_eq!(own["robot"], "r2");
        let onset_s = own["onset_s"].as_f64().unwrap();
        assert!((onset_s - 6.0).abs() <= 1.0, "since {onset_s} s");
        let delay_s = finding["parameters"][0]["estimate"].as_f64().unwrap();
        assert!((delay_s - 0.25).abs() < 0.05, "{delay_s} s");
        states.push(own["state"].as_str().unwrap().to_owned());
    }
    assert_eq!(states, ["raised", "confirmed"]);
    watch.kill().unwrap();
    watch.wait().unwrap();
    let output = run.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", texts(&output).1);
}

/// A robot on torques whose load becomes larger within its second minute.
const LOADED: &str = "base = \"platoon\"
duration_s = 40
[profile]
times_s = [0, 1, 4, 7, 10, 13, 16, 19, 22, 25, 28, 31, 34, 37, 40]
speeds_m_s = [0, 0.3, 0.2, 0.35, 0.2, 0.4, 0.2, 0.35, 0.2, 0.4, 0.25, 0.4, 0.2, 0.4, 0.3]
yaw_rates_rad_s = [0, 0, 0.4, -0.3, 0.5, 0.2, -0.5, 0.4, 0.3, -0.4, 0.5, 0.2, 0.3, -0.2, 0]
";
const LOAD: &str =
    "changes=[{at_s=20, robot='r1', effect='payload', mass_kg=0.4, x_m=0.0, y_m=0.0}]";

/// A load that is put on while a robot drives by torques is named with its mass.
#[test]
fn a_load_on_a_robot_that_is_told_torques_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("loaded.toml"), LOADED).unwrap();
    let run = [
        "run",
        "loaded.toml",
        "--robots",
        "1",
        "--in-process",
        "--out",
    ];
    let before = [&run[..], &["before.mcap", "--seed", "7"]].concat();
    assert!(slipstream(folder.path(), &before).status.success());
    let after = [&run[..], &["after.mcap", "--seed", "8", "--set", LOAD]].concat();
    assert!(slipstream(folder.path(), &after).status.success());
    let watch = [
        "watch",
        "after.mcap",
        "--against",
        "before.mcap",
        "--json",
        "-",
    ];
    let (stdout, stderr) = texts(&slipstream(folder.path(), &watch));
    let all = lines(&stdout);
    let first = all
        .first()
        .unwrap_or_else(|| panic!("nothing is said: {stderr}"));
    let number = |own: &Value| own.as_f64().unwrap();
    assert!((number(&first["onset_s"]) - 20.0).abs() <= 3.0, "{stdout}");
    assert!(number(&first["t_s"]) <= 23.0, "{stdout}");
    let mut confirmed = all.iter().filter(|own| own["state"] == "confirmed");
    let load = confirmed.find(|own| own["finding"]["effect"] == "payload");
    let load = load.unwrap_or_else(|| panic!("no load is confirmed: {stdout}"));
    let parameters = load["finding"]["parameters"].as_array().unwrap();
    let mass = parameters
        .iter()
        .find(|own| own["name"] == "mass_kg")
        .unwrap();
    let mass_kg = number(&mass["estimate"]);
    assert!((mass_kg - 0.4).abs() < 0.1, "{mass_kg} kg");
}
