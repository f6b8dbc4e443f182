//! How well a model predicts over 5 s: the state at the start of a window is fitted to its first half
//! second, then the plant is simulated open loop from what drove the robot.

pub(crate) mod drawn;
mod facing;
#[cfg(test)]
pub(crate) mod fixture;
pub(crate) mod prediction;
pub(crate) mod predictor;
pub(crate) mod simulation;
pub(crate) mod start;
pub(crate) mod sum_of_squares;
pub(crate) mod window;
