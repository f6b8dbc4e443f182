//! Logs of drivetrains that WPILib's SysId wrote: JSON with some runs of one machine.

mod content;
mod reader;

pub(crate) use content::is_json;
pub(crate) use reader::read_sysid;
