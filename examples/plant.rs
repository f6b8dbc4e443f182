//! One robot on a slippery floor: true motion, what its encoders say, and a derivative.
//!
//!     cargo run --release -p slipstream-sim --example plant

use num_dual::DualSVec64;
use slipstream_bus::{InputError, RobotModel};
use slipstream_sim::{Command, Robot, Scalar, State, lift, read_effects};

/// A number with the derivative with respect to one parameter.
type Dual = DualSVec64<1>;

const STEP_S: f64 = 1e-3;

fn main() -> Result<(), InputError> {
    // The robot of the paper on a floor with μ_s = 0.241 and μ_k = 0.239.
    let model = RobotModel::paper_with_slip();
    let robot = Robot::new(&model)?;
    println!("torque   true distance   by encoders   slip");
    for torque_nm in [0.05, 0.09, 0.11, 0.13] {
        let state = accelerate(&robot, torque_nm);
        let [x_m, ..] = state.pose();
        let by_encoders_m = state.wheel_angle()[0] * model.robot.wheel_radius_m;
        let slip_m = by_encoders_m - x_m;
        println!("{torque_nm:.2} N m  {x_m:11.3} m {by_encoders_m:11.3} m {slip_m:7.3} m");
    }

    // The same robot with dual numbers: how far does it come if μ_k is larger?
    let effects = read_effects(&model)?;
    let dual = lift(&effects, |_, name, value| {
        let constant = Dual::from_re(value);
        if name == "friction_kinetic" {
            constant.derivative(0)
        } else {
            constant
        }
    });
    let state = accelerate(&Robot::assemble(&model, &dual)?, 0.13);
    let change_m = state.pose()[0]
        .eps
        .0
        .map_or(0.0, |derivative| derivative[0])
        * 0.01;
    println!("With μ_k larger by 0.01, 0.13 N m move it {change_m:.4} m further.");
    Ok(())
}

/// The state after half a second of the same torque on both wheels.
fn accelerate<S: Scalar>(robot: &Robot<S>, torque_nm: f64) -> State<S> {
    let mut state = robot.start([S::constant(0.0); 3]);
    let torque = S::constant(torque_nm);
    let command = Command::Torque {
        right_nm: torque,
        left_nm: torque,
    };
    for step in 0..500 {
        robot.step(&mut state, f64::from(step) * STEP_S, STEP_S, &command);
    }
    state
}
