//! Writes the seeds of all fuzz targets into `tests/fuzz/seeds`: small real inputs, from a run of
//! two robots. Seeds that were found by fuzzing (`found-…`) stay as they are.
//!
//!     cargo run -p slipstream-fuzz --example seeds

#![expect(
    clippy::unwrap_used,
    reason = "a program for developers, which stops at what it does not expect"
)]

use std::path::Path;

use mcap::{MessageStream, WriteOptions};
use serde::Serialize;
use slipstream_agents::process::AgentOutcome;
use slipstream_bus::message::{DriveCommand, Encoders, Position};
use slipstream_bus::record::{Record, Recorder};
use slipstream_bus::{Parameter, RobotModel};
use slipstream_fuzz::{FILES, MAP, SEPARATOR, SOURCES};
use slipstream_hosts::clock::{ClockReport, Stamps};
use slipstream_hosts::frame::{
    AgentState, Answer, Batch, Down, End, LeftFile, Measured, News, Report, Round, Sent, Up,
};
use slipstream_hosts::hello::{Hello, Welcome};
use slipstream_ipc::clock::RealTime;
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::record_pipe::Entry;
use slipstream_launch::recorder::RecorderOutcome;
use slipstream_launch::resolve::BUILT_IN;
use slipstream_launch::{Request, Resolved, in_process, resolve};
use slipstream_recording::{
    Map, TopicMap, read_mapped, read_trace, recording_toml, robot_toml, write_folder,
};
use slipstream_sim::effects::{CATALOGUE, Domain};
use slipstream_sim::run::process::PlantOutcome;

/// A map of columns and a file for it.
const COLUMNS: &str = "format = 1\n[robots.r1]\nencoder_counts_per_rev = 100\n[robots.r1.wheels]\n\
    t_s = { column = \"ms\", factor = 0.001 }\nticks_right = \"r\"\nticks_left = \"l\"\n[robots.r1.pose]\n\
    t_s = \"t\"\nx_m = { column = 5, offset = -1 }\ny_m = \"y\"\n%%ms,r,l,t,x,y\n1700000000000.5,1,2,,,\n\
    1700000000100,3,4,1700000000.25,1.5,NaN\n,,,1700000001,2,3\n";

/// Text files without a map.
const TEXTS: [(&str, &str); 6] = [
    (
        "trajectory",
        "# timestamp tx ty tz qx qy qz qw\n1700000000.5 0 0 0 0 0 0 1\n1700000000.75 1.5 -2 0 0 0 0.6 0.8\n",
    ),
    (
        "camera",
        "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 -1 -1 0 1 0 0 1 0 0 2\n",
    ),
    (
        "echo",
        "%time,field.header.stamp,field.pose.pose.position.x,field.pose.pose.position.y,field.pose.pose.orientation.z,\
         field.pose.pose.orientation.w,field.twist.twist.linear.x,field.twist.twist.angular.z\n\
         1700000009000000000,1700000000500000000,0,0,0,1,0,0\n1700000009300000000,1700000000600000000,1,2,0.6,0.8,0.5,-0.25\n",
    ),
    (
        "message",
        "10,0,map,1,2,0,0,0,0,1\n10,500000000,map,3,4,0,0,0,1,0\n",
    ),
    (
        "robots",
        "Version,1.2,of me\nt,r1_x,r1_y,r1_yaw,r2_encL,r2_encR,r2_vBat\ns,mm,mm,deg,,,mV\n0,1,2,3,4,5,6\n1,2,3,4,5,6,7\n2,3",
    ),
    (
        "by_hand",
        "Time;x_mm;y_mm;heading_deg;left_rpm;right_rpm\n2024-05-01 23:59:59,5;0;0;0;0;0\n2024-05-02 00:00:00,0;1500,5;-20;90;60;30\n",
    ),
];

/// A log of SysId.
const SYSID: &str = r#"{"fast-forward": [[2.0, 7, 7.5, 1, 2, 10, 20, 0.1, 0.25], [2.02, 7, 7.5, 1.5, 2.5, 10, 20, 0.2, 0.5]],
"slow-forward": [[1.0, 12, 0.5, 0.1, 0.2, 0, 0.5, 0, 0, 0]], "sysid": true, "test": "Drivetrain", "units": "Meters", "unitsPerRotation": 0.5}"#;

/// A data log of WPILib: a pose, speeds and a number, two of each.
fn wpilog() -> Vec<u8> {
    let mut log = b"WPILOG\x00\x01\x00\x00\x00\x00".to_vec();
    let mut record = |entry: u8, t_us: u32, data: &[u8]| {
        let length = u16::try_from(data.len()).unwrap();
        log.extend([0b0011_0100, entry]);
        log.extend(length.to_le_bytes());
        log.extend(t_us.to_le_bytes());
        log.extend(data);
    };
    let entries = [
        (1, "/vision/pose", "struct:Pose2d", 3),
        (2, "/drive/cmd", "struct:ChassisSpeeds", 3),
        (3, "/drive/left", "double", 1),
    ];
    for (entry, name, kind, _) in entries {
        let mut start = vec![0, entry, 0, 0, 0];
        for text in [name, kind, ""] {
            start.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
            start.extend(text.as_bytes());
        }
        record(0, 0, &start);
    }
    for t_us in [1_000_000, 1_020_000] {
        for (entry, _, _, numbers) in entries {
            record(entry, t_us, &0.25_f64.to_le_bytes().repeat(numbers));
        }
    }
    record(0, 1_030_000, &[1, 3, 0, 0, 0]);
    log
}

fn main() {
    let scratch = tempfile::tempdir().unwrap();
    let run = scratch.path().join("run.mcap");
    let resolved = short_run();
    in_process::summary(&resolved, Some(&run)).unwrap();
    recordings(&run);
    texts(&run);
    robots();
    processes(&resolved, &run);
    bridge_frames();
}

/// Frames as bridges send them.
fn bridge_frames() {
    let texts = [
        (
            "server",
            r#"{"op":"serverInfo","name":"robot","capabilities":["time"],"supportedEncodings":["cdr"],"metadata":{"a":"b"}}"#,
        ),
        (
            "advertise",
            r#"{"op":"advertise","channels":[{"id":1,"topic":"/odom","encoding":"cdr","schemaName":"nav_msgs/msg/Odometry","schemaEncoding":"ros2msg","schema":"std_msgs/Header header\n","metadata":{"stream":"r1/odometry"}}]}"#,
        ),
        ("unadvertise", r#"{"op":"unadvertise","channelIds":[1,2]}"#),
        (
            "status",
            r#"{"op":"status","level":2,"message":"no such channel"}"#,
        ),
    ];
    for (name, text) in texts {
        seed("bridge_frame", name, text.as_bytes());
    }
    let message = [&[1, 7, 0, 0, 0][..], &5_u64.to_le_bytes(), b"message"].concat();
    seed("bridge_frame", "message", &message);
}

/// Writes a seed.
fn seed(target: &str, name: &str, content: &[u8]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("seeds")
        .join(target);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(name), content).unwrap();
}

/// Two robots for 0.12 s, with all sensors and a lossy link.
fn short_run() -> Resolved {
    let set = [
        ("duration_s", "0.12"),
        ("formation.start_s", "0"),
        ("links.protocol", "periodic"),
        ("links.delay_s", "0.01"),
        ("links.loss", "0.2"),
        ("sensors.camera.rate_hz", "30"),
        ("sensors.imu.rate_hz", "50"),
    ];
    let set = set.map(|(key, value)| (key.to_owned(), value.to_owned()));
    resolve(&Request {
        robots: Some(2),
        set: set.to_vec(),
        ..Request::default()
    })
    .unwrap()
}

fn recordings(run: &Path) {
    let content = std::fs::read(run).unwrap();
    seed("mcap", "run", &content);
    seed("mcap", "run_plain", &plain(&content, false));
    let import = read_mapped(run, &Map::None).unwrap();
    let folder = run.with_file_name("folder");
    write_folder(&import.recording, &folder).unwrap();
    std::fs::write(folder.join("rtt.csv"), "seq,rtt_ms\n1,12.5\n2,\n3,0.75\n").unwrap();
    let files = FILES.map(|name| std::fs::read(folder.join(name)).unwrap_or_default());
    seed("csv_folder", "run", &files.join(&SEPARATOR[..]));
    seed("round_trips", "three", &files[FILES.len() - 1]);
    let mut own = Vec::new();
    let with_round_trips = read_mapped(&folder, &Map::None).unwrap().recording;
    own.extend(slipstream_recording::mcap_bytes(&with_round_trips, run).unwrap());
    seed("mcap", "folder_plain", &plain(&own, false));
    seed("bag", "run_plain", &plain(&content, true));
    seed("foreign_csv", "two_streams", COLUMNS.as_bytes());
    for (name, text) in TEXTS {
        seed("text_file", name, text.as_bytes());
    }
    seed("sysid_json", "two_runs", SYSID.as_bytes());
    seed("wpilog", "two_entries", &wpilog());
    let foreign = run.with_file_name("foreign.mcap");
    std::fs::write(&foreign, plain(&content, true)).unwrap();
    let guessed = read_mapped(&foreign, &Map::None).unwrap().guesses.remove(0);
    let (_, map) = guessed.split_once('\n').unwrap();
    seed("topic_map", "guessed", map.as_bytes());
    for (name, text) in [("map", MAP), ("sources", SOURCES)] {
        let map = TopicMap::parse(text, Path::new("map.toml")).unwrap();
        seed("topic_map", name, map.to_text().as_bytes());
    }
    messages();
}

/// The definition of a type and two messages, in both encodings.
fn messages() {
    let own = "uint8 LEFT=1 # a constant\nbool on\nstring name\nint64 count\nfloat32[<=4] list\nOwn[2] own\nfloat64 speed\n\
        ====\nMSG: base_msgs/Own\nint16 n\n";
    let text = format!(
        "Header header\n{own}====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
    );
    let ros1 = |k: u8| {
        let parts: [&[u8]; 5] = [
            &[k, 0, 0, 0, 1, 0, 0, 0, k, 0, 0, 0, 0, 0, 0, 0],
            &[1, 2, 0, 0, 0, b'a', b'b', k, 0, 0, 0, 0, 0, 0, 0],
            &[2, 0, 0, 0, 0, 0, 128, 63, 0, 0, k, 64],
            &[k, 0, 3 * k, 0],
            &f64::from(k).to_le_bytes(),
        ];
        parts.concat()
    };
    let parts = [text.as_bytes(), &ros1(1), &ros1(2)];
    seed("message", "ros_1", &parts.join(&SEPARATOR[..]));
    let cdr = |k: u8| {
        let parts: [&[u8]; 6] = [
            &[0, 1, 0, 0],
            &[1, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 0, 0, 0, 0, 0],
            &[k, 0, 0, 0, 0, 0, 0, 0],
            &[2, 0, 0, 0, 0, 0, 128, 63, 0, 0, k, 64],
            &[k, 0, 3 * k, 0],
            &f64::from(k).to_le_bytes(),
        ];
        parts.concat()
    };
    let parts = [own.as_bytes(), &cdr(1), &cdr(2)];
    seed("message", "ros_2", &parts.join(&SEPARATOR[..]));
}

/// The file without compression, chunks and checksums, which mutations would only damage. As the
/// bag of another robot: one robot's standard messages under the topics of other drivers.
fn plain(content: &[u8], foreign: bool) -> Vec<u8> {
    let options = WriteOptions::new()
        .compression(None)
        .use_chunks(false)
        .profile("ros2");
    let mut out = std::io::Cursor::new(Vec::new());
    let mut writer = options.create(&mut out).unwrap();
    for message in MessageStream::new(content).unwrap() {
        let mut message = message.unwrap();
        let mut channel = (*message.channel).clone();
        let schema = channel.schema.as_ref().map(|schema| schema.name.clone());
        if foreign {
            let topic = match schema.as_deref() {
                Some("geometry_msgs/msg/Twist" | "geometry_msgs/msg/TwistStamped") => "/cmd_vel",
                Some("nav_msgs/msg/Odometry") => "/odom",
                Some("sensor_msgs/msg/JointState") => "/joint_states",
                Some("geometry_msgs/msg/PoseStamped") => "/vicon/robot/pose",
                Some("sensor_msgs/msg/Imu") => "/imu",
                _ => continue,
            };
            if channel.topic.contains("r2") {
                continue;
            }
            topic.clone_into(&mut channel.topic);
            channel.metadata.clear();
        }
        message.channel = channel.into();
        writer.write(&message).unwrap();
    }
    if !foreign && let Some(summary) = mcap::Summary::read(content).unwrap() {
        for index in &summary.attachment_indexes {
            let attachment = mcap::read::attachment(content, index).unwrap();
            writer.attach(&attachment).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

/// URDFs of the reader's tests, and parameters of controllers.
fn robots() {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tools/recording/tests/robot_file");
    for name in ["turtle", "terrain", "complete"] {
        let content = std::fs::read(folder.join(format!("{name}.urdf"))).unwrap();
        seed("urdf", name, &content);
        let with_controller = [&content, &SEPARATOR[..], ROS_1.as_bytes()].concat();
        seed("urdf_and_yaml", name, &with_controller);
    }
    seed("urdf", "plugin", PLUGIN.as_bytes());
    for (name, text) in [("ros_2", ROS_2), ("ros_1", ROS_1), ("node", NODE)] {
        seed("controller_yaml", name, text.as_bytes());
    }
    seed("constants", "java", CONSTANTS.as_bytes());
}

/// A URDF with a drive plugin, steering and hardware.
const PLUGIN: &str = "<robot name=\"r\"><link name=\"base\"/><link name=\"l\"/><link name=\"r\"/><link name=\"k\"/>\
<joint name=\"left\" type=\"continuous\"><parent link=\"base\"/><child link=\"l\"/><origin xyz=\"0 .1 0\"/><axis xyz=\"0 1 0\"/></joint>\
<joint name=\"right\" type=\"continuous\"><parent link=\"base\"/><child link=\"r\"/><origin xyz=\"0 -.1 0\"/><axis xyz=\"0 1 0\"/></joint>\
<joint name=\"steer\" type=\"revolute\"><parent link=\"base\"/><child link=\"k\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\"/></joint>\
<gazebo><plugin filename=\"libgazebo_ros_diff_drive.so\"><leftJoint>left</leftJoint><rightJoint>right</rightJoint>\
<wheelSeparation>0.24</wheelSeparation><wheelDiameter>0.08</wheelDiameter></plugin></gazebo>\
<ros2_control><hardware><param name=\"enc_counts_per_rev\">3436.5</param></hardware></ros2_control></robot>\n";

/// Constants in Java, C and Python.
const CONSTANTS: &str = "package frc.robot;\npublic static final double kTrackwidthMeters = Units.inchesToMeters(27) / 2 * 2; // m\n\
#define WHEEL_DIAMETER 0.152 /* m */\nconstexpr units::meter_t kWheelRadius{7.62_cm};\nINCH = 0.0254\nTRACK_WIDTH = 20 * INCH # m\n\
int COUNTS_PER_REV = 2280;\n";

/// A node that reckons itself, in millimetres, and a controller of another type.
const NODE: &str = "node:\n  ros__parameters:\n    wheels: {separation: 160, radius: 33}\n    wheel_left_joint_name: l\n    \
type: mecanum_drive_controller/MecanumDriveController\n";

/// Parameters of a controller of ROS 2, in a namespace.
const ROS_2: &str = "controller_manager:\n  ros__parameters:\n    update_rate: 100\n    base:\n      type: diff_drive_controller/DiffDriveController\n\
/a/base:\n  ros__parameters:\n    left_wheel_names: [\"lf\", \"lr\"]\n    right_wheel_names:\n      - rf\n      - rr\n    \
wheel_separation: 0.5708 # m\n    wheels_per_side: 2\n    wheel_radius: 0.1651\n    wheel_separation_multiplier: 1.875\n    \
left_wheel_radius_multiplier: 1.01\n    right_wheel_radius_multiplier: 0.99\n    pose_covariance_diagonal: &d [0.001, 0.01]\n    \
twist_covariance_diagonal: *d\n    open_loop: !!bool false\n";

/// Parameters of a controller of ROS 1.
const ROS_1: &str = "%YAML 1.2\n---\nmobile_base_controller: {type: 'diff_drive_controller/DiffDriveController',\n  left_wheel: 'l',\n  \
right_wheel: \"r\\u0020\", wheel_separation: 54e-2, wheel_radius_multiplier: 1, wheel_radius: .11}\n...\n";

fn texts(run: &Path) {
    let recording = read_mapped(run, &Map::None).unwrap().recording;
    seed(
        "recording_toml",
        "run",
        recording_toml::to_text(&recording).as_bytes(),
    );
    let paper = RobotModel::paper_with_slip();
    seed(
        "robot_toml",
        "paper",
        robot_toml::to_text(&paper).as_bytes(),
    );
    let all = robot_toml::to_text(&with_all_effects());
    seed("robot_toml", "effects", all.as_bytes());
    seed("robot_run", "paper", robot_toml::to_text(&paper).as_bytes());
    seed("robot_run", "effects", all.as_bytes());
    for name in BUILT_IN {
        let resolved = resolve(&Request {
            experiment: Some(name.to_owned()),
            ..Request::default()
        })
        .unwrap();
        let text = resolved.to_toml();
        seed(
            "experiment_file",
            name,
            format!("base = \"{name}\"\n{text}").as_bytes(),
        );
        let set = |(key, value, _): &(String, String, _)| format!("{key}={value}\n");
        let set: String = resolved.keys.iter().map(set).collect();
        seed("set_arguments", name, set.as_bytes());
    }
}

/// The paper's robot with every effect of the catalogue, each at one of its probe values.
fn with_all_effects() -> RobotModel {
    let mut model = RobotModel::default();
    for info in CATALOGUE {
        let mut spec = slipstream_bus::EffectSpec::new(info.id, &[]);
        let mut has_alternative = false;
        for parameter in info.parameters {
            if parameter.alternative && std::mem::replace(&mut has_alternative, true) {
                continue;
            }
            let value = match parameter.domain {
                Domain::Number { lower, probes, .. } => {
                    Parameter::Number(probes.first().copied().unwrap_or(lower))
                }
                Domain::Text(words) => Parameter::Text(words[0].to_owned()),
                Domain::List { .. } => Parameter::List(vec![0.0, 1.0]),
            };
            spec.parameters.push((parameter.name.to_owned(), value));
        }
        model.effects.push(spec);
    }
    model
}

/// What processes of a run exchange.
fn processes(resolved: &Resolved, run: &Path) {
    seed("experiment", "run", &encode(&resolved.experiment));
    let log = Log::default();
    let (reports, log) = in_process::run_recorded(&resolved.experiment, true, log).unwrap();
    let mut chunk = 1_u32.to_le_bytes().to_vec();
    for (kind, record) in log.0.iter().enumerate() {
        let bytes = encode(&Entry::Record(*record));
        seed(
            "record_chunk",
            &format!("record-{kind}"),
            &[&[0; 4], &bytes[..]].concat(),
        );
        chunk.extend(bytes);
    }
    let mut traces = Vec::new();
    read_trace(run, &mut |bytes| {
        traces.push(bytes.to_vec());
        true
    })
    .unwrap();
    traces.sort_by_key(Vec::len);
    let longest = traces.pop().unwrap();
    seed("trace_chunk", "longest", &longest);
    let bytes = &longest[1..];
    let length = u32::try_from(bytes.len()).unwrap().to_le_bytes();
    seed(
        "trace_buffer",
        "longest",
        &[&[0; 8], &length[..], bytes].concat(),
    );
    chunk.extend(encode(&Entry::Trace { t_ns: 5, bytes }));
    seed("record_chunk", "all", &chunk);
    let plant = PlantOutcome {
        report: reports.plant,
        ended: ProcessStatus::Done,
        deadlines: None,
        real_time: RealTime::default(),
        lost_records: 0,
        start_up_s: 0.1,
        loop_s: 0.2,
    };
    host_frames(resolved, &chunk);
    wall_clock_frames(&chunk);
    seed("reports", "plant", &[&[0], &encode(&plant)[..]].concat());
    let agent = AgentOutcome {
        report: reports.agents.into_iter().next().unwrap(),
        ended: ProcessStatus::Failed("reason".to_owned()),
        deadlines: None,
        real_time: RealTime::default(),
        lost_records: 0,
    };
    seed("reports", "agent", &[&[1], &encode(&agent)[..]].concat());
    let recorder = RecorderOutcome {
        records: 7,
        failure: Some("disk full".to_owned()),
    };
    seed(
        "reports",
        "recorder",
        &[&[2], &encode(&recorder)[..]].concat(),
    );
}

/// Frames of the lockstep, and of joining and leaving.
fn host_frames(resolved: &Resolved, chunk: &[u8]) {
    let measured = Measured {
        now_ns: 20_000_000,
        encoders: vec![(1, Encoders::default())],
    };
    let end = End {
        measured: measured.clone(),
        stopped: Some("it was stopped".to_owned()),
    };
    let round = Down::Round(Round {
        number: 2,
        measured,
        positions: vec![Position::default()],
    });
    let answer = Up::Answer(Answer {
        number: 2,
        commands: vec![DriveCommand::default()],
        positions: vec![Position::default()],
        records: vec![chunk.to_vec()],
    });
    let report = Up::Report(Report {
        files: vec![LeftFile {
            name: "report-r2".to_owned(),
            content: vec![1, 2, 3],
        }],
        records: Vec::new(),
        failure: None,
    });
    let hello = Hello {
        version: "0.1.0".to_owned(),
        name: "b".to_owned(),
    };
    let welcome = Welcome {
        run: 7,
        experiment: encode(&resolved.experiment),
        keys: resolved.to_toml(),
        robots: vec![1],
        recording: true,
    };
    for (name, kind, bytes) in [
        ("round", 0, encode(&round)),
        ("over", 0, encode(&Down::Over(end))),
        ("stop", 0, encode(&Down::Stop("r1 died".to_owned()))),
        ("ready", 1, encode(&Up::Ready(7))),
        ("answer", 1, encode(&answer)),
        ("report", 1, encode(&report)),
        ("hello", 2, encode(&hello)),
        ("welcome", 3, encode(&welcome)),
    ] {
        seed("host_frame", name, &[&[kind], &bytes[..]].concat());
    }
}

/// Frames of the wall clock.
fn wall_clock_frames(chunk: &[u8]) {
    let news = Down::News(News {
        start_ns: -5,
        measured: Measured {
            now_ns: 20_000_000,
            encoders: vec![(1, Encoders::default())],
        },
        positions: vec![Position::default()],
    });
    let time = Down::Time(Stamps {
        asked_ns: 1,
        received_ns: 2,
        sent_ns: 3,
    });
    let sent = Up::Sent(Sent {
        commands: vec![DriveCommand::default()],
        positions: vec![Position::default()],
    });
    let records = Up::Records(Batch {
        number: 3,
        records: vec![chunk.to_vec()],
    });
    let clock = Up::Clock(ClockReport {
        host_ns: 10,
        offset_ns: -20,
        bound_ns: 30,
        drift_ppb: Some(-40),
        round_trip_ns: 50,
        error_ns: 60,
    });
    let agent = AgentState {
        robot: 1,
        deaths: 2,
        deadlines: vec![[1, 2, 3, 4]; 2],
    };
    for (name, kind, bytes) in [
        ("news", 0, encode(&news)),
        ("time", 0, encode(&time)),
        ("kept", 0, encode(&Down::Kept(3))),
        ("sent", 1, encode(&sent)),
        ("records", 1, encode(&records)),
        ("ask_for_time", 1, encode(&Up::Time(9))),
        ("clock", 1, encode(&clock)),
        ("agents", 1, encode(&Up::Agents(vec![agent]))),
    ] {
        seed("host_frame", name, &[&[kind], &bytes[..]].concat());
    }
}

fn encode(value: &impl Serialize) -> Vec<u8> {
    postcard::to_allocvec(value).unwrap()
}

/// The first record of each kind.
#[derive(Default)]
struct Log(Vec<Record>);

impl Recorder for Log {
    fn record(&mut self, record: &Record) {
        let kind = std::mem::discriminant(record);
        if self
            .0
            .iter()
            .all(|known| std::mem::discriminant(known) != kind)
        {
            self.0.push(*record);
        }
    }
}
