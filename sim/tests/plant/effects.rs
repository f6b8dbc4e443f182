//! Each effect against a closed-form solution or a limit.

use crate::support::{
    STEP_S, assert_near, drive, drive_at_speeds, robot, robot_with, torque, with_friction,
};
use slipstream_bus::RobotModel;
use slipstream_sim::{Command, GRAVITY_M_S2, Robot, State};

const R: f64 = 0.0365;
const B: f64 = 0.105;
const D: f64 = 0.055;
const E: f64 = 0.095;
const M: f64 = 1.628;
const I_WY: f64 = 0.001_168;
/// Effective mass of rolling straight ahead: m_t + 2 I_wy / r² (kg).
const ROLLING_MASS: f64 = M + 2.0 * I_WY / (R * R);

fn drive_straight(robot: &Robot, over_s: f64, torque_nm: f64) -> State {
    let mut state = robot.start([0.0; 3]);
    drive(robot, &mut state, 0.0, over_s, STEP_S, |_| {
        torque(torque_nm, torque_nm)
    });
    state
}

/// Turns in place under opposite torques.
fn spin(robot: &Robot, over_s: f64, torque_nm: f64) -> State {
    let mut state = robot.start([0.0; 3]);
    drive(robot, &mut state, 0.0, over_s, STEP_S, |_| {
        torque(torque_nm, -torque_nm)
    });
    state
}

#[test]
fn rolling_resistance() {
    let c = 0.01;
    let state = drive_straight(
        &robot_with("rolling_resistance", &[("coefficient", c)]),
        1.0,
        0.05,
    );
    let a = (2.0 * 0.05 / R - c * M * GRAVITY_M_S2) / ROLLING_MASS;
    assert_near("v", state.velocity()[0], a, 1e-12);
    // below the limit the robot stands
    let below = 0.9 * c * M * GRAVITY_M_S2 * R / 2.0;
    let state = drive_straight(
        &robot_with("rolling_resistance", &[("coefficient", c)]),
        1.0,
        below,
    );
    for value in state.pose() {
        assert_near("stands", value, 0.0, 1e-15);
    }
}

#[test]
fn axle_friction() {
    let t = 0.006;
    let state = drive_straight(&robot_with("axle_friction", &[("torque_nm", t)]), 1.0, 0.05);
    assert_near(
        "v",
        state.velocity()[0],
        2.0 * (0.05 - t) / R / ROLLING_MASS,
        1e-12,
    );
    let state = drive_straight(
        &robot_with("axle_friction", &[("torque_nm", t)]),
        1.0,
        0.99 * t,
    );
    assert_eq!(state.pose(), [0.0; 3]);
}

#[test]
fn yaw_scrub() {
    let moment = 0.01;
    let free = spin(&robot(&RobotModel::default()), 0.1, 0.05).velocity()[2];
    let state = spin(
        &robot_with("yaw_scrub", &[("moment_nm", moment)]),
        0.1,
        0.05,
    );
    let drive = 2.0 * 0.05 * B / R;
    // the yaw acceleration is in proportion to the net moment; φ̇² accelerates c forward and takes
    // 1e-4 of it
    assert_near(
        "rate",
        state.velocity()[2] / free,
        (drive - moment) / drive,
        2e-4,
    );
}

#[test]
fn caster_drag() {
    let friction = 0.05;
    let state = drive_straight(
        &robot_with("caster_drag", &[("friction", friction)]),
        1.0,
        0.05,
    );
    let caster = M * GRAVITY_M_S2 * D / (D + E);
    let a = (2.0 * 0.05 / R - friction * caster) / ROLLING_MASS;
    assert_near("v", state.velocity()[0], a, 1e-12);
}

#[test]
fn a_sticking_caster_breaks_away_at_its_friction_limit() {
    let friction = 0.05;
    let caster = M * GRAVITY_M_S2 * D / (D + E);
    let limit_nm = friction * caster * R / 2.0;
    let robot = robot_with("caster_drag", &[("friction", friction)]);
    let mut state = robot.start([0.0; 3]);
    let share = |t_s: f64| if t_s < 0.5 { 0.99 } else { 1.01 };
    for (over_s, moves) in [(0.5, false), (0.1, true)] {
        let from_s = if moves { 0.5 } else { 0.0 };
        drive(&robot, &mut state, from_s, over_s, STEP_S, |t_s| {
            torque(share(t_s) * limit_nm, share(t_s) * limit_nm)
        });
        assert_eq!(state.pose() != [0.0; 3], moves);
    }
}

#[test]
fn quadratic_drag() {
    let c = 0.8;
    let state = drive_straight(
        &robot_with("quadratic_drag", &[("coefficient", c)]),
        2.0,
        0.03,
    );
    let f = 2.0 * 0.03 / R;
    let v = (f / c).sqrt() * ((f * c).sqrt() / ROLLING_MASS * 2.0).tanh();
    assert_near("v", state.velocity()[0], v, 1e-7);
}

#[test]
fn torque_speed_droop() {
    let k = 2e-3;
    let state = drive_straight(
        &robot_with("torque_speed_droop", &[("coefficient", k)]),
        1.0,
        0.03,
    );
    let rate = 2.0 * k / (ROLLING_MASS * R * R);
    let top = 0.03 / k;
    // trapezoidal rule: (rate h)² / 12 of the speed
    assert_near(
        "speed",
        state.wheel_speed()[0],
        top * (1.0 - (-rate).exp()),
        1e-6,
    );
}

#[test]
fn actuator_delay() {
    let delay = 0.0234;
    let state = drive_straight(
        &robot_with("actuator_delay", &[("delay_s", delay)]),
        1.0,
        0.05,
    );
    let a = 2.0 * 0.05 / R / ROLLING_MASS;
    assert_near("v", state.velocity()[0], a * (1.0 - delay), 1e-12);
    assert_near("x", state.pose()[0], a * (1.0 - delay).powi(2) / 2.0, 1e-12);
}

#[test]
fn actuator_lag() {
    let lag = 0.05;
    let state = drive_straight(
        &robot_with("actuator_lag", &[("time_constant_s", lag)]),
        1.0,
        0.05,
    );
    let a = 2.0 * 0.05 / R / ROLLING_MASS;
    assert_near(
        "v",
        state.velocity()[0],
        a * (1.0 - lag * (1.0 - (-1.0 / lag).exp())),
        1e-12,
    );
    let state = drive_at_speeds(
        &robot_with("actuator_lag", &[("time_constant_s", lag)]),
        0.2,
        3.0,
        3.0,
    );
    let angle = 3.0 * (0.2 - lag * (1.0 - (-0.2 / lag).exp()));
    assert_near("angle", state.wheel_angle()[0], angle, 1e-12);
    assert_near("x", state.pose()[0], angle * R, 1e-12);
}

#[test]
fn motor_gain_and_supply_sag() {
    let free = drive_straight(&robot(&RobotModel::default()), 1.0, 0.05).velocity()[0];
    let state = drive_straight(
        &robot_with("motor_gain", &[("right", 0.9), ("left", 0.9)]),
        1.0,
        0.05,
    );
    assert_near("gain", state.velocity()[0], 0.9 * free, 1e-12);
    let state = drive_straight(
        &robot_with("supply_sag", &[("rate_per_s", 0.02)]),
        1.0,
        0.05,
    );
    assert_near("sag", state.velocity()[0], free * (1.0 - 0.02 / 2.0), 1e-12);
}

#[test]
fn dead_band_and_saturation() {
    let band = robot_with("command_dead_band", &[("torque_nm", 0.02)]);
    assert_eq!(drive_straight(&band, 1.0, 0.0199).pose(), [0.0; 3]);
    let free = drive_straight(&robot(&RobotModel::default()), 1.0, 0.05);
    let above = drive_straight(&band, 1.0, 0.05).pose()[0];
    assert_near("above the band", above, free.pose()[0], 1e-12);
    let saturated = drive_straight(
        &robot_with("command_saturation", &[("torque_nm", 0.05)]),
        1.0,
        0.2,
    );
    assert_near("saturated", saturated.pose()[0], free.pose()[0], 1e-12);
    let saturated = drive_at_speeds(
        &robot_with("command_saturation", &[("speed_rad_s", 2.0)]),
        1.0,
        9.0,
        -9.0,
    );
    assert_eq!(saturated.wheel_speed(), [2.0, -2.0]);
}

/// The motors, a quarter of I_wy each, cross half the gap alone, then accelerate wheels and robot.
#[test]
fn backlash() {
    let (gap, torque_nm) = (0.04, 0.02);
    let robot = robot_with("backlash", &[("gap_rad", gap)]);
    let alone = torque_nm / (I_WY / 4.0);
    let contact_s = (gap / alone).sqrt();
    let before = (contact_s / STEP_S).floor() * STEP_S;
    let state = drive_straight(&robot, before, torque_nm);
    assert_eq!(state.pose(), [0.0; 3]);
    let state = drive_straight(&robot, 0.5, torque_nm);
    // angular momentum about the axles: of the motors before the impact, of the robot after it
    let motors = I_WY / 4.0 * alone * contact_s;
    let shared = motors / (ROLLING_MASS * R * R / 2.0);
    let rate = torque_nm / (ROLLING_MASS * R * R / 2.0);
    let speed = shared + rate * (0.5 - contact_s);
    // the impact is located to 1 ms / 8192
    assert_near("speed", state.wheel_speed()[0], speed, 1e-4);
    let apart = robot.measured_angle(&state)[0] - state.wheel_angle()[0];
    assert_near("gap", apart, gap / 2.0, 1e-6);
}

/// The gap is respected also where the impact makes the wheel slide and friction stops it again:
/// motor and wheel are never further apart than half the gap.
#[test]
fn backlash_under_slip() {
    let gap = 0.055;
    let robot = robot(&with_friction(0.241).with("backlash", &[("gap_rad", gap)]));
    let mut state = robot.start([0.0; 3]);
    let mut penetration: f64 = 0.0;
    for k in 0..20_000 {
        let t_s = f64::from(k) * STEP_S;
        let command = Command::Voltage {
            right_v: 5.0 * (2.3 * t_s).sin() + 2.0 * (5.1 * t_s).sin(),
            left_v: 5.0 * (1.9 * t_s).sin() - 2.0 * (4.3 * t_s).sin(),
        };
        robot.step(&mut state, t_s, STEP_S, &command);
        let (motor, wheel) = (robot.measured_angle(&state), state.wheel_angle());
        for i in 0..2 {
            penetration = penetration.max((motor[i] - wheel[i]).abs() - gap / 2.0);
        }
    }
    // an impact is located to 1 ms / 8192, at about 1 rad/s
    assert!(penetration < 1e-6, "{penetration} rad");
}

#[test]
fn load_transfer() {
    let (mu, height) = (0.24, 0.05);
    let model = with_friction(mu).with("load_transfer", &[("com_height_m", height)]);
    let state = drive_straight(&robot(&model), 0.5, 0.3);
    let a = mu * GRAVITY_M_S2 * E / (D + E) / (1.0 - mu * height / (D + E));
    assert_near("v", state.velocity()[0], a * 0.5, 1e-11);
}

#[test]
fn wheel_radius_and_track_width() {
    let scales = [("right_scale", 1.02), ("left_scale", 0.97)];
    let state = drive_at_speeds(&robot_with("wheel_radius", &scales), 1.0, 5.0, 5.0);
    let [right, left] = [1.02 * R * 5.0, 0.97 * R * 5.0];
    assert_near("turn", state.pose()[2], (right - left) / (2.0 * B), 1e-12);
    let state = drive_at_speeds(
        &robot_with("track_width", &[("scale", 1.3)]),
        1.0,
        5.0,
        -5.0,
    );
    assert_near("turn", state.pose()[2], 5.0 * R / (1.3 * B), 1e-12);
}

#[test]
fn payload() {
    let list = [("mass_kg", 0.4), ("x_m", 0.0), ("y_m", 0.0)];
    let state = drive_straight(&robot_with("payload", &list), 1.0, 0.05);
    assert_near(
        "v",
        state.velocity()[0],
        2.0 * 0.05 / R / (ROLLING_MASS + 0.4),
        1e-12,
    );
    // beside the axis it loads one wheel more: N_r − N_l = −m_p g y / b
    let list = [("mass_kg", 0.4), ("x_m", -0.02), ("y_m", 0.03)];
    let model = with_friction(0.3).with("payload", &list);
    let [right, left] = drive_straight(&robot(&model), 0.001, 0.0)
        .contact_forces()
        .normal_n;
    assert_near(
        "difference",
        right - left,
        -0.4 * GRAVITY_M_S2 * 0.03 / B,
        1e-9,
    );
    let caster = (M * D + 0.4 * (D - 0.02)) * GRAVITY_M_S2 / (D + E);
    assert_near("sum", right + left, (M + 0.4) * GRAVITY_M_S2 - caster, 1e-9);
}

#[test]
fn floor_slope() {
    let grade: f64 = 0.02;
    let robot = robot_with("floor_slope", &[("grade", grade), ("downhill_rad", 0.0)]);
    let state = drive_straight(&robot, 1.0, 0.0);
    let g = GRAVITY_M_S2 * grade / (1.0 + grade * grade).sqrt();
    assert_near("v", state.velocity()[0], g * M / ROLLING_MASS, 1e-12);
    let uphill = drive_straight(&robot, 1.0, -M * g * R / 2.0);
    assert_near("balance", uphill.velocity()[0], 0.0, 1e-12);
}

#[test]
fn push() {
    let list = [
        ("t_s", 0.2345),
        ("impulse_n_s", 0.3),
        ("direction_rad", 0.0),
    ];
    let state = drive_straight(&robot_with("push", &list), 1.0, 0.0);
    assert_near("v", state.velocity()[0], 0.3 / ROLLING_MASS, 1e-12);
    // the force is averaged over the step in which it starts: an error of at most F h² / 8 m
    let distance = 0.3 / ROLLING_MASS * (1.0 - 0.2345 - 0.03);
    assert_near("x", state.pose()[0], distance, 1e-6);
}

#[test]
fn friction_patch() {
    let list = [
        ("x_m", 0.5),
        ("y_m", 0.0),
        ("radius_m", 0.15),
        ("friction", 0.02),
    ];
    let robot = robot(&with_friction(0.3).with("friction_patch", &list));
    let mut state = robot.start([0.0; 3]);
    let (mut before, mut inside) = (true, false);
    for k in 0..1200 {
        robot.step(
            &mut state,
            f64::from(k) * STEP_S,
            STEP_S,
            &torque(0.04, 0.04),
        );
        let axle = state.pose()[0] - D;
        let reach = (0.15_f64.powi(2) - B * B).sqrt();
        let on = (axle - 0.5).abs() < reach - 0.002;
        before &= axle > 0.5 - reach - 0.002 || state.slides() == [false; 2];
        inside |= on && state.slides() == [true; 2];
    }
    assert!(before && inside, "rolls before the patch, slides on it");
}
