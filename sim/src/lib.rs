//! Simulation of differential-drive robots with wheel slip: plant, effects, sensors, and the
//! plant's part of a run.
//!
//! The model is that of Konduri, Torres and Pagilla, *Effect of Wheel Slip in the Coordination of
//! Wheeled Mobile Robots* (Eq. 1 to 6, 9 and 10; symbols as there), extended by a catalogue of
//! [`effects`]. With Coulomb friction it is a hybrid system: [`Robot::step`] integrates the smooth
//! motion by Heun's method and locates the events, such as a wheel that breaks away or comes to
//! rest, inside the step.
//!
//! * [`Robot`] has the constants of one robot, [`State`] all that changes.
//! * [`World`] is N robots with sensors and noise.
//! * [`run`] steps a world through an experiment.
//!
//! # One robot
//!
//! ```
//! use slipstream_bus::RobotModel;
//! use slipstream_sim::{Command, Robot};
//!
//! let robot = Robot::new(&RobotModel::paper_with_slip())?;
//! let mut state = robot.start([0.0, 0.0, 0.0]);
//!
//! // 0.13 N m exceeds the torque limit of Eq. 11: both wheels slip.
//! let torque = Command::Torque { right_nm: 0.13, left_nm: 0.13 };
//! let step_s = 1e-3;
//! for step in 0..500 {
//!     robot.step(&mut state, f64::from(step) * step_s, step_s, &torque);
//! }
//!
//! let [x, y, heading] = state.pose();
//! let [right, left, lateral] = robot.slip_m_s(&state);
//! println!("pose: {x:.3} m, {y:.3} m, {heading:.3} rad");
//! println!("slip: {right:.3} m/s right, {left:.3} m/s left, {lateral:.3} m/s lateral");
//! assert_eq!(state.slides(), [true, true]);
//! assert!(right < -0.5, "the wheel turns faster than the robot moves: {right}");
//! # Ok::<(), slipstream_bus::InputError>(())
//! ```
//!
//! # Derivatives
//!
//! Everything is generic over the [`Scalar`]: with dual numbers a step carries first derivatives
//! with respect to the parameters of effects, through events too. [`lift`] has an example.

mod contact;
mod dynamics;
pub mod effects;
mod integrate;
mod parts;
mod robot;
pub mod run;
mod sensors;
mod world;

pub use integrate::{Correction, State};
pub use parts::command::{Command, CommandKind};
pub use parts::parameters::{Friction, Streams};
pub use parts::scalar::{Pair, Scalar};
pub use robot::body::ContactForces;
pub use robot::{
    GRAVITY_M_S2, ListedEffect, Robot, breakaway_nm, lift, lift_entries, read_effects,
};
pub use sensors::{Sample, Stream};
pub use world::{Setup, Truth, World};
