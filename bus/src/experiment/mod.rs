//! Experiments as plain data: settings, built-in experiments, validation.

mod builtin;
mod profile;
mod settings;
mod setup;
mod validate;

pub use profile::Profile;
pub use settings::{
    Clock, Control, Distribution, Feedforward, Formation, Law, LinkSettings, OnDeath, OpenLoop,
    Plant, Protocol, RecordingRates, Robots, SensorSettings, Settings, TorqueLimit,
};
pub use setup::{Experiment, RobotSetup};
