//! Experiments as plain data: settings, built-in experiments, validation.

mod builtin;
mod change_table;
mod changes;
mod hears;
mod parameters;
mod profile;
mod settings;
mod setup;
mod topology;
mod validate;

pub use change_table::ChangeTable;
pub use changes::{Begins, Change};
pub use hears::Hears;
pub use parameters::{EVERY_ROBOT, ParameterValue, Parameters, program_of};
pub use profile::Profile;
pub use settings::{
    Clock, Control, Distribution, Drive, Feedforward, Formation, Law, LinkSettings, OnDeath,
    OpenLoop, Plant, Protocol, RecordingRates, Robots, SensorSettings, Settings, TorqueLimit,
};
pub use setup::{Experiment, RobotSetup, WheelSource};
pub use topology::Topology;
