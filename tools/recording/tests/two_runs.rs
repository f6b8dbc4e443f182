//! Two recordings of one experiment beside each other, where the differences are known in closed form.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{
    Odometry, Pose, PosePoint, Recording, Robot, Stream, Wheels,
};
use slipstream_recording::two_runs::{Experiment, Run, TwoRuns, TwoRunsError, compare_runs};

const SPEED_M_S: f64 = 0.4;
const EXPERIMENT: Experiment = Experiment {
    spacing_m: Some(0.5),
};

fn stream<V>(t_s: &[f64], values: V) -> Stream<V> {
    Stream {
        t_s: t_s.to_vec(),
        values,
        unknown: Vec::new(),
    }
}

fn times(period_s: f64) -> Vec<f64> {
    let rows = (10.0 / period_s) as u32;
    (0..=rows).map(|row| period_s * f64::from(row)).collect()
}

/// A robot that drives straight on along x for 10 s and starts at `x_m`, `y_m`; its wheels roll `roll` times as far.
fn straight(name: &str, [x_m, y_m]: [f64; 2], period_s: f64, roll: f64) -> Robot {
    let t_s = times(period_s);
    let all = |value: fn(f64) -> f64| t_s.iter().map(|t_s| value(*t_s)).collect::<Vec<f64>>();
    let mut robot = Robot::named(name);
    let pose = Pose {
        x_m: t_s.iter().map(|t_s| x_m + SPEED_M_S * t_s).collect(),
        y_m: vec![y_m; t_s.len()],
        yaw_rad: Some(all(|_| 0.0)),
    };
    robot.pose = Some(stream(&t_s, pose));
    let radius_m = model().robot.wheel_radius_m;
    let angle: Vec<f64> = t_s
        .iter()
        .map(|t_s| 3.0 + roll * SPEED_M_S * t_s / radius_m)
        .collect();
    let wheels = Wheels::Angle {
        right_rad: angle.clone(),
        left_rad: angle,
    };
    robot.wheels = Some(stream(&t_s, wheels));
    robot
}

fn model() -> RobotModel {
    RobotModel::paper_with_slip()
}

fn recording(robots: Vec<Robot>) -> Recording {
    Recording {
        robots,
        ..Recording::default()
    }
}

fn compared(real: Vec<Robot>, simulated: Vec<Robot>) -> Result<TwoRuns, TwoRunsError> {
    let (real, simulated) = (recording(real), recording(simulated));
    let run = |name, recording, experiment| Run {
        name,
        recording,
        experiment,
    };
    // A real recording seldom has its experiment: that of the simulated one counts.
    compare_runs(
        run("real", &real, None),
        run("simulated", &simulated, Some(&EXPERIMENT)),
        |_| Some(model()),
    )
}

#[test]
fn shifts_and_rates_are_what_was_put_in() {
    let real = vec![
        straight("r1", [0.6, 0.0], 0.033, 1.02),
        straight("r2", [0.07, 0.04], 0.033, 1.0),
    ];
    let simulated = vec![
        straight("r1", [0.6, 0.0], 0.02, 1.0),
        straight("r2", [0.1, 0.0], 0.02, 1.0),
    ];
    let answer = compared(real, simulated).unwrap();
    let [first, second] = &*answer.robots else {
        unreachable!("two robots")
    };
    // 3 cm behind and 4 cm beside: 5 cm.
    let path = second.path.unwrap();
    for length_m in [path.rms_m, path.largest_m, path.start_m] {
        assert!((length_m - 0.05).abs() < 1e-9, "{path:?}");
    }
    assert!(first.path.unwrap().largest_m < 1e-9);
    let spacing = second.spacing.as_ref().unwrap();
    let [real, simulated] = spacing.errors.pair().unwrap();
    assert!((real.largest_m - 0.03).abs() < 1e-9 && simulated.largest_m < 1e-9);
    assert!((spacing.rms_difference_m.unwrap() - 0.03).abs() < 1e-9);
    assert!(first.spacing.is_none() && real.at_s >= 3.0);
    let slip = first.slip.unwrap();
    let [real, simulated] = slip.slips.pair().unwrap();
    assert!((real.slip_percent.unwrap() - 100.0 * 0.02 / 1.02).abs() < 1e-6);
    assert!(simulated.slip_percent.unwrap().abs() < 1e-6);
    assert!((real.poses_m - SPEED_M_S * 9.5).abs() < 0.21, "{real:?}");
}

#[test]
fn poses_of_the_axle_count_as_those_of_the_centre_of_mass() {
    let behind_m = model().robot.com_to_axle_m.unwrap();
    let mut real = straight("r1", [1.0 - behind_m, 0.0], 0.02, 1.0);
    real.pose_point = Some(PosePoint::Axle);
    let answer = compared(vec![real], vec![straight("r1", [1.0, 0.0], 0.02, 1.0)]).unwrap();
    assert!(answer.robots[0].path.unwrap().largest_m < 1e-9);
}

#[test]
fn what_was_not_recorded_is_absent() {
    let mut without_poses = straight("r1", [0.6, 0.0], 0.02, 1.0);
    without_poses.pose = None;
    let mut without_wheels = straight("r2", [0.1, 0.0], 0.02, 1.0);
    without_wheels.wheels = None;
    let mut with_odometry = straight("r3", [-0.4, 0.0], 0.02, 1.0);
    with_odometry.wheels = None;
    let odometry = Odometry {
        v_m_s: vec![1.1 * SPEED_M_S; times(0.02).len()],
        w_rad_s: None,
    };
    with_odometry.odometry = Some(stream(&times(0.02), odometry));
    let simulated = vec![
        straight("r1", [0.6, 0.0], 0.02, 1.0),
        straight("r2", [0.1, 0.0], 0.02, 1.0),
        straight("r3", [-0.4, 0.0], 0.02, 1.0),
        straight("r4", [-0.9, 0.0], 0.02, 1.0),
    ];
    let answer = compared(
        vec![without_poses, without_wheels, with_odometry],
        simulated,
    )
    .unwrap();
    let [first, second, third] = &*answer.robots else {
        unreachable!("three robots")
    };
    assert_eq!(answer.left_out, ["r4"]);
    assert!(first.path.is_none() && first.slip.unwrap().slips.real.is_none());
    let spacing = second.spacing.as_ref().unwrap();
    assert!(spacing.errors.real.is_none() && spacing.errors.simulated.is_some());
    assert!(spacing.largest_difference_m.is_none());
    let slip = second.slip.unwrap();
    assert!(slip.slips.real.is_none() && slip.difference_percent.is_none());
    let by_odometry = third.slip.unwrap().slips.real.unwrap();
    assert!((by_odometry.slip_percent.unwrap() - 100.0 * 0.1 / 1.1).abs() < 1e-6);
}

#[test]
fn recordings_without_a_common_robot_or_time_are_refused() {
    let one = || vec![straight("r1", [0.0; 2], 0.02, 1.0)];
    let other = vec![straight("a", [0.0; 2], 0.02, 1.0)];
    let refused = compared(one(), other).unwrap_err();
    assert!(matches!(refused, TwoRunsError::NoCommonRobot { .. }));
    let mut late = one();
    for stamp in &mut late[0].pose.as_mut().unwrap().t_s {
        *stamp += 1000.0;
    }
    late[0].wheels = None;
    let refused = compared(late, one()).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "do not overlap in time: 1000.00 to 1010.00 s, and 0.00 to 10.00 s"
    );
}
