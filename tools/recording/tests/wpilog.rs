//! WPILib data logs: entries are topics, damage costs only what is damaged.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use slipstream_recording::recording::Wheels;
use slipstream_recording::{draft_map, read};

/// A log by the specification.
struct Log(Vec<u8>);

impl Log {
    fn new() -> Self {
        Self(b"WPILOG\x00\x01\x05\x00\x00\x00extra".to_vec())
    }

    /// A record with numbers of 1, 2 and 4 bytes.
    fn record(&mut self, entry: u8, t_us: u32, data: &[u8]) {
        self.0.extend([0b0011_0100, entry]);
        self.0
            .extend(u16::try_from(data.len()).unwrap().to_le_bytes());
        self.0.extend(t_us.to_le_bytes());
        self.0.extend(data);
    }

    fn start(&mut self, entry: u8, name: &str, kind: &str) {
        let mut data = vec![0, entry, 0, 0, 0];
        for text in [name, kind, ""] {
            data.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
            data.extend(text.as_bytes());
        }
        self.record(0, 0, &data);
    }

    fn numbers(&mut self, entry: u8, t_us: u32, numbers: &[f64]) {
        let bytes = numbers.iter().flat_map(|number| number.to_le_bytes());
        self.record(entry, t_us, &bytes.collect::<Vec<_>>());
    }
}

/// A log with a vision's poses, speeds, and a number each side.
fn log() -> Log {
    let mut log = Log::new();
    log.start(1, "NT:/vision/pose", "struct:Pose2d");
    log.start(2, "/drive/speeds", "struct:ChassisSpeeds");
    log.start(3, "/drive/leftPosition", "double");
    log.start(4, "/console", "string");
    for (row, t_us) in [(0.0, 5_000_000), (1.0, 5_020_000)] {
        log.numbers(1, t_us, &[row, 2.0, 0.5]);
        log.numbers(2, t_us, &[0.25, 0.0, row]);
        log.numbers(3, t_us, &[row]);
        log.record(4, t_us, b"hello");
    }
    log
}

#[test]
fn entries_are_topics() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("FRC_20240501.wpilog");
    std::fs::write(&file, log().0).unwrap();
    let import = read(&file).unwrap();
    let [robot] = &import.recording.robots[..] else {
        unreachable!("one robot: {:?}", import.recording.robots);
    };
    let pose = robot.pose.as_ref().unwrap();
    assert!(
        (pose.t_s[1] - pose.t_s[0] - 0.02).abs() < 1e-9,
        "{:?}",
        pose.t_s
    );
    assert_eq!(pose.values.x_m, [0.0, 1.0]);
    assert_eq!(pose.values.yaw_rad.as_ref().unwrap(), &[0.5, 0.5]);
    let odometry = robot.odometry.as_ref().unwrap();
    assert_eq!(odometry.values.v_m_s, [0.25, 0.25]);
    assert_eq!(odometry.values.w_rad_s.as_ref().unwrap(), &[0.0, 1.0]);
    let draft = draft_map(&file, &[]).unwrap();
    for line in [
        "# /drive/leftPosition: 2 messages, double",
        "# /console: 2 messages, string",
    ] {
        assert!(draft.contains(line), "{draft}");
    }
}

/// A number on each side is a wheel, as in any other bag.
#[test]
fn numbers_of_two_sides_are_wheels() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.wpilog");
    let mut log = Log::new();
    log.start(1, "/Drive/LeftPositionRad", "double");
    log.start(2, "/Drive/RightPositionRad", "double");
    log.start(3, "/Odometry/Robot", "struct:Pose2d");
    for row in 0..20_u8 {
        let (t_us, angle_rad) = (5_000_000 + 20_000 * u32::from(row), 0.1 * f64::from(row));
        log.numbers(1, t_us, &[angle_rad]);
        log.numbers(2, t_us, &[2.0 * angle_rad]);
        log.numbers(3, t_us, &[0.05 * angle_rad, 0.0, 0.5]);
    }
    std::fs::write(&file, log.0).unwrap();
    let import = read(&file).unwrap();
    let robot = &import.recording.robots[0];
    let wheels = robot.wheels.as_ref().map(|wheels| &wheels.values);
    let Some(Wheels::Angle {
        right_rad,
        left_rad,
    }) = wheels
    else {
        unreachable!("angles: {:?}", import.guesses);
    };
    assert!((right_rad[5] - 1.0).abs() < 1e-12 && (left_rad[5] - 0.5).abs() < 1e-12);
    // What the robot reckons from its wheels is no reference.
    assert!(
        robot.pose.is_none() && robot.odometry.is_some(),
        "{:?}",
        import.guesses
    );
}

#[test]
fn a_log_that_is_cut_or_damaged_is_read_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cut.wpilog");
    let mut damaged = log();
    // An entry that was never started, and a pose that is too short.
    damaged.numbers(9, 5_030_000, &[1.0]);
    damaged.record(1, 5_040_000, &[0; 5]);
    damaged.numbers(1, 5_060_000, &[3.0, 2.0, 0.5]);
    damaged.0.extend([0b0011_0100, 1, 200, 0, 1]);
    std::fs::write(&file, damaged.0).unwrap();
    let import = read(&file).unwrap();
    let pose = import.recording.robots[0].pose.as_ref().unwrap();
    assert_eq!(pose.values.x_m, [0.0, 1.0, 3.0]);
    let loss = import.loss.unwrap();
    assert_eq!(loss.undecodable_messages, 2);
    assert!(loss.truncated && loss.bytes_at_end == 5, "{loss:?}");
    assert!(
        import.warnings.join("\n").contains("recovered"),
        "{:?}",
        import.warnings
    );

    std::fs::write(&file, b"WPILOG\x00\x02\x00\x00\x00\x00").unwrap();
    let error = read(&file).unwrap_err().to_string();
    assert!(
        error.contains("is not a WPILib data log of version 1"),
        "{error}"
    );
}
