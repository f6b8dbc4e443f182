//! Motions with a closed-form solution.

use crate::support::{STEP_S, assert_near, drive, robot, torque, with_friction};
use slipstream_bus::RobotModel;
use slipstream_sim::{Command, CommandKind, GRAVITY_M_S2, Robot};

const R: f64 = 0.0365;
const B: f64 = 0.105;
const D: f64 = 0.055;
const E: f64 = 0.095;
const M: f64 = 1.5 + 2.0 * 0.064;
const I_WY: f64 = 0.001_168;

/// N_r = N_l on a straight line (Eq. 4 to 6).
fn normal_n() -> f64 {
    M * GRAVITY_M_S2 * E / (D + E) / 2.0
}

/// Eq. 8: a = 2 τ r / (m r² + 2 I_wy). A constant acceleration is integrated exactly up to rounding
/// over 1000 steps.
#[test]
fn straight_acceleration_while_rolling() {
    let robot = robot(&RobotModel::default());
    let mut state = robot.start([0.0; 3]);
    drive(&robot, &mut state, 0.0, 1.0, STEP_S, |_| torque(0.05, 0.05));
    let a = 2.0 * 0.05 * R / (M * R * R + 2.0 * I_WY);
    assert_near("x", state.pose()[0], a / 2.0, 1e-12);
    assert_near("v", state.velocity()[0], a, 1e-12);
    assert_near("angle", state.wheel_angle()[0], a / 2.0 / R, 1e-10);
    assert_near("y", state.pose()[1], 0.0, 1e-14);
}

/// 0.13 N m for 0.5 s makes the wheels break away at once. The body is accelerated by μ N and the
/// wheel by the rest of the torque, until their speeds are equal again: an event inside a step.
#[test]
fn straight_acceleration_with_slip() {
    let (tau, mu) = (0.13, 0.239);
    let robot = robot(&with_friction(mu));
    let mut state = robot.start([0.0; 3]);
    let push = |t_s: f64| {
        if t_s < 0.5 {
            torque(tau, tau)
        } else {
            torque(0.0, 0.0)
        }
    };
    drive(&robot, &mut state, 0.0, 0.5, STEP_S, push);
    let body = 2.0 * mu * normal_n() / M;
    let wheel = (tau - R * mu * normal_n()) / I_WY * R;
    assert_near("body", state.pose()[0], body / 8.0, 1e-12);
    assert_near("wheel", R * state.wheel_angle()[0], wheel / 8.0, 1e-12);
    assert_near("body, as published", state.pose()[0], 0.1856, 5e-5);
    assert_near(
        "wheel, as published",
        R * state.wheel_angle()[0],
        0.3355,
        5e-5,
    );

    let slip = (wheel - body) * 0.5;
    let closing = body + R * R * mu * normal_n() / I_WY;
    let duration = slip / closing;
    let mut slid = 0.0;
    for k in 500..2000 {
        let t_s = f64::from(k) * STEP_S;
        if state.slides() == [true, true] {
            slid = t_s + STEP_S - 0.5;
        }
        robot.step(&mut state, t_s, STEP_S, &push(t_s));
    }
    assert_near("slip lasts", slid, duration, STEP_S);
    assert_near("slip lasts, as published", duration, 0.209, 5e-4);
    let gap = R * state.wheel_angle()[0] - state.pose()[0];
    // the event is located to 1 ms / 8192, in which the speeds differ by up to 0.4 µm/s
    assert_near(
        "gap",
        gap,
        slip * 0.5 / 2.0 + slip * duration / 2.0,
        1e-9 + 4e-7,
    );
    assert_near("gap, as published", gap, 0.2126, 5e-5);
}

/// Wheels break away above τ_max (Eq. 11) and stick below it.
#[test]
fn wheels_break_away_at_tau_max() {
    let mu = 0.24;
    let tau_max = mu * normal_n() * (2.0 * I_WY + M * R * R) / (M * R);
    let robot = robot(&with_friction(mu));
    for (factor, slides) in [(1.0 - 1e-8, false), (1.0 + 1e-8, true)] {
        let mut state = robot.start([0.0; 3]);
        let tau = tau_max * factor;
        drive(&robot, &mut state, 0.0, 0.1, STEP_S, |_| torque(tau, tau));
        assert_eq!(state.slides(), [slides; 2], "at {factor} of the limit");
    }
}

/// Wheel speeds ω_r, ω_l drive a circle of radius v / ω about the axle's middle.
#[test]
fn steady_circle() {
    let robot = robot(&RobotModel::default());
    let (v, w) = (0.4, 1.3);
    let mut state = robot.start([0.0; 3]);
    let circle = |_| Command::Twist {
        v_m_s: v,
        w_rad_s: w,
    };
    drive(&robot, &mut state, 0.0, 7.0, STEP_S, circle);
    // the axle's middle starts at (−d, 0) and runs on a circle about (−d, v / w)
    let (sin, cos) = (w * 7.0).sin_cos();
    let axle = [v / w * sin - D, v / w * (1.0 - cos)];
    let [x, y, phi] = state.pose();
    assert_near("phi", phi, w * 7.0, 1e-11);
    // arcs of 1.3 mrad per step are integrated exactly up to rounding
    assert_near("x", x, axle[0] + D * cos, 1e-11);
    assert_near("y", y, axle[1] + D * sin, 1e-11);
    let [right, left] = state.wheel_speed();
    assert_near("right wheel", right, (v + B * w) / R, 1e-12);
    assert_near("left wheel", left, (v - B * w) / R, 1e-12);
}

/// Against viscous drag alone the speed of a coasting robot decays with rate k = c / (m + 2 I_wy /
/// r²): it covers v0 / k.
#[test]
fn coast_down() {
    let robot = robot(&RobotModel::default().with("viscous_drag", &[("coefficient", 2.0)]));
    let mut state = robot.start([0.0; 3]);
    let mass = M + 2.0 * I_WY / (R * R);
    let push = |t_s: f64| {
        if t_s < 0.5 {
            torque(0.06, 0.06)
        } else {
            torque(0.0, 0.0)
        }
    };
    drive(&robot, &mut state, 0.0, 0.5, STEP_S, push);
    let (start, v0) = (state.pose()[0], state.velocity()[0]);
    let pull = 2.0 * 0.06 / R / 2.0;
    // trapezoidal rule on an exponential: (k h)² / 12 of the speed, k h = 0.6e-3
    assert_near(
        "speed",
        v0,
        pull * (1.0 - (-2.0 / mass * 0.5_f64).exp()),
        1e-7,
    );
    drive(&robot, &mut state, 0.5, 20.0, STEP_S, push);
    let far = v0 * mass / 2.0 * (1.0 - (-2.0 / mass * 20.0_f64).exp());
    assert_near("distance", state.pose()[0] - start, far, 1e-7);
}

/// With axle friction that exceeds the slope's moment, and with a speed command of zero, a robot
/// stands still on a slope for ten minutes in any orientation, to the last bit.
#[test]
fn standing_on_a_slope() {
    for downhill in [0.0, 1.0, std::f64::consts::FRAC_PI_2, 3.0] {
        let slope = with_friction(0.24).with(
            "floor_slope",
            &[("grade", 0.05), ("downhill_rad", downhill)],
        );
        let braked = slope.clone().with("axle_friction", &[("torque_nm", 0.03)]);
        let cases = [
            (
                slope,
                Command::Speed {
                    right_rad_s: 0.0,
                    left_rad_s: 0.0,
                },
            ),
            (braked, torque(0.0, 0.0)),
        ];
        for (model, command) in cases {
            let robot = robot(&model);
            let mut state = robot.start([1.0, 2.0, 0.5]);
            drive(&robot, &mut state, 0.0, 600.0, STEP_S, |_| command);
            assert_eq!(
                state.pose(),
                [1.0, 2.0, 0.5],
                "downhill {downhill}, {command:?}"
            );
            assert_eq!(state.wheel_angle(), [0.0; 2]);
        }
    }
}

/// A robot with locked wheels slides down a slope that is steeper than its friction angle. Only the
/// driven wheels brake, so that m g sin α − μ (N_r + N_l) accelerates it.
#[test]
fn sliding_down_a_steep_slope() {
    let (mu, grade): (f64, f64) = (0.24, 0.3);
    let model = with_friction(mu).with("floor_slope", &[("grade", grade), ("downhill_rad", 0.0)]);
    let robot = robot(&model);
    let mut state = robot.start([0.0; 3]);
    let locked = |_| Command::Speed {
        right_rad_s: 0.0,
        left_rad_s: 0.0,
    };
    drive(&robot, &mut state, 0.0, 1.0, STEP_S, locked);
    let upright = 1.0 / (1.0 + grade * grade).sqrt();
    let a = GRAVITY_M_S2 * upright * (grade - mu * E / (D + E));
    assert_near("x", state.pose()[0], a / 2.0, 1e-12);
}

/// Under a voltage the robot approaches the motor's no-load speed: τ = k V − c ω.
#[test]
fn voltage_drives_to_the_no_load_speed() {
    let robot = robot(&RobotModel::default());
    let mut state = robot.start([0.0; 3]);
    let half = |_| Command::Voltage {
        right_v: 6.0,
        left_v: 6.0,
    };
    drive(&robot, &mut state, 0.0, 0.1, STEP_S, half);
    let inertia = I_WY + M * R * R / 2.0;
    let rate = 0.78 / 36.65 / inertia;
    let speed = 36.65 / 2.0 * (1.0 - (-rate * 0.1_f64).exp());
    // trapezoidal rule: (rate h)² / 12 of the speed, rate h = 9.4e-3
    assert_near("spinning up", state.wheel_speed()[0], speed, 3e-4);
    drive(&robot, &mut state, 0.1, 5.0, STEP_S, half);
    assert_near("no load", state.wheel_speed()[0], 36.65 / 2.0, 1e-9);
}

/// Of a robot without masses the wheels turn as fast as motors without a load do, behind dead zone, gain and lag:
/// w = g (k V − k V_0 / g) (1 − exp(−t / T)).
#[test]
fn voltage_without_masses_prescribes_speeds() {
    let mut model = RobotModel::default()
        .with("command_dead_zone", &[("voltage_v", 0.5)])
        .with("motor_gain", &[("right", 0.9), ("left", 1.0)])
        .with("actuator_lag", &[("time_constant_s", 0.2)]);
    model.robot.body_mass_kg = None;
    let robot = robot(&model);
    assert_eq!(robot.accepts(CommandKind::Voltage), Ok(()));
    assert!(robot.accepts(CommandKind::Torque).is_err());
    let mut state = robot.start([0.0; 3]);
    drive(&robot, &mut state, 0.0, 0.3, STEP_S, |_| Command::Voltage {
        right_v: 6.0,
        left_v: -6.0,
    });
    let share = 1.0 - (-0.3_f64 / 0.2).exp();
    let per_volt = 36.65 / 12.0;
    let [right, left] = state.wheel_speed();
    assert_near("right", right, per_volt * (0.9 * 6.0 - 0.5) * share, 1e-9);
    assert_near("left", left, -per_volt * (6.0 - 0.5) * share, 1e-9);
    model.motor = None;
    let place = Robot::new(&model)
        .unwrap()
        .accepts(CommandKind::Voltage)
        .unwrap_err()
        .place;
    assert_eq!(place, "motor");
}
