//! Experiments as plain data: every key that a run obeys, with its unit and default.

mod builtin;
mod settings;

pub use settings::{
    Clock, Control, Distribution, Experiment, Feedforward, Formation, Law, LinkSettings, OnDeath,
    OpenLoop, Plant, Profile, Protocol, RecordingRates, RobotSetup, Robots, SensorSettings,
    Settings, TorqueLimit,
};
