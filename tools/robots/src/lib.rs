//! Real robots.
//!
//! In a run of real robots the process of this package ([`process`]) takes the place of the plant: to the agents it is
//! the plant, and to the robots it is a node that sends `cmd_vel` and hears joint states, odometry and poses. What it
//! does is a [`fleet`] without I/O, clock or threads: it cuts commands to the limits of `robots.toml` ([`lab`]), and
//! lets a robot stand that is not heard or whose agent is silent. [`boxed`] is our plant behind the same topics, for
//! tests and for teaching. Zenoh carries the [`topics`], in builds with the feature `zenoh`.

pub mod boxed;
pub mod fleet;
pub mod lab;
pub mod preflight;
pub mod process;
mod system_clock;
pub mod topics;
