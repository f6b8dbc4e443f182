//! One robot's controller: odometry, outer and inner loop, torque limits, watchdog; and the node
//! that ties it to its links and its schedule. A core without I/O, clock or threads.

pub mod agent;
mod computed_torque;
mod friction;
mod geometry;
mod kanayama;
pub mod node;
mod odometry;
mod path;
mod pose;
#[cfg(feature = "process")]
pub mod process;
mod traction;
mod wheels;

pub use agent::Agent;
pub use computed_torque::{Wish, computed_torque};
pub use friction::FrictionEstimate;
pub use geometry::{Dynamics, Geometry};
pub use kanayama::{Desired, desired};
pub use node::{Node, NodeReport};
pub use odometry::Odometry;
pub use path::{Path, Reference};
pub use pose::Pose;
pub use traction::{normal_forces_n, torque_limit_nm};
pub use wheels::{WheelLoops, WheelTorque};
