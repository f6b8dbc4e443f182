//! A recorded run read as a recording: its streams are unchanged, and messages that a recording
//! cannot represent are counted.

use std::path::Path;

use slipstream_bus::RobotModel;
use slipstream_recording::read_mcap_from;
use slipstream_recording::recording::{Command, Recording, Robot};
use slipstream_recording::run_writer::{Fate, PositionRecord, RunHeader, RunWriter};

#[test]
#[expect(clippy::too_many_lines, reason = "one run, every stream")]
fn the_streams_of_a_run_are_read_unchanged() {
    let path = Path::new("run.mcap");
    let mut r1 = Robot::named("r1");
    r1.encoder_counts_per_rev = Some(1856.0);
    let header = RunHeader {
        description: Recording {
            name: "a run".to_owned(),
            robots: vec![r1, Robot::named("r2")],
            model: Some(RobotModel::paper_with_slip()),
            ..Recording::default()
        },
        ..RunHeader::default()
    };
    let mut bytes = Vec::new();
    let mut run = RunWriter::to_sink(&mut bytes, path, &header).unwrap();
    let position = |seq, t_sent_ns, fate| PositionRecord {
        sender: "r1",
        receiver: "r2",
        seq,
        t_sampled_ns: t_sent_ns - 1_000_000,
        t_sent_ns,
        fate,
        pose: [1.0, 2.0, 7.5],
        velocity: Some([0.25, 0.5]),
        extra: &[0.5],
    };
    for i in 0..10_i64 {
        let t_ns = i * 20_000_001;
        let x = 0.1 * i as f64;
        run.write_torque_command(0, t_ns, [x, -x]).unwrap();
        run.write_encoders(0, t_ns, [i, i64::MAX - i]).unwrap();
        run.write_camera(1, t_ns, [x, 2.0 * x, 0.25]).unwrap();
        run.write_imu(1, t_ns, [x, 2.0, 3.0]).unwrap();
        run.write_odometry(0, t_ns, [9.0, 9.0, 9.0], [x, 0.5])
            .unwrap();
        run.write_true_poses(t_ns, &[[0.0; 3], [1.0; 3]]).unwrap();
        run.write_trace(t_ns, &[1, 2, 3]).unwrap();
    }
    // Messages are written once their delivery status is known, so not in the order of sending.
    let arrived = Fate::Arrived {
        t_received_ns: 300_000_000,
    };
    run.write_position(&position(1, 200_000_000, arrived))
        .unwrap();
    run.write_position(&position(0, 100_000_000, Fate::Lost))
        .unwrap();
    run.write_position(&position(2, 300_000_000, Fate::InFlight))
        .unwrap();
    // A robot that is not in the header is ignored.
    run.write_imu(7, 0, [0.0; 3]).unwrap();
    run.finish().unwrap();

    let import = read_mcap_from(&bytes[..], bytes.len() as u64, path).unwrap();
    assert_eq!(import.warnings, Vec::<String>::new());
    let left_out: Vec<_> = import.left_out.into_iter().collect();
    assert_eq!(
        left_out,
        [("/tf".to_owned(), 10), ("/trace".to_owned(), 10)]
    );
    let recording = import.recording;
    assert_eq!(recording.model, Some(RobotModel::paper_with_slip()));
    let (r1, r2) = (
        recording.robot("r1").unwrap(),
        recording.robot("r2").unwrap(),
    );
    assert_eq!(r1.encoder_counts_per_rev, Some(1856.0));
    let command = r1.command.as_ref().unwrap();
    assert_eq!(command.t_s[9], 0.180_000_009);
    let Command::Torque { right_nm, left_nm } = &command.values else {
        panic!("no torque");
    };
    assert_eq!((right_nm[3], left_nm[3]), (0.1 * 3.0, -0.1 * 3.0));
    let odometry = r1.odometry.as_ref().unwrap();
    assert_eq!((odometry.values.v_m_s[3], odometry.len()), (0.1 * 3.0, 10));
    assert_eq!(
        r2.imu.as_ref().unwrap().values.gz_rad_s.as_ref().unwrap()[0],
        3.0
    );
    assert_eq!(r2.pose.as_ref().unwrap().values.y_m[4], 0.8);

    let links = recording.links.unwrap();
    let received: Vec<Option<f64>> = links.messages.iter().map(|m| m.t_received_s).collect();
    assert_eq!(received, [None, Some(0.3), None]);
    let message = &links.messages[1];
    assert_eq!(
        (message.t_sent_s, message.yaw_rad, message.w_rad_s),
        (0.2, 7.5, 0.5)
    );
    assert_eq!((&*message.from, &*message.to), ("r1", "r2"));
}
