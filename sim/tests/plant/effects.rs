//! Each effect against a closed form or a limit.

use std::f64::consts::TAU;

use crate::support::{STEP_S, assert_near, drive, gripping, robot, torque};
use slipstream_bus::RobotModel;
use slipstream_sim::effects::{CATALOGUE, Domain};
use slipstream_sim::{Command, GRAVITY_M_S2, Robot, State, Stream};

const R: f64 = 0.0365;
const B: f64 = 0.105;
const D: f64 = 0.055;
const E: f64 = 0.095;
const M: f64 = 1.628;
const I_WY: f64 = 0.001_168;
/// Mass that a torque at both wheels has to move: m_t + 2 I_wy / r².
const ROLLING: f64 = M + 2.0 * I_WY / (R * R);

fn with(effect: &str, parameters: &[(&str, f64)]) -> Robot {
    robot(&RobotModel::default().with(effect, parameters))
}

fn ahead(robot: &Robot, over_s: f64, torque_nm: f64) -> State {
    let mut state = robot.start([0.0; 3]);
    drive(robot, &mut state, 0.0, over_s, STEP_S, |_| {
        torque(torque_nm, torque_nm)
    });
    state
}

/// Spins in place by opposite torques.
fn spin(robot: &Robot, over_s: f64, torque_nm: f64) -> State {
    let mut state = robot.start([0.0; 3]);
    drive(robot, &mut state, 0.0, over_s, STEP_S, |_| {
        torque(torque_nm, -torque_nm)
    });
    state
}

fn speed_after(robot: &Robot, over_s: f64, right: f64, left: f64) -> State {
    let mut state = robot.start([0.0; 3]);
    let command = |_| Command::Speed {
        right_rad_s: right,
        left_rad_s: left,
    };
    drive(robot, &mut state, 0.0, over_s, STEP_S, command);
    state
}

#[test]
fn rolling_resistance() {
    let c = 0.01;
    let state = ahead(
        &with("rolling_resistance", &[("coefficient", c)]),
        1.0,
        0.05,
    );
    let a = (2.0 * 0.05 / R - c * M * GRAVITY_M_S2) / ROLLING;
    assert_near("v", state.velocity()[0], a, 1e-12);
    // below the limit nothing moves
    let held = 0.9 * c * M * GRAVITY_M_S2 * R / 2.0;
    let state = ahead(
        &with("rolling_resistance", &[("coefficient", c)]),
        1.0,
        held,
    );
    for value in state.pose() {
        assert_near("held", value, 0.0, 1e-15);
    }
}

#[test]
fn axle_friction() {
    let t = 0.006;
    let state = ahead(&with("axle_friction", &[("torque_nm", t)]), 1.0, 0.05);
    assert_near(
        "v",
        state.velocity()[0],
        2.0 * (0.05 - t) / R / ROLLING,
        1e-12,
    );
    let state = ahead(&with("axle_friction", &[("torque_nm", t)]), 1.0, 0.99 * t);
    assert_eq!(state.pose(), [0.0; 3]);
}

#[test]
fn yaw_scrub() {
    let moment = 0.01;
    let free = spin(&robot(&RobotModel::default()), 0.1, 0.05).velocity()[2];
    let state = spin(&with("yaw_scrub", &[("moment_nm", moment)]), 0.1, 0.05);
    let drive = 2.0 * 0.05 * B / R;
    // both accelerate in proportion to the moment that is left; the turn's φ̇² moves c ahead and
    // takes 1e-4 of it
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
    let state = ahead(&with("caster_drag", &[("friction", friction)]), 1.0, 0.05);
    let caster = M * GRAVITY_M_S2 * D / (D + E);
    let a = (2.0 * 0.05 / R - friction * caster) / ROLLING;
    assert_near("v", state.velocity()[0], a, 1e-12);
}

#[test]
fn a_caster_that_holds_lets_go_at_its_own_load() {
    let friction = 0.05;
    let caster = M * GRAVITY_M_S2 * D / (D + E);
    let limit_nm = friction * caster * R / 2.0;
    let robot = with("caster_drag", &[("friction", friction)]);
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
    let state = ahead(&with("quadratic_drag", &[("coefficient", c)]), 2.0, 0.03);
    let f = 2.0 * 0.03 / R;
    let v = (f / c).sqrt() * ((f * c).sqrt() / ROLLING * 2.0).tanh();
    assert_near("v", state.velocity()[0], v, 1e-7);
}

#[test]
fn torque_speed_droop() {
    let k = 2e-3;
    let state = ahead(
        &with("torque_speed_droop", &[("coefficient", k)]),
        1.0,
        0.03,
    );
    let rate = 2.0 * k / (ROLLING * R * R);
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
    let state = ahead(&with("actuator_delay", &[("delay_s", delay)]), 1.0, 0.05);
    let a = 2.0 * 0.05 / R / ROLLING;
    assert_near("v", state.velocity()[0], a * (1.0 - delay), 1e-12);
    assert_near("x", state.pose()[0], a * (1.0 - delay).powi(2) / 2.0, 1e-12);
}

#[test]
fn actuator_lag() {
    let lag = 0.05;
    let state = ahead(
        &with("actuator_lag", &[("time_constant_s", lag)]),
        1.0,
        0.05,
    );
    let a = 2.0 * 0.05 / R / ROLLING;
    assert_near(
        "v",
        state.velocity()[0],
        a * (1.0 - lag * (1.0 - (-1.0 / lag).exp())),
        1e-12,
    );
    let state = speed_after(
        &with("actuator_lag", &[("time_constant_s", lag)]),
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
    let free = ahead(&robot(&RobotModel::default()), 1.0, 0.05).velocity()[0];
    let state = ahead(
        &with("motor_gain", &[("right", 0.9), ("left", 0.9)]),
        1.0,
        0.05,
    );
    assert_near("gain", state.velocity()[0], 0.9 * free, 1e-12);
    let state = ahead(&with("supply_sag", &[("rate_per_s", 0.02)]), 1.0, 0.05);
    assert_near("sag", state.velocity()[0], free * (1.0 - 0.02 / 2.0), 1e-12);
}

#[test]
fn dead_band_and_saturation() {
    let band = with("command_dead_band", &[("torque_nm", 0.02)]);
    assert_eq!(ahead(&band, 1.0, 0.0199).pose(), [0.0; 3]);
    let free = ahead(&robot(&RobotModel::default()), 1.0, 0.05);
    let above = ahead(&band, 1.0, 0.05).pose()[0];
    assert_near("above the band", above, free.pose()[0], 1e-12);
    let cut = ahead(
        &with("command_saturation", &[("torque_nm", 0.05)]),
        1.0,
        0.2,
    );
    assert_near("cut", cut.pose()[0], free.pose()[0], 1e-12);
    let cut = speed_after(
        &with("command_saturation", &[("speed_rad_s", 2.0)]),
        1.0,
        9.0,
        -9.0,
    );
    assert_eq!(cut.wheel_speed(), [2.0, -2.0]);
}

/// The motors cross half the gap alone, a quarter of I_wy each, then take wheels and robot along.
#[test]
fn backlash() {
    let (gap, torque_nm) = (0.04, 0.02);
    let robot = with("backlash", &[("gap_rad", gap)]);
    let alone = torque_nm / (I_WY / 4.0);
    let contact_s = (gap / alone).sqrt();
    let before = (contact_s / STEP_S).floor() * STEP_S;
    let state = ahead(&robot, before, torque_nm);
    assert_eq!(state.pose(), [0.0; 3]);
    let state = ahead(&robot, 0.5, torque_nm);
    // momentum about the axles: the motors' before, everybody's after
    let motors = I_WY / 4.0 * alone * contact_s;
    let shared = motors / (ROLLING * R * R / 2.0);
    let rate = torque_nm / (ROLLING * R * R / 2.0);
    let speed = shared + rate * (0.5 - contact_s);
    // the meeting is found to 1 ms / 8192
    assert_near("speed", state.wheel_speed()[0], speed, 1e-4);
    let apart = robot.measured_angle(&state)[0] - state.wheel_angle()[0];
    assert_near("gap", apart, gap / 2.0, 1e-6);
}

/// Gears hold each other also where a blow makes the wheel slide and friction brings it to rest:
/// motor and wheel are never further apart than half of the gap.
#[test]
fn backlash_under_slip() {
    let gap = 0.055;
    let robot = robot(&gripping(0.241).with("backlash", &[("gap_rad", gap)]));
    let mut state = robot.start([0.0; 3]);
    let mut worst: f64 = 0.0;
    for k in 0..20_000 {
        let t_s = f64::from(k) * STEP_S;
        let command = Command::Voltage {
            right_v: 5.0 * (2.3 * t_s).sin() + 2.0 * (5.1 * t_s).sin(),
            left_v: 5.0 * (1.9 * t_s).sin() - 2.0 * (4.3 * t_s).sin(),
        };
        robot.step(&mut state, t_s, STEP_S, &command);
        let (motor, wheel) = (robot.measured_angle(&state), state.wheel_angle());
        for i in 0..2 {
            worst = worst.max((motor[i] - wheel[i]).abs() - gap / 2.0);
        }
    }
    // a meeting is found to 1 ms / 8192, at a rad/s
    assert!(worst < 1e-6, "{worst} rad into each other");
}

#[test]
fn load_transfer() {
    let (mu, height) = (0.24, 0.05);
    let model = gripping(mu).with("load_transfer", &[("com_height_m", height)]);
    let state = ahead(&robot(&model), 0.5, 0.3);
    let a = mu * GRAVITY_M_S2 * E / (D + E) / (1.0 - mu * height / (D + E));
    assert_near("v", state.velocity()[0], a * 0.5, 1e-11);
}

#[test]
fn wheel_radius_and_track_width() {
    let scales = [("right_scale", 1.02), ("left_scale", 0.97)];
    let state = speed_after(&with("wheel_radius", &scales), 1.0, 5.0, 5.0);
    let [right, left] = [1.02 * R * 5.0, 0.97 * R * 5.0];
    assert_near("turn", state.pose()[2], (right - left) / (2.0 * B), 1e-12);
    let state = speed_after(&with("track_width", &[("scale", 1.3)]), 1.0, 5.0, -5.0);
    assert_near("turn", state.pose()[2], 5.0 * R / (1.3 * B), 1e-12);
}

#[test]
fn payload() {
    let list = [("mass_kg", 0.4), ("x_m", 0.0), ("y_m", 0.0)];
    let state = ahead(&with("payload", &list), 1.0, 0.05);
    assert_near(
        "v",
        state.velocity()[0],
        2.0 * 0.05 / R / (ROLLING + 0.4),
        1e-12,
    );
    // beside the axis it presses one wheel down: N_r − N_l = −m_p g y / b
    let list = [("mass_kg", 0.4), ("x_m", -0.02), ("y_m", 0.03)];
    let model = gripping(0.3).with("payload", &list);
    let [right, left] = ahead(&robot(&model), 0.001, 0.0).contact_forces().normal_n;
    assert_near("apart", right - left, -0.4 * GRAVITY_M_S2 * 0.03 / B, 1e-9);
    let caster = (M * D + 0.4 * (D - 0.02)) * GRAVITY_M_S2 / (D + E);
    assert_near("sum", right + left, (M + 0.4) * GRAVITY_M_S2 - caster, 1e-9);
}

#[test]
fn floor_slope() {
    let grade: f64 = 0.02;
    let robot = with("floor_slope", &[("grade", grade), ("downhill_rad", 0.0)]);
    let state = ahead(&robot, 1.0, 0.0);
    let g = GRAVITY_M_S2 * grade / (1.0 + grade * grade).sqrt();
    assert_near("v", state.velocity()[0], g * M / ROLLING, 1e-12);
    let uphill = ahead(&robot, 1.0, -M * g * R / 2.0);
    assert_near("balance", uphill.velocity()[0], 0.0, 1e-12);
}

#[test]
fn push() {
    let list = [
        ("t_s", 0.2345),
        ("impulse_n_s", 0.3),
        ("direction_rad", 0.0),
    ];
    let state = ahead(&with("push", &list), 1.0, 0.0);
    assert_near("v", state.velocity()[0], 0.3 / ROLLING, 1e-12);
    // half a step of the force's start is averaged: F h² / 8 m at most
    let way = 0.3 / ROLLING * (1.0 - 0.2345 - 0.03);
    assert_near("x", state.pose()[0], way, 1e-6);
}

#[test]
fn friction_patch() {
    let list = [
        ("x_m", 0.5),
        ("y_m", 0.0),
        ("radius_m", 0.15),
        ("friction", 0.02),
    ];
    let robot = robot(&gripping(0.3).with("friction_patch", &list));
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

#[test]
fn sensors() {
    let offset = with(
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
        let robot = with(effect, &[("latency_s", 0.04)]);
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
        with("link_delay", &[("delay_s", 0.1)]).link_delay_s(),
        0.1,
        0.0,
    );
    let scaled = with(
        "encoder_scale",
        &[("right_scale", 1.1), ("left_scale", 0.9)],
    );
    let state = speed_after(&scaled, 1.0, 2.0, 2.0);
    let [right, left] = scaled.measured_angle(&state);
    assert_near("right", right, 2.2, 1e-12);
    assert_near("left", left, 1.8, 1e-12);
}

/// An inertial sensor at rest on a slope sees the slope, and on the flat nothing.
#[test]
fn inertial_sensor_on_a_slope() {
    let robot = with("floor_slope", &[("grade", 0.1), ("downhill_rad", 0.0)]);
    let state = speed_after(&robot, 0.1, 0.0, 0.0);
    let g = GRAVITY_M_S2 * 0.1 / (1.0_f64 + 0.01).sqrt();
    assert_near("along", robot.measured_inertial(&state)[0], -g, 1e-9);
}

/// Every effect of the contract is in the catalogue, once, complete, with probes inside its bounds.
#[test]
fn the_catalogue_is_complete() {
    let contract = "wheel_slip friction_patch rolling_resistance viscous_drag quadratic_drag \
        caster_drag yaw_scrub axle_friction torque_speed_droop actuator_lag actuator_delay \
        motor_gain supply_sag command_dead_band command_saturation backlash load_transfer \
        wheel_radius track_width payload floor_slope pose_offset pose_latency wheels_latency \
        imu_latency encoder_scale clock_drift link_delay push";
    let mut expected: Vec<&str> = contract.split_whitespace().collect();
    let mut known: Vec<&str> = CATALOGUE.iter().map(|info| info.id).collect();
    expected.sort_unstable();
    known.sort_unstable();
    assert_eq!(known, expected);
    for info in CATALOGUE {
        assert!(
            !info.channels.is_empty() && !info.equation.is_empty(),
            "{}",
            info.id
        );
        for parameter in info.parameters {
            if let Domain::Number {
                lower,
                upper,
                probes,
            } = parameter.domain
            {
                assert!(
                    probes.iter().all(|p| (lower..=upper).contains(p)),
                    "{}",
                    info.id
                );
            }
        }
    }
}

/// Wrong effects are refused with the key and a remedy.
#[test]
fn wrong_effects_are_refused() {
    type Case = (&'static str, &'static [(&'static str, f64)], &'static str);
    let cases: [Case; 7] = [
        ("wheel_slipp", &[], "effects.wheel_slipp"),
        (
            "viscous_drag",
            &[("coeficient", 1.0)],
            "effects.viscous_drag.coeficient",
        ),
        (
            "viscous_drag",
            &[("coefficient", f64::NAN)],
            "effects.viscous_drag.coefficient",
        ),
        (
            "viscous_drag",
            &[("coefficient", -1.0)],
            "effects.viscous_drag.coefficient",
        ),
        (
            "wheel_slip",
            &[("friction_static", 0.2)],
            "effects.wheel_slip.friction_kinetic",
        ),
        ("command_dead_band", &[], "effects.command_dead_band"),
        (
            "payload",
            &[("mass_kg", 9.0), ("x_m", 0.5), ("y_m", 0.0)],
            "effects.payload.x_m",
        ),
    ];
    for (effect, parameters, key) in cases {
        let error = Robot::new(&RobotModel::default().with(effect, parameters)).unwrap_err();
        assert_eq!(error.place, key, "{error}");
    }
    let mut kinematic = RobotModel::default().with("viscous_drag", &[("coefficient", 1.0)]);
    kinematic.robot.body_mass_kg = None;
    assert_eq!(
        Robot::new(&kinematic).unwrap_err().place,
        "robot.body_mass_kg"
    );
}
