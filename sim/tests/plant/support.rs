//! Helpers for driving a robot in tests.

use slipstream_bus::RobotModel;
use slipstream_sim::{Command, Robot, Scalar, State};

/// Plant step of the tests (s).
pub(crate) const STEP_S: f64 = 1e-3;

pub(crate) fn torque<S: Scalar>(right: f64, left: f64) -> Command<S> {
    Command::Torque {
        right_nm: S::constant(right),
        left_nm: S::constant(left),
    }
}

pub(crate) fn robot(model: &RobotModel) -> Robot {
    Robot::new(model).unwrap()
}

/// The paper's robot with one effect, without wheel slip.
pub(crate) fn robot_with(effect: &str, parameters: &[(&str, f64)]) -> Robot {
    robot(&RobotModel::default().with(effect, parameters))
}

/// The paper's robot with equal static and kinetic friction at the driven wheels.
pub(crate) fn with_friction(friction: f64) -> RobotModel {
    RobotModel::default().with(
        "wheel_slip",
        &[
            ("friction_static", friction),
            ("friction_kinetic", friction),
        ],
    )
}

/// Steps from `from_s` for `over_s` in steps of `step_s` (s) under a command that depends on the
/// time at the middle of the step.
pub(crate) fn drive<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    from_s: f64,
    over_s: f64,
    step_s: f64,
    command: impl Fn(f64) -> Command<S>,
) {
    let steps = (over_s / step_s).round() as usize;
    for k in 0..steps {
        let t_s = from_s + k as f64 * step_s;
        robot.step(state, t_s, step_s, &command(t_s + step_s / 2.0));
    }
}

/// Drives from rest for `over_s` (s) at constant wheel speeds (rad/s).
pub(crate) fn drive_at_speeds(robot: &Robot, over_s: f64, right: f64, left: f64) -> State {
    let mut state = robot.start([0.0; 3]);
    let command = |_| Command::Speed {
        right_rad_s: right,
        left_rad_s: left,
    };
    drive(robot, &mut state, 0.0, over_s, STEP_S, command);
    state
}

/// A torque profile that accelerates, turns, brakes and reverses, constant for 20 ms at a time.
pub(crate) fn mixed(t_s: f64, size_nm: f64) -> [f64; 2] {
    let t = (t_s / 0.02).floor() * 0.02;
    let right = (1.7 * t).sin() + 0.5 * (4.1 * t).cos();
    let left = (1.7 * t + 0.4).sin() - 0.5 * (3.3 * t).cos();
    [right * size_nm, left * size_nm]
}

/// Kinetic energy of `model` (J), from its masses instead of the plant's mass matrix.
pub(crate) fn kinetic_energy(model: &RobotModel, state: &State) -> f64 {
    let body = &model.robot;
    let known = |value: Option<f64>| value.unwrap();
    let [u, w, rate] = state.velocity();
    let [right, left] = state.wheel_speed();
    let (b, d) = (body.half_track_m, known(body.com_to_axle_m));
    let mut energy = known(body.body_mass_kg) * (u * u + w * w)
        + known(body.body_yaw_inertia_kg_m2) * rate * rate;
    for (side, speed) in [(-b, right), (b, left)] {
        let along = u - side * rate;
        let across = w - d * rate;
        energy += known(body.wheel_mass_kg) * (along * along + across * across)
            + known(body.wheel_yaw_inertia_kg_m2) * rate * rate
            + known(body.wheel_spin_inertia_kg_m2) * speed * speed;
    }
    energy / 2.0
}

pub(crate) fn assert_near(what: &str, value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{what}: {value} differs from {expected} by more than {tolerance}"
    );
}
