//! Convergence: steps of 1 ms against a reference with steps of 1 µs, over 10 s of mixed driving.

use crate::support::{drive, mixed, robot, torque, with_friction};
use slipstream_bus::RobotModel;
use slipstream_sim::{Robot, State};

const REFERENCE_S: f64 = 1e-6;

fn mixed_drive(robot: &Robot, step_s: f64, size_nm: f64) -> State {
    let mut state = robot.start([0.0; 3]);
    drive(robot, &mut state, 0.0, 10.0, step_s, |t_s| {
        let [right, left] = mixed(t_s, size_nm);
        torque(right, left)
    });
    state
}

/// Distance (m) after 10 s between a run at each of `steps_s` (s) and the reference.
fn error(model: &RobotModel, size_nm: f64, steps_s: &[f64]) -> Vec<f64> {
    let robot = robot(model);
    let reference = mixed_drive(&robot, REFERENCE_S, size_nm).pose();
    let distance = |step_s: &f64| {
        let [x, y, _] = mixed_drive(&robot, *step_s, size_nm).pose();
        (x - reference[0]).hypot(y - reference[1])
    };
    steps_s.iter().map(distance).collect()
}

#[test]
fn rolling_is_within_10_micrometres_and_second_order() {
    let errors = error(&RobotModel::default(), 0.05, &[1e-3, 2e-3]);
    println!("rolling: {errors:?}");
    assert!(errors[0] < 10e-6, "{errors:?}");
    let order = (errors[1] / errors[0]).log2();
    assert!((1.7..4.5).contains(&order), "order {order} from {errors:?}");
}

#[test]
fn slipping_is_within_100_micrometres() {
    for (friction, size_nm) in [(0.24, 0.10), (0.2, 0.09), (0.3, 0.13)] {
        let errors = error(&with_friction(friction), size_nm, &[1e-3]);
        println!("slipping at {friction}, {size_nm} N m: {errors:?}");
        assert!(errors[0] < 100e-6, "{friction}, {size_nm}: {errors:?}");
    }
}

#[test]
fn static_friction_above_kinetic_is_within_100_micrometres() {
    let model = RobotModel::paper_with_slip();
    let errors = error(&model, 0.10, &[1e-3]);
    println!("static above kinetic friction: {errors:?}");
    assert!(errors[0] < 100e-6, "{errors:?}");
}
