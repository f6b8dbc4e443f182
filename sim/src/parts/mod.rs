//! Numbers, commands and components, before there is a robot.

pub(crate) mod actuator;
pub(crate) mod command;
pub(crate) mod friction_elements;
pub(crate) mod parameters;
pub(crate) mod pose;
pub(crate) mod scalar;
pub(crate) mod tolerances;
