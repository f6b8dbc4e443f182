//! Measurement functions and their effects: offsets, latencies, scales, gravity on a slope.

use std::f64::consts::TAU;

use crate::support::{assert_near, drive_at_speeds, robot_with};
use slipstream_sim::{GRAVITY_M_S2, Stream};

#[test]
fn sensor_errors() {
    let offset = robot_with(
        "pose_offset",
        &[("x_m", 0.1), ("y_m", 0.02), ("yaw_rad", 0.3)],
    );
    let [x, y, yaw] = offset.measured_pose([1.0, 2.0, TAU / 4.0]);
    assert_near("x", x, 1.0 - 0.02, 1e-15);
    assert_near("y", y, 2.0 + 0.1, 1e-15);
    assert_near("yaw", yaw, TAU / 4.0 + 0.3, 1e-15);
    for (effect, stream) in [
        ("pose_latency", Stream::Pose),
        ("wheels_latency", Stream::Wheels),
        ("imu_latency", Stream::Imu),
    ] {
        let robot = robot_with(effect, &[("latency_s", 0.04)]);
        assert_near(effect, robot.stamp_s(stream, 2.0), 2.04, 1e-15);
        assert_near(
            effect,
            robot.true_s(stream, robot.stamp_s(stream, 2.0)),
            2.0,
            1e-15,
        );
    }
    assert_near(
        "link",
        robot_with("link_delay", &[("delay_s", 0.1)]).link_delay_s(),
        0.1,
        0.0,
    );
    let scaled = robot_with(
        "encoder_scale",
        &[("right_scale", 1.1), ("left_scale", 0.9)],
    );
    let state = drive_at_speeds(&scaled, 1.0, 2.0, 2.0);
    let [right, left] = scaled.measured_angle(&state);
    assert_near("right", right, 2.2, 1e-12);
    assert_near("left", left, 1.8, 1e-12);
}

/// An inertial sensor at rest on a slope measures the component of gravity.
#[test]
fn inertial_sensor_on_a_slope() {
    let robot = robot_with("floor_slope", &[("grade", 0.1), ("downhill_rad", 0.0)]);
    let state = drive_at_speeds(&robot, 0.1, 0.0, 0.0);
    let g = GRAVITY_M_S2 * 0.1 / (1.0_f64 + 0.01).sqrt();
    assert_near("along", robot.measured_inertial(&state)[0], -g, 1e-9);
}
