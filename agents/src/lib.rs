//! Agent of one robot (Konduri, Torres, Pagilla): odometry, outer loop, inner loop, torque limits, watchdog, and the
//! node that adds the robot's links.
//!
//! [`Controller`] is a control law, the paper's ([`Paper`]) or your own; [`Agent`] is what surrounds it, [`Node`] the agent
//! with its links. All are pure: they have no I/O, clock or threads, and the same inputs give the same outputs, bit for bit.
//! The feature `process` adds the process that runs a node over shared memory; `process::run_agent` is the whole `main` of
//! a program with a controller of its own.
//!
//! | module | method |
//! | --- | --- |
//! | `odometry` | dead reckoning from encoder counts (Eq. 1) |
//! | `predecessor_path` | reference q_{i−1} − δ_i along the predecessor's path (section 4) |
//! | `kanayama` | outer loop: tracking controller of Kanayama et al. (1990), Eq. 12 |
//! | `speed_loop` | inner loop: PI speed controllers with anti-windup (section 3) |
//! | `computed_torque` | inner loop: inverse dynamics with friction-limited forces |
//! | `traction` | normal forces and torque limit against slip (Eq. 4 to 6, Eq. 11) |
//! | `friction_estimator` | online friction estimation (Kalman filter) |
//!
//! # Example
//!
//! A node needs encoders, a [`PositionLink`](slipstream_bus::transport::PositionLink) and a
//! recorder. Here one robot drives for two seconds; in place of a plant, its wheels follow the
//! set-points of the outer loop without error.
//!
//! ```
//! use slipstream_agents::Node;
//! use slipstream_bus::message::{Actuation, Encoders, Position};
//! use slipstream_bus::record::Record;
//! use slipstream_bus::transport::{BusError, PositionLink};
//! use slipstream_bus::{Experiment, RobotModel, Settings};
//!
//! /// A robot without neighbours.
//! struct NoLink;
//!
//! impl PositionLink for NoLink {
//!     fn poll(&mut self) -> Result<Option<Position>, BusError> {
//!         Ok(None)
//!     }
//!     fn send(&mut self, position: &mut Position) -> Result<i64, BusError> {
//!         Ok(position.tick_ns)
//!     }
//!     fn now_ns(&self) -> i64 {
//!         0
//!     }
//! }
//!
//! let mut settings = Settings::default();
//! settings.robots.count = 1;
//! let experiment = Experiment::new(settings, &RobotModel::default());
//! let schedule = experiment.settings.schedule();
//! let counts_per_rad = 1856.0 / std::f64::consts::TAU;
//!
//! let mut node = Node::new(&experiment, 0)?;
//! let mut records = Vec::new();
//! let (mut now_ns, mut angle, mut speed) = (0, [0.0; 2], [0.0; 2]);
//! while now_ns < 2_000_000_000 {
//!     let counts = angle.map(|angle: f64| (angle * counts_per_rad) as i64);
//!     let encoders = Encoders { sampled_ns: now_ns, counts };
//!     let due = schedule.due(now_ns);
//!     let command = node.step(now_ns, due, &encoders, &mut NoLink, &mut records)?;
//!     let Actuation::Torque(torque_nm) = command.actuation else { unreachable!() };
//!     assert!(torque_nm.iter().all(|torque| torque.abs() <= 0.13));
//!     for record in records.drain(..) {
//!         if let Record::Outer(tick) = record {
//!             speed = tick.set_point_rad_s;
//!         }
//!     }
//!     let next_ns = schedule.next_after(now_ns);
//!     for wheel in 0..2 {
//!         angle[wheel] += speed[wheel] * (next_ns - now_ns) as f64 / 1e9;
//!     }
//!     now_ns = next_ns;
//! }
//! let report = node.finish(None, &mut NoLink, &mut records)?;
//! // The robot started at x = 0.6096 m. The profile reaches 0.2 m/s after 0.5 s: 0.35 m in 2 s.
//! let driven_m = report.final_odometry[0] - 0.6096;
//! assert!((driven_m - 0.35).abs() < 0.02, "{driven_m}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod agent;
mod computed_torque;
mod controller;
mod friction_estimator;
mod geometry;
mod kanayama;
mod laws;
pub mod node;
mod odometry;
mod pose;
mod predecessor_path;
#[cfg(feature = "process")]
pub mod process;
mod speed_loop;
mod traction;
mod wheel_torques;

pub use agent::Agent;
pub use computed_torque::{AccelerationCommand, computed_torque};
pub use controller::{
    AgentContext, Controller, ControllerError, DesiredTwist, Heard, InnerInput, OuterInput,
};
pub use friction_estimator::FrictionEstimator;
pub use geometry::{Dynamics, Geometry};
pub use kanayama::{desired_twist, tracking_error};
pub use laws::{BuiltIn, ComputedTorque, Paper};
pub use node::{Node, NodeReport};
pub use odometry::Odometry;
pub use pose::Pose;
pub use predecessor_path::{PathPoint, PredecessorPath};
pub use speed_loop::SpeedLoops;
pub use traction::{normal_forces_n, torque_limit_nm};
pub use wheel_torques::WheelTorques;
