//! Each effect against a closed-form solution or a limit.

use crate::support::{
    STEP_S, assert_near, drive, drive_at_speeds, robot, robot_with, torque, with_friction,
};
use slipstream_bus::{EffectSpec, Parameter, RobotModel};
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

/// The model without masses: its declared point is the middle of the axle.
fn kinematic(mut model: RobotModel) -> RobotModel {
    model.robot.body_mass_kg = None;
    model.robot.com_to_axle_m = None;
    model
}

#[test]
fn slip_ratio_of_commanded_speeds() {
    let slip = [("ratio", 0.1), ("asymmetry", 0.04)];
    let straight = RobotModel::default().with("slip_ratio", &slip[..1]);
    for model in [straight.clone(), kinematic(straight)] {
        let state = drive_at_speeds(&robot(&model), 2.0, 5.0, 5.0);
        assert_near("x", state.pose()[0], 0.9 * R * 5.0 * 2.0, 1e-12);
        // rounding of 2000 sums
        assert_near("angle", state.wheel_angle()[0], 10.0, 1e-11);
    }
    // right 12 % and left 8 %: an arc to the right
    let arc = RobotModel::default().with("slip_ratio", &slip);
    let [right, left] = [0.88 * R * 5.0, 0.92 * R * 5.0];
    let (v, w) = ((right + left) / 2.0, (right - left) / (2.0 * B));
    for (model, d) in [(arc.clone(), D), (kinematic(arc), 0.0)] {
        let state = drive_at_speeds(&robot(&model), 2.0, 5.0, 5.0);
        let turn = w * 2.0;
        assert_near("turn", state.pose()[2], turn, 1e-12);
        let x = v / w * turn.sin() + d * (turn.cos() - 1.0);
        assert_near("x", state.pose()[0], x, 1e-12);
        let y = v / w * (1.0 - turn.cos()) + d * turn.sin();
        assert_near("y", state.pose()[1], y, 1e-12);
        assert_near("v", state.velocity()[0], v, 1e-12);
    }
}

/// m du/dt = 2 F, I dω/dt = tau - r F, u = (1 - s) r ω.
#[test]
fn slip_ratio_of_torques_and_voltages() {
    let slip = 0.3;
    let robot = robot_with("slip_ratio", &[("ratio", slip)]);
    let mass = M + 2.0 * I_WY / ((1.0 - slip) * R * R);
    let state = drive_straight(&robot, 1.0, 0.05);
    let v = 2.0 * 0.05 / R / mass;
    assert_near("v", state.velocity()[0], v, 1e-12);
    assert_near(
        "speed",
        state.wheel_speed()[0],
        v / ((1.0 - slip) * R),
        1e-11,
    );
    assert_near("torque", state.applied_torque()[0], 0.05, 1e-15);
    let force = state.contact_forces().longitudinal_n[0];
    assert_near("force", force, M * v / 2.0, 1e-12);
    for value in robot.slip_m_s(&state) {
        assert_near("slip", value, 0.0, 1e-12);
    }
    // at the no-load speed the motors give no torque
    let mut state = robot.start([0.0; 3]);
    drive(&robot, &mut state, 0.0, 10.0, STEP_S, |_| {
        Command::Voltage {
            right_v: 6.0,
            left_v: 6.0,
        }
    });
    let top = 36.65 / 2.0;
    assert_near("no-load speed", state.wheel_speed()[1], top, 1e-4);
    assert_near("its v", state.velocity()[0], 0.7 * R * top, 1e-4);
}

/// Axle friction and a torque from outside act on the wheel, as the motor does.
#[test]
fn slip_ratio_leaves_torques_at_the_wheel() {
    let (slip, friction) = (0.3, 0.006);
    let model = RobotModel::default()
        .with("slip_ratio", &[("ratio", slip)])
        .with("axle_friction", &[("torque_nm", friction)]);
    let robot = robot(&model);
    let mut state = robot.start([0.0; 3]);
    state.set_external_force(Some([0.0, 0.0, 0.0, 0.01, 0.01]));
    drive(&robot, &mut state, 0.0, 1.0, STEP_S, |_| torque(0.05, 0.05));
    let mass = M + 2.0 * I_WY / ((1.0 - slip) * R * R);
    let v = 2.0 * (0.05 + 0.01 - friction) / R / mass;
    assert_near("v", state.velocity()[0], v, 1e-12);
    let below = drive_straight(&robot, 1.0, 0.99 * friction);
    assert_eq!(below.pose(), [0.0; 3]);
}

/// Wheels that slide push with friction alone, whatever the slip ratio.
#[test]
fn slip_ratio_under_wheel_slip() {
    let (mu, slip) = (0.24, 0.2);
    let model = with_friction(mu).with("slip_ratio", &[("ratio", slip)]);
    let robot = robot(&model);
    let state = drive_straight(&robot, 0.5, 0.3);
    let a = mu * GRAVITY_M_S2 * E / (D + E);
    assert_near("v", state.velocity()[0], a * 0.5, 1e-11);
    let contact = (1.0 - slip) * R * state.wheel_speed()[0];
    assert_near(
        "slip",
        robot.slip_m_s(&state)[0],
        state.velocity()[0] - contact,
        1e-12,
    );
    assert_eq!(state.slides(), [true; 2]);
}

#[test]
fn command_dead_zone() {
    let zone = robot_with("command_dead_zone", &[("torque_nm", 0.02)]);
    assert_eq!(drive_straight(&zone, 1.0, 0.02).pose(), [0.0; 3]);
    let free = |nm| drive_straight(&robot(&RobotModel::default()), 1.0, nm).pose()[0];
    for (given, left) in [(0.05, 0.03), (-0.05, -0.03)] {
        let x = drive_straight(&zone, 1.0, given).pose()[0];
        assert_near("x", x, free(left), 1e-12);
    }
    let zone = robot_with("command_dead_zone", &[("speed_rad_s", 2.0)]);
    let state = drive_at_speeds(&zone, 1.0, 9.0, -9.0);
    assert_eq!(state.wheel_speed(), [7.0, -7.0]);
    // a voltage of 0.65 V gives a torque of 0.04225 N m at standstill
    let torque_nm = 0.65 * 0.78 / 12.0;
    let volts = |name, size| {
        let zone = robot_with("command_dead_zone", &[(name, size)]);
        let mut state = zone.start([0.0; 3]);
        drive(&zone, &mut state, 0.0, 0.5, STEP_S, |_| Command::Voltage {
            right_v: 3.0,
            left_v: 3.0,
        });
        state.pose()[0]
    };
    let by_torque = volts("torque_nm", torque_nm);
    assert_near("volts", volts("voltage_v", 0.65), by_torque, 1e-12);
    let mut less = robot(&RobotModel::default()).start([0.0; 3]);
    let plain = robot(&RobotModel::default());
    drive(&plain, &mut less, 0.0, 0.5, STEP_S, |_| Command::Voltage {
        right_v: 2.35,
        left_v: 2.35,
    });
    assert_near("2.35 V", by_torque, less.pose()[0], 1e-12);
}

/// Dead band, then dead zone counted behind the gain, then saturation.
#[test]
fn command_dead_zone_in_the_order_of_the_command() {
    let model = RobotModel::default()
        .with("command_dead_band", &[("speed_rad_s", 3.0)])
        .with("command_dead_zone", &[("speed_rad_s", 1.0)])
        .with("command_saturation", &[("speed_rad_s", 8.0)])
        .with("motor_gain", &[("right", 0.5), ("left", 2.0)]);
    let robot = robot(&model);
    for (given, expected) in [
        (2.9, [0.0, 0.0]),
        (4.0, [0.5 * 4.0 - 1.0, 2.0 * 4.0 - 1.0]),
        (-4.0, [-1.0, -7.0]),
        (9.5, [0.5 * 9.5 - 1.0, 2.0 * 8.0]),
        (20.0, [0.5 * 8.0, 2.0 * 8.0]),
    ] {
        let speeds = drive_at_speeds(&robot, 0.1, given, given).wheel_speed();
        assert_near("right", speeds[0], expected[0], 1e-12);
        assert_near("left", speeds[1], expected[1], 1e-12);
    }
    let none = robot_with("motor_gain", &[("right", 0.0), ("left", 0.0)]);
    assert_eq!(drive_at_speeds(&none, 0.1, 5.0, 5.0).pose(), [0.0; 3]);
}

/// The paper's robot with a law.
fn with_law(
    model: RobotModel,
    [effect, acts_on, driver]: [&str; 3],
    knots: &[f64],
    values: &[f64],
) -> RobotModel {
    let text = |name: &str, word: &str| (name.to_owned(), Parameter::Text(word.to_owned()));
    let list = |name: &str, list: &[f64]| (name.to_owned(), Parameter::List(list.to_vec()));
    let mut model = model;
    model.effects.push(EffectSpec {
        effect: effect.to_owned(),
        parameters: vec![
            text("acts_on", acts_on),
            text("driver", driver),
            list("knots", knots),
            list("values", values),
        ],
    });
    model
}

#[test]
fn force_law() {
    let law = |acts_on: &str, driver: &str, knots: &[f64], values: &[f64]| {
        let law = ["force_law", acts_on, driver];
        robot(&with_law(RobotModel::default(), law, knots, values))
    };
    // rises from 0 to 2 N between 0.2 and 0.6 s, then stays
    let over_time = law("surge_force", "t", &[0.2, 0.6], &[0.0, 2.0]);
    let state = drive_straight(&over_time, 1.0, 0.0);
    let impulse = 0.5 * 0.4 * 2.0 + 0.4 * 2.0;
    assert_near("v", state.velocity()[0], impulse / ROLLING_MASS, 1e-11);
    // -c v, as viscous drag along the body
    let over_speed = law("surge_force", "v", &[-9.0, 9.0], &[4.5, -4.5]);
    let state = drive_straight(&over_speed, 1.0, 0.05);
    let v = 2.0 * 0.05 / R / 0.5 * (1.0 - (-0.5_f64 / ROLLING_MASS).exp());
    assert_near("v", state.velocity()[0], v, 1e-7);
    // a spring along x: F = -k x
    let over_x = law("surge_force", "x", &[-1.0, 1.0], &[8.0, -8.0]);
    let state = drive_straight(&over_x, 1.0, 0.05);
    let rate = (8.0 / ROLLING_MASS).sqrt();
    let x = 2.0 * 0.05 / R / 8.0 * (1.0 - rate.cos());
    assert_near("x", state.pose()[0], x, 1e-6);
    // a constant moment, against the turn that the same moment of the motors gives
    let moment = 0.02;
    let over_rate = law("yaw_moment", "w", &[0.0], &[moment]);
    let turned = drive_straight(&over_rate, 0.1, 0.0).velocity()[2];
    let driven = spin(&robot(&RobotModel::default()), 0.1, moment * R / (2.0 * B));
    assert_near("rate", turned, driven.velocity()[2], 1e-9);
}

#[test]
fn motion_law() {
    let law = |acts_on: &str, driver: &str, knots: &[f64], values: &[f64]| {
        let law = ["motion_law", acts_on, driver];
        robot(&kinematic(with_law(
            RobotModel::default(),
            law,
            knots,
            values,
        )))
    };
    let rolling = R * 5.0;
    // a twentieth less than the wheels give
    let less = law("speed", "v", &[-1.0, 1.0], &[0.05, -0.05]);
    let state = drive_at_speeds(&less, 2.0, 5.0, 5.0);
    assert_near("x", state.pose()[0], 0.95 * rolling * 2.0, 1e-12);
    assert_near("v", state.velocity()[0], 0.95 * rolling, 1e-12);
    // rounding of 2000 sums
    assert_near("angle", state.wheel_angle()[0], 10.0, 1e-11);
    // the speed rises over time
    let over_time = law("speed", "t", &[0.0, 1.0], &[0.0, 0.3]);
    let state = drive_at_speeds(&over_time, 1.0, 5.0, 5.0);
    assert_near("x", state.pose()[0], rolling + 0.15, 1e-12);
    assert_near("a", state.acceleration()[0], 0.3, 1e-9);
    // dx/dt = v + x / 2
    let over_x = law("speed", "x", &[-1.0, 1.0], &[-0.5, 0.5]);
    let state = drive_at_speeds(&over_x, 1.0, 5.0, 5.0);
    let x = rolling * 2.0 * (0.5_f64.exp() - 1.0);
    assert_near("x", state.pose()[0], x, 1e-7);
    // turns slower than its wheels say, and drives an arc
    let slower = law("turn_rate", "w", &[-2.0, 2.0], &[0.4, -0.4]);
    let state = drive_at_speeds(&slower, 2.0, 6.0, 4.0);
    let w = 0.8 * 2.0 * R / (2.0 * B);
    assert_near("turn", state.pose()[2], 2.0 * w, 1e-12);
    assert_near("x", state.pose()[0], rolling / w * (2.0 * w).sin(), 1e-9);
    // whole turns of the heading do not count
    let over_heading = law("turn_rate", "heading", &[-1.0, 1.0], &[0.1, 0.1]);
    for turns in [-3.0, 0.0, 2.0] {
        let start = turns * std::f64::consts::TAU;
        let mut state = over_heading.start([0.0, 0.0, start]);
        drive(&over_heading, &mut state, 0.0, 1.0, STEP_S, |_| {
            Command::Twist {
                v_m_s: 0.2,
                w_rad_s: 0.0,
            }
        });
        assert_near("turn", state.pose()[2] - start, 0.1, 1e-11);
    }
}

/// c lies ahead of the axle, about whose middle the added turn is.
#[test]
fn motion_law_turns_about_the_axle() {
    let law = ["motion_law", "turn_rate", "t"];
    let robot = robot(&with_law(RobotModel::default(), law, &[0.0], &[0.5]));
    let state = drive_at_speeds(&robot, 1.0, 0.0, 0.0);
    assert_near("turn", state.pose()[2], 0.5, 1e-12);
    assert_near("x", state.pose()[0], D * (0.5_f64.cos() - 1.0), 1e-9);
    assert_near("y", state.pose()[1], D * 0.5_f64.sin(), 1e-9);
    assert_near("across", state.velocity()[1], D * 0.5, 1e-12);
}
