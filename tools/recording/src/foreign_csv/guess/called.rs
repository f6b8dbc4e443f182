//! Words in names of messages and files that tell what they are.

/// Words of commands.
pub(super) const COMMANDS: [&str; 9] = [
    "cmd",
    "command",
    "commanded",
    "ref",
    "reference",
    "des",
    "desired",
    "target",
    "setpoint",
];
/// Words of poses that a sensor outside of the robot measured.
pub(super) const REFERENCES: [&str; 7] = [
    "truth",
    "groundtruth",
    "gt",
    "vicon",
    "optitrack",
    "mocap",
    "qualisys",
];
