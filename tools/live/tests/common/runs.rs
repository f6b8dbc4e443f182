//! A run as a recorder writes it.

use slipstream_recording::recording::{Recording, Robot};
use slipstream_recording::run_writer::{RunHeader, RunWriter};

/// The description of a run of two robots.
pub(crate) fn header() -> RunHeader {
    let robots = ["r1", "r2"].map(|name| Robot {
        encoder_counts_per_rev: Some(4096.0),
        ..Robot::named(name)
    });
    RunHeader {
        description: Recording {
            name: "two robots".to_owned(),
            robots: robots.into(),
            ..Recording::default()
        },
        ..RunHeader::default()
    }
}

/// Writes the messages of a run of steps of 20 ms.
pub(crate) fn write(run: &mut RunWriter<'_>, steps: std::ops::Range<i64>, each: &mut dyn FnMut()) {
    for step in steps {
        let t_ns = step * 20_000_000;
        let x = step as f64;
        for robot in 0..2 {
            run.write_torque_command(robot, t_ns, [x * 0.01, -0.1])
                .unwrap();
            run.write_encoders(robot, t_ns + 1, [step * 7, step * 6])
                .unwrap();
            run.write_camera(robot, t_ns + 2, [x * 0.1, 0.5, 0.25])
                .unwrap();
            run.write_imu(robot, t_ns + 3, [0.1, x, 0.3]).unwrap();
            run.write_truth(robot, t_ns, [x, 0.0, 0.0], [0.1; 3])
                .unwrap();
        }
        run.write_true_poses(t_ns, &[[x, 0.0, 0.0]; 2]).unwrap();
        each();
    }
}
