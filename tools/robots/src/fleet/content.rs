//! What a robot's topics tell.

/// What a topic tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// What the wheels do.
    Wheels,
    /// Where the robot is.
    Pose,
}
