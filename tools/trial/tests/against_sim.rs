//! Two independent simulators agree on every effect. A disagreement is a fault of one of them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use slipstream_bus::RobotModel;
use slipstream_sim::{Command, Robot};
use slipstream_trial_plant::{Commands, Physics, Plant, Quantity};

const HOLD_S: f64 = 0.02;
const START: [f64; 3] = [0.1, -0.2, 0.3];

/// Starts, turns, brakes, reverses and stands still; [right, left] between −1 and 1.
fn profile(k: usize) -> [f64; 2] {
    let t = k as f64 * HOLD_S;
    if (t / 1.7) as usize % 4 == 3 {
        return [0.0; 2];
    }
    let right = 0.7 * (1.7 * t).sin() + 0.3 * (4.1 * t).cos();
    let left = 0.7 * (1.7 * t + 0.4).sin() - 0.3 * (3.3 * t).cos();
    [right, left]
}

/// The largest difference of position (m) and of the encoder angles (rad) over 8 s. `sim` takes steps of
/// 0.25 ms here, because at 1 ms the error of its smooth forces is some micrometres.
fn difference(model: &RobotModel, quantity: Quantity, size: f64) -> [f64; 2] {
    let rows = 0..400usize;
    let rows = rows.map(|k| (k as f64 * HOLD_S, profile(k).map(|u| u * size)));
    difference_under(model, quantity, rows.collect())
}

/// The same under these commands.
fn difference_under(
    model: &RobotModel,
    quantity: Quantity,
    rows: Vec<(f64, [f64; 2])>,
) -> [f64; 2] {
    let commands = Commands { quantity, rows };
    let plant = Plant::new(Physics::new(model).unwrap(), quantity, 1e-4);
    let mut mine = plant.start(START);
    let robot = Robot::new(model).unwrap();
    let mut other = robot.start(START);
    let mut worst = [0.0f64; 2];
    for (t_s, [right, left]) in &commands.rows {
        let (right, left) = (*right, *left);
        let command = match quantity {
            Quantity::Torque => Command::Torque {
                right_nm: right,
                left_nm: left,
            },
            Quantity::Voltage => Command::Voltage {
                right_v: right,
                left_v: left,
            },
            Quantity::Speed => Command::Speed {
                right_rad_s: right,
                left_rad_s: left,
            },
        };
        for i in 0..80 {
            robot.step(&mut other, t_s + f64::from(i) * 2.5e-4, 2.5e-4, &command);
        }
        plant.advance(&commands, &mut mine, t_s + HOLD_S, |_, _| {});
        let (pose, angle) = (other.pose(), robot.measured_angle(&other));
        worst[0] = worst[0].max((mine.pose[0] - pose[0]).hypot(mine.pose[1] - pose[1]));
        for (own, other) in mine.motor.iter().zip(angle) {
            worst[1] = worst[1].max((own - other).abs());
        }
    }
    worst
}

type Listed = (&'static str, &'static [(&'static str, f64)]);

const EFFECTS: &[Listed] = &[
    ("rolling_resistance", &[("coefficient", 0.01)]),
    ("viscous_drag", &[("coefficient", 0.5)]),
    ("quadratic_drag", &[("coefficient", 0.8)]),
    ("caster_drag", &[("friction", 0.05)]),
    ("yaw_scrub", &[("moment_nm", 0.02)]),
    ("axle_friction", &[("torque_nm", 0.006)]),
    ("torque_speed_droop", &[("coefficient", 0.002)]),
    ("actuator_lag", &[("time_constant_s", 0.03)]),
    ("actuator_delay", &[("delay_s", 0.0173)]),
    ("motor_gain", &[("right", 0.93), ("left", 1.02)]),
    ("supply_sag", &[("rate_per_s", 0.01)]),
    ("command_dead_band", &[("torque_nm", 0.012)]),
    ("command_saturation", &[("torque_nm", 0.05)]),
    ("backlash", &[("gap_rad", 0.05)]),
    ("load_transfer", &[("com_height_m", 0.08)]),
    (
        "wheel_radius",
        &[("right_scale", 1.02), ("left_scale", 0.99)],
    ),
    ("track_width", &[("scale", 1.05)]),
    (
        "payload",
        &[("mass_kg", 0.3), ("x_m", 0.02), ("y_m", -0.03)],
    ),
    ("floor_slope", &[("grade", 0.02), ("downhill_rad", 0.9)]),
    (
        "push",
        &[
            ("t_s", 3.0123),
            ("impulse_n_s", 0.2),
            ("direction_rad", 2.0),
        ],
    ),
    (
        "friction_patch",
        &[
            ("x_m", 0.25),
            ("y_m", -0.15),
            ("radius_m", 0.12),
            ("friction", 0.1),
        ],
    ),
];

/// Tolerance over 8 s: position (m) and encoder angles (rad).
const TOLERANCE: [f64; 2] = [3e-6, 5e-5];

fn agree(what: &str, model: &RobotModel, quantity: Quantity, size: f64, within: [f64; 2]) {
    let found = difference(model, quantity, size);
    println!("{what}: {:.1e} m, {:.1e} rad", found[0], found[1]);
    assert!(
        found[0] < within[0] && found[1] < within[1],
        "{what}: {found:?}"
    );
}

fn slipping(mu_static: f64, mu_kinetic: f64) -> RobotModel {
    RobotModel::default().with(
        "wheel_slip",
        &[
            ("friction_static", mu_static),
            ("friction_kinetic", mu_kinetic),
        ],
    )
}

#[test]
fn on_a_robot_that_rolls() {
    agree(
        "nothing",
        &RobotModel::default(),
        Quantity::Torque,
        0.1,
        TOLERANCE,
    );
    for (id, parameters) in EFFECTS {
        agree(
            id,
            &RobotModel::default().with(id, parameters),
            Quantity::Torque,
            0.1,
            TOLERANCE,
        );
    }
}

#[test]
fn on_a_robot_that_slips() {
    agree(
        "slip",
        &slipping(0.24, 0.24),
        Quantity::Torque,
        0.1,
        TOLERANCE,
    );
    agree(
        "breaking away",
        &slipping(0.241, 0.239),
        Quantity::Torque,
        0.1,
        TOLERANCE,
    );
    for (id, parameters) in EFFECTS {
        let within = match *id {
            // The wheels barely break away.
            "torque_speed_droop" | "axle_friction" => [2e-4, 2e-4],
            _ => TOLERANCE,
        };
        let model = slipping(0.24, 0.24).with(id, parameters);
        agree(id, &model, Quantity::Torque, 0.1, within);
    }
}

/// `sim` once separated a gear where friction brought its wheel to rest, and let static friction resist an
/// impact: the difference was half a radian in 8 s.
/// A run may start inside a patch: its friction acts from the first instant on.
#[test]
fn on_a_robot_that_starts_in_a_patch() {
    let patch = [
        ("x_m", START[0]),
        ("y_m", START[1]),
        ("radius_m", 0.3),
        ("friction", 0.02),
    ];
    let floor = slipping(0.2, 0.2);
    let model = floor.clone().with("friction_patch", &patch);
    agree("patch", &model, Quantity::Torque, 0.1, TOLERANCE);
    for (model, slides) in [(floor, false), (model, true)] {
        let robot = Robot::new(&model).unwrap();
        let mut state = robot.start(START);
        let command = Command::Torque {
            right_nm: 0.02,
            left_nm: 0.02,
        };
        robot.step(&mut state, 0.0, 1e-3, &command);
        assert_eq!(state.slides(), [slides; 2]);
    }
}

#[test]
fn backlash_agrees_together_with_every_effect() {
    let limits = ["command_dead_band", "command_saturation"];
    for base in [RobotModel::default(), slipping(0.24, 0.24)] {
        for (id, parameters) in EFFECTS.iter().filter(|(id, _)| *id != "backlash") {
            let within = match *id {
                // The wheels barely break away.
                "torque_speed_droop" => [2e-4, 2e-4],
                // The time of an impact is found to a fraction of a step, each time at another speed.
                _ => [1e-5, 1e-4],
            };
            let model = base.clone().with("backlash", &[("gap_rad", 0.02)]);
            let model = model.with(id, parameters);
            agree(id, &model, Quantity::Torque, 0.1, within);
            // The limits in the list are torques, not voltages.
            if !limits.contains(id) {
                agree(id, &model, Quantity::Voltage, 4.0, within);
            }
        }
    }
}

#[test]
fn under_voltage_and_speed() {
    for base in [RobotModel::default(), slipping(0.24, 0.24)] {
        agree("voltage", &base, Quantity::Voltage, 4.0, TOLERANCE);
        let droop = base
            .clone()
            .with("torque_speed_droop", &[("coefficient", 0.002)]);
        agree("voltage, droop", &droop, Quantity::Voltage, 4.0, TOLERANCE);
        agree("speed", &base, Quantity::Speed, 8.0, TOLERANCE);
        let gain = base
            .clone()
            .with("motor_gain", &[("right", 0.93), ("left", 1.02)]);
        agree("speed, gain", &gain, Quantity::Speed, 8.0, TOLERANCE);
    }
    let lag = RobotModel::default().with("actuator_lag", &[("time_constant_s", 0.03)]);
    agree("speed, lag", &lag, Quantity::Speed, 8.0, TOLERANCE);
}

/// `sim` once ignored the traction needed by wheels whose speed changes by a lag: they then stuck where they
/// slip, and the difference was a centimetre in 8 s.
#[test]
fn wheels_accelerated_through_a_lag_slip() {
    for model in [slipping(0.24, 0.24), slipping(0.26, 0.2)] {
        let model = model.with("actuator_lag", &[("time_constant_s", 0.03)]);
        // The rate of the lag is constant over a step.
        let within = [5e-5, 5e-5];
        agree("speed, lag", &model, Quantity::Speed, 8.0, within);
        let load = model.with("load_transfer", &[("com_height_m", 0.08)]);
        agree("speed, lag, load", &load, Quantity::Speed, 8.0, within);
    }
}

/// In a curve both wheels share the lateral force until one breaks away. `sim` once released the other one
/// too, which static friction holds.
#[test]
fn one_wheel_breaks_away_in_a_curve_and_the_other_sticks() {
    let rows = 0..40usize;
    let rows = rows.map(|k| {
        let t = k as f64 * HOLD_S;
        let right = (2.9 * t + 6.0).sin() + 0.2 * (5.0 * t).cos();
        (t, [0.13 * right, 0.13 * (2.1 * t + 12.0).sin()])
    });
    let found = difference_under(&slipping(0.26, 0.2), Quantity::Torque, rows.collect());
    assert!(
        found[0] < TOLERANCE[0] && found[1] < TOLERANCE[1],
        "{found:?}"
    );
}
