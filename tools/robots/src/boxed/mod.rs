//! A robot in a box: our plant of one robot behind the topics of a real one.
//!
//! It takes twists as a base controller does: it follows the newest one, and stands when none has come for a while. It
//! sends the angles of its wheels, or odometry, and its pose as a motion capture system would. What its model's effects do
//! is concealed behind these topics, as on a real robot.

mod process;
mod robot;

pub use self::process::{BoxError, BoxOptions, BoxReport, run, run_over};
pub use self::robot::BoxedRobot;
