//! Other programs read our files: the Python packages `mcap`, `mcap-ros2-support` and `rosbags`, which
//! this test installs into its own environment.
//!
//! Without Python the tests are skipped with a message; if `CI` is set, they fail.

#![expect(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

#[path = "external/python.rs"]
mod python;

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};
use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Pose, Recording, Robot, Stream};
use slipstream_recording::run_writer::{
    Attachment, Fate, PositionRecord, RunHeader, RunWriter, WheelContact,
};

/// The content of the file according to the Python packages; `None` if they are not available.
fn read_with_python(file: &Path) -> Option<Value> {
    let printed = python::script("read_bag.py", &[file])?;
    Some(serde_json::from_str(&printed).unwrap())
}

/// The only message of a topic.
fn message<'a>(content: &'a Value, topic: &str) -> &'a Value {
    let messages = content["mcap"]["messages"].as_array().unwrap();
    let mut of_topic = messages.iter().filter(|m| m["topic"] == topic);
    let found = of_topic
        .next()
        .unwrap_or_else(|| panic!("no message on {topic}"));
    assert!(of_topic.next().is_none(), "{topic}: more than one message");
    found
}

fn run_header() -> RunHeader {
    RunHeader {
        description: Recording {
            name: "a run".to_owned(),
            robots: vec![Robot::named("r1"), Robot::named("r2")],
            model: Some(RobotModel::paper_with_slip()),
            ..Recording::default()
        },
        attachments: vec![Attachment {
            name: "experiment.toml".to_owned(),
            media_type: "application/toml".to_owned(),
            data: b"duration_s = 15.0\n".to_vec(),
        }],
        metadata: BTreeMap::from([("seed".to_owned(), "7".to_owned())]),
        ..RunHeader::default()
    }
}

/// One message of each kind, all at 1.25 s.
fn write_run(file: &Path) {
    let t_ns = 1_250_000_000;
    let mut run = RunWriter::create(file, &run_header()).unwrap();
    run.write_torque_command(0, t_ns, [0.125, -0.5]).unwrap();
    run.write_encoders(0, t_ns, [-1856, 9_007_199_254_740_993])
        .unwrap();
    run.write_wheels(0, t_ns, [1.5, 2.5], [3.5, 4.5]).unwrap();
    run.write_camera(0, t_ns, [1.0, 2.0, std::f64::consts::FRAC_PI_2])
        .unwrap();
    run.write_imu(0, t_ns, [0.1, 0.2, 0.3]).unwrap();
    run.write_odometry(0, t_ns, [4.0, 5.0, 0.0], [0.6, 0.7])
        .unwrap();
    run.write_truth(1, t_ns, [7.0, 8.0, 0.0], [0.9, 0.01, 0.02])
        .unwrap();
    run.write_true_poses(t_ns, &[[1.0, 2.0, 0.0], [3.0, 4.0, 0.0]])
        .unwrap();
    let contact = WheelContact {
        slips: true,
        slip_longitudinal_m_s: 0.05,
        slip_lateral_m_s: -0.01,
        normal_force_n: 5.0,
        applied_torque_nm: 0.12,
    };
    run.write_contact(
        0,
        t_ns,
        [
            contact,
            WheelContact {
                slips: false,
                ..contact
            },
        ],
    )
    .unwrap();
    run.write_position(&PositionRecord {
        sender: "r1",
        receiver: "r2",
        seq: 42,
        t_sampled_ns: 1_240_000_000,
        t_sent_ns: t_ns,
        fate: Fate::Arrived {
            t_received_ns: 1_330_000_000,
        },
        pose: [1.0, 2.0, 0.3],
        velocity: Some([0.4, 0.5]),
        extra: &[0.5],
    })
    .unwrap();
    run.write_trace(t_ns, &[1, 2, 255]).unwrap();
    run.write_event(t_ns, "r1", "missed a deadline").unwrap();
    run.finish().unwrap();
}

#[test]
#[expect(clippy::too_many_lines, reason = "one file, every message type")]
fn other_programs_read_every_message_of_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    write_run(&file);
    let Some(content) = read_with_python(&file) else {
        return;
    };
    let bag = &content["mcap"];
    assert_eq!(bag["profile"], "ros2");
    assert_eq!(bag["indexed_messages"], 12);
    assert_eq!(bag["chunks"], json!(["lz4"]));
    assert_eq!(bag["attachments"]["experiment.toml"], "duration_s = 15.0\n");
    assert!(
        bag["attachments"]["robot.toml"]
            .as_str()
            .unwrap()
            .contains("wheel_slip")
    );
    assert_eq!(bag["metadata"]["slipstream"]["seed"], "7");

    let command = message(&content, "/r1/command");
    assert_eq!(command["type"], "sensor_msgs/msg/JointState");
    assert_eq!(command["log_time"], 1_250_000_000);
    assert_eq!(
        command["message"]["header"]["stamp"],
        json!({"sec": 1, "nanosec": 250_000_000})
    );
    assert_eq!(
        command["message"]["name"],
        json!(["wheel_right", "wheel_left"])
    );
    assert_eq!(command["message"]["effort"], json!([0.125, -0.5]));
    let ticks = &message(&content, "/r1/encoder_ticks")["message"];
    assert_eq!(
        (&ticks["right"], &ticks["left"]),
        (&json!(-1856), &json!(9_007_199_254_740_993_i64))
    );
    let wheels = &message(&content, "/r1/joint_states")["message"];
    assert_eq!(
        (&wheels["position"], &wheels["velocity"]),
        (&json!([1.5, 2.5]), &json!([3.5, 4.5]))
    );
    let pose = message(&content, "/r1/pose");
    assert_eq!(pose["type"], "geometry_msgs/msg/PoseStamped");
    let pose = &pose["message"]["pose"];
    assert_eq!(pose["position"], json!({"x": 1.0, "y": 2.0, "z": 0.0}));
    let half = std::f64::consts::FRAC_PI_4;
    assert_eq!(
        pose["orientation"],
        json!({"x": 0.0, "y": 0.0, "z": half.sin(), "w": half.cos()})
    );
    let imu = &message(&content, "/r1/imu")["message"];
    assert_eq!(
        imu["linear_acceleration"],
        json!({"x": 0.1, "y": 0.2, "z": 0.0})
    );
    assert_eq!(imu["angular_velocity"]["z"], 0.3);
    let odometry = &message(&content, "/r1/odometry")["message"];
    assert_eq!(odometry["twist"]["twist"]["linear"]["x"], 0.6);
    assert_eq!(odometry["pose"]["covariance"].as_array().unwrap().len(), 36);
    let truth = &message(&content, "/r2/truth")["message"];
    assert_eq!(truth["pose"]["pose"]["position"]["y"], 8.0);
    let transforms = &message(&content, "/tf")["message"]["transforms"];
    assert_eq!(transforms[1]["child_frame_id"], "r2");
    assert_eq!(transforms[1]["transform"]["translation"]["x"], 3.0);
    let contact = &message(&content, "/r1/contact")["message"];
    assert_eq!(
        (&contact["right"]["state"], &contact["left"]["state"]),
        (&json!(1), &json!(0))
    );
    assert_eq!(contact["left"]["applied_torque_nm"], 0.12);
    let position = &message(&content, "/links")["message"];
    assert_eq!(
        (&position["sender"], &position["seq"]),
        (&json!("r1"), &json!(42))
    );
    assert_eq!(position["t_received_ns"], 1_330_000_000);
    assert_eq!(position["w_rad_s"], 0.5);
    assert_eq!(
        message(&content, "/trace")["message"]["postcard"],
        json!([1, 2, 255])
    );
    assert_eq!(
        message(&content, "/events")["message"]["text"],
        "missed a deadline"
    );

    let counts = content["rosbags"]["counts"].as_object().unwrap();
    assert_eq!(counts.len(), 12, "{counts:?}");
    assert_eq!(content["rosbags"]["stamps_agree"], true);
}

#[test]
fn other_programs_read_an_imported_stream() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bag.mcap");
    let mut robot = Robot::named("r1");
    robot.pose = Some(Stream {
        t_s: vec![0.077_866, 0.1 + 0.2],
        values: Pose {
            x_m: vec![0.5, f64::NAN],
            y_m: vec![1.5, 2.5],
            yaw_rad: Some(vec![-0.9339, 7.3]),
        },
        unknown: Vec::new(),
    });
    let recording = Recording {
        robots: vec![robot],
        ..Recording::default()
    };
    slipstream_recording::write_mcap(&recording, &file).unwrap();
    let Some(content) = read_with_python(&file) else {
        return;
    };
    let of = |topic: &str| -> Vec<Value> {
        let messages = content["mcap"]["messages"].as_array().unwrap();
        let of_topic = messages.iter().filter(|m| m["topic"] == topic);
        of_topic.map(|m| m["message"].clone()).collect()
    };
    let poses = of("/r1/pose");
    assert_eq!(
        poses[0]["header"]["stamp"],
        json!({"sec": 0, "nanosec": 77_866_000})
    );
    assert_eq!(poses[1]["pose"]["position"]["x"], "NaN");
    let rows = of("/r1/pose/rows");
    assert_eq!(rows[0]["numbers"], json!([0.5, 1.5, -0.9339]));
    assert_eq!(rows[1]["t_s"], 0.1 + 0.2);
    assert_eq!(rows[1]["numbers"], json!(["NaN", 2.5, 7.3]));
}
