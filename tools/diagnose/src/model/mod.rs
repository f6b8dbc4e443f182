//! Models under test: what their parameters are, where they start, and what is known of them before.

pub(crate) mod command_to_wheels;
pub(crate) mod comparison;
mod crude;
pub(crate) mod drive;
pub(crate) mod from_wheels;
pub(crate) mod hypothesis;
pub(crate) mod nominal;
pub(crate) mod plant;
pub(crate) mod run;
pub(crate) mod streams;
pub(crate) mod table;
pub(crate) mod view;
pub(crate) mod volts;
pub(crate) mod wheel_parameters;
