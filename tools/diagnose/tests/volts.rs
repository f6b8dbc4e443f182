//! What the diagnosis says of a robot that is told voltages, with its masses and without, and whose truth is known.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

mod common;

use slipstream_answer::{Answer, Verdict};
use slipstream_bus::RobotModel;
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command as Told, Stream};
use slipstream_sim::{Command, Robot};

use common::{diagnosed, noise, recording};

const STEP_S: f64 = 1e-3;
const STEPS: u32 = 30_000;

/// Thirty seconds of a robot under `volts`: commands at 20 Hz, wheels at 100 Hz with 1 mrad, poses at 20 Hz with 2 mm and
/// 4 mrad.
fn recorded(truth: &RobotModel, volts: fn(f64) -> [f64; 2]) -> Recording {
    let robot = Robot::new(truth).unwrap();
    let mut state = robot.start([0.0; 3]);
    let mut columns: [Vec<f64>; 10] = Default::default();
    let mut add = |from: usize, row: &[f64]| {
        row.iter()
            .zip(&mut columns[from..])
            .for_each(|(value, column)| column.push(*value));
    };
    for k in 0..STEPS {
        let t_s = f64::from(k) * STEP_S;
        let [right_v, left_v] = volts(f64::from(k / 50) * 0.05);
        if k % 50 == 0 {
            add(0, &[t_s, right_v, left_v]);
        }
        let errors = [0.0, 0.2, 0.4, 0.6, 0.8].map(|part| noise(f64::from(k) + part));
        if k % 10 == 0 {
            let angles = robot.measured_angle(&state);
            let [right, left] = [0, 1].map(|i| angles[i] + 1e-3 * errors[i]);
            add(3, &[t_s, right, left]);
        }
        if k % 50 == 7 {
            let [x, y, yaw] = state.pose();
            let place = [x + 2e-3 * errors[2], y + 2e-3 * errors[3]];
            add(6, &[t_s, place[0], place[1], yaw + 4e-3 * errors[4]]);
        }
        robot.step(
            &mut state,
            t_s,
            STEP_S,
            &Command::Voltage { right_v, left_v },
        );
    }
    let [t_s, right_v, left_v] = [0, 1, 2].map(|i| columns[i].clone());
    let mut recorded = recording("volts", columns);
    recorded.robots[0].command = Some(Stream {
        t_s,
        values: Told::Voltage { right_v, left_v },
        unknown: vec![],
    });
    recorded
}

/// Estimate of a parameter of a finding.
fn estimate(answer: &Answer, effect: &str, parameter: &str) -> f64 {
    let own = answer.findings.iter().find(|own| own.effect == effect);
    let mut parameters = own.unwrap().parameters.iter();
    let value = parameters.find(|own| own.name == parameter).unwrap();
    value.estimate.unwrap()
}

/// Names of what was found.
fn names(answer: &Answer) -> Vec<&str> {
    let mut names: Vec<&str> = answer
        .findings
        .iter()
        .map(|own| own.effect.as_str())
        .collect();
    names.sort_unstable();
    names
}

/// Voltages with turns both ways, forward and backward, with rests.
fn turning(t_s: f64) -> [f64; 2] {
    let straight = 4.0 * (0.7 * t_s).sin() + 1.5 * (2.3 * t_s).sin();
    let turn = 1.2 * (0.5 * t_s).cos();
    let rests = t_s.rem_euclid(6.0) > 5.0;
    [straight + turn, straight - turn].map(|volts| if rests { 0.0 } else { volts })
}

/// Without masses a drive follows voltages as those of motors without a load.
#[test]
fn a_drive_under_voltage_without_masses() {
    let mut nominal = RobotModel::default();
    nominal.robot.body_mass_kg = None;
    nominal.robot.com_to_axle_m = None;
    let truth = nominal
        .clone()
        .with("command_dead_zone", &[("voltage_v", 0.6)])
        .with("motor_gain", &[("right", 0.92), ("left", 0.9)])
        .with("actuator_lag", &[("time_constant_s", 0.12)]);
    let (answer, improved) = diagnosed(recorded(&truth, turning), &nominal).unwrap();
    let expected = ["actuator_lag", "command_dead_zone", "motor_gain"];
    assert_eq!(names(&answer), expected, "{}", answer.statement);
    // thousands of rows of 1 mrad leave a thousandth of each
    let zone_v = estimate(&answer, "command_dead_zone", "voltage_v");
    assert!((zone_v - 0.6).abs() < 0.01, "{zone_v}");
    let right = estimate(&answer, "motor_gain", "right");
    assert!((right - 0.92).abs() < 3e-3, "{right}");
    let (again, _) = diagnosed(recorded(&truth, turning), &improved).unwrap();
    assert_eq!(again.verdict, Verdict::Match, "{:?}", names(&again));
}

/// Straight on, to and fro with rests.
fn straight(t_s: f64) -> [f64; 2] {
    let volts = match (t_s / 1.5) as u32 % 6 {
        0 => 6.0,
        1 => 9.0,
        2 | 5 => 0.0,
        3 => -5.0,
        _ => -8.0,
    };
    [volts; 2]
}

/// Wheels alone, of a robot whose masses are known: a slope and the friction of its axles are told by what they take from
/// its speed.
#[test]
fn a_slope_by_wheels_under_voltage_alone() {
    let nominal = RobotModel::default();
    let truth = nominal
        .clone()
        .with("axle_friction", &[("torque_nm", 0.03)])
        .with("floor_slope", &[("grade", 0.08), ("downhill_rad", 0.0)]);
    let wheels_alone = || {
        let mut own = recorded(&truth, straight);
        own.robots[0].pose = None;
        own
    };
    let (answer, improved) = diagnosed(wheels_alone(), &nominal).unwrap();
    assert_eq!(
        names(&answer),
        ["axle_friction", "floor_slope"],
        "{}",
        answer.statement
    );
    let grade = estimate(&answer, "floor_slope", "grade");
    let torque_nm = estimate(&answer, "axle_friction", "torque_nm");
    assert!((grade - 0.08).abs() < 2e-3, "{grade}");
    assert!((torque_nm - 0.03).abs() < 1e-3, "{torque_nm}");
    assert!(estimate(&answer, "floor_slope", "downhill_rad").abs() < 1e-9);
    let (again, _) = diagnosed(wheels_alone(), &improved).unwrap();
    assert_eq!(again.verdict, Verdict::Match, "{:?}", names(&again));
}
