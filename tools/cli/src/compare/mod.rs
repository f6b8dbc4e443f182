//! `slipstream compare`: a recording beside its simulation, or two recordings of one experiment beside each other.

mod arguments;
mod recorded;
mod simulated;
mod table;

pub(crate) use arguments::Arguments;

use crate::exit::{Error, Exit};

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    match &arguments.simulated {
        Some(simulated) => recorded::run(arguments, simulated),
        None => simulated::run(arguments),
    }
}
