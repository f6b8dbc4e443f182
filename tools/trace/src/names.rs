//! Robots' names by their index.

use slipstream_bus::message::RobotIndex;

/// The robots' names by their index.
pub(crate) struct Names<'a>(pub(crate) &'a [String]);

impl Names<'_> {
    /// The name of a robot; `r1`, `r2`, … where the recording names none.
    pub(crate) fn of(&self, robot: RobotIndex) -> String {
        let name = self.0.get(robot as usize);
        name.cloned()
            .unwrap_or_else(|| format!("r{}", u64::from(robot) + 1))
    }
}
