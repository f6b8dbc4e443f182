//! Scalars, commands, parameters and components, independent of any robot.

pub(crate) mod actuator;
pub(crate) mod command;
pub(crate) mod command_history;
pub(crate) mod friction_constraints;
pub(crate) mod parameters;
pub(crate) mod pose;
pub(crate) mod scalar;
pub(crate) mod table;
pub(crate) mod tolerances;
