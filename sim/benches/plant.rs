//! Throughput of the plant in robot steps per second, with and without derivatives, on one core.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use num_dual::DualSVec64;
use slipstream_bus::{RobotModel, Sensors};
use slipstream_sim::{Command, Robot, Scalar, Setup, State, World};

const STEPS: u32 = 20_000;
const STEP_S: f64 = 1e-3;

fn main() {
    divan::main();
}

/// Torques that drive and turn the robot back and forth, for 0.3 s each.
fn torque<S: Scalar>(k: u32, size_nm: f64) -> Command<S> {
    let signs = [[1.0, 0.9], [-0.9, -1.0], [1.0, -1.0], [-1.0, 1.0]][(k / 300 % 4) as usize];
    let [right_nm, left_nm] = signs.map(|sign| S::constant(sign * size_nm));
    Command::Torque { right_nm, left_nm }
}

fn drive<S: Scalar>(robot: &Robot<S>, state: &mut State<S>, size_nm: f64) {
    for k in 0..STEPS {
        robot.step(state, f64::from(k) * STEP_S, STEP_S, &torque(k, size_nm));
    }
}

fn measure<S: Scalar>(bencher: Bencher<'_, '_>, model: &RobotModel, size_nm: f64) {
    let lifted = slipstream_sim::lift(
        &slipstream_sim::read_effects(model).unwrap(),
        |_, _, value| S::constant(value),
    );
    let robot = Robot::<S>::assemble(model, &lifted).unwrap();
    bencher
        .counter(ItemsCount::new(STEPS))
        .with_inputs(|| robot.start([S::constant(0.0); 3]))
        .bench_local_values(|mut state| {
            drive(black_box(&robot), &mut state, size_nm);
            state
        });
}

#[divan::bench(name = "1 robot, rolling by assumption (Eq. 1)")]
fn one_ideal(bencher: Bencher<'_, '_>) {
    measure::<f64>(bencher, &RobotModel::default(), 0.02);
}

#[divan::bench(name = "1 robot, rolling within friction")]
fn one_rolling(bencher: Bencher<'_, '_>) {
    measure::<f64>(bencher, &RobotModel::paper_with_slip(), 0.02);
}

#[divan::bench(name = "1 robot, slipping and sticking")]
fn one_slipping(bencher: Bencher<'_, '_>) {
    measure::<f64>(bencher, &RobotModel::paper_with_slip(), 0.13);
}

#[divan::bench(name = "1 robot, slipping all the time")]
fn one_sliding(bencher: Bencher<'_, '_>) {
    let robot = Robot::new(&RobotModel::paper_with_slip()).unwrap();
    let torque = Command::Torque {
        right_nm: 0.13,
        left_nm: 0.129,
    };
    bencher
        .counter(ItemsCount::new(STEPS))
        .with_inputs(|| robot.start([0.0; 3]))
        .bench_local_values(|mut state| {
            for k in 0..STEPS {
                black_box(&robot).step(&mut state, f64::from(k) * STEP_S, STEP_S, &torque);
            }
            state
        });
}

#[divan::bench(name = "1 robot, slipping and sticking, 8 derivatives at once")]
fn one_slipping_dual(bencher: Bencher<'_, '_>) {
    measure::<DualSVec64<8>>(bencher, &RobotModel::paper_with_slip(), 0.13);
}

#[divan::bench(name = "1 robot, rolling, 8 derivatives at once")]
fn one_rolling_dual(bencher: Bencher<'_, '_>) {
    measure::<DualSVec64<8>>(bencher, &RobotModel::paper_with_slip(), 0.02);
}

fn hundred(bencher: Bencher<'_, '_>, model: &RobotModel, size_nm: f64) {
    let setups: Vec<Setup> = (0..100)
        .map(|i| Setup {
            name: format!("r{i}"),
            model: model.clone(),
            pose: [f64::from(i), 0.0, 0.0],
            sensors: Sensors::default(),
        })
        .collect();
    let steps = STEPS / 20;
    bencher
        .counter(ItemsCount::new(steps * 100))
        .with_inputs(|| World::new(&setups, 1).unwrap())
        .bench_local_values(|mut world| {
            for k in 0..steps {
                world.step(1_000_000, &[torque(k, size_nm); 100]);
            }
            world
        });
}

#[divan::bench(name = "100 robots, rolling by assumption (Eq. 1)")]
fn hundred_ideal(bencher: Bencher<'_, '_>) {
    hundred(bencher, &RobotModel::default(), 0.02);
}

#[divan::bench(name = "100 robots, rolling within friction")]
fn hundred_rolling(bencher: Bencher<'_, '_>) {
    hundred(bencher, &RobotModel::paper_with_slip(), 0.02);
}

#[divan::bench(name = "100 robots, slipping and sticking")]
fn hundred_slipping(bencher: Bencher<'_, '_>) {
    hundred(bencher, &RobotModel::paper_with_slip(), 0.13);
}
