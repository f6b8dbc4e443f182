//! `slipstream completions`: completion scripts for shells.

use clap::{Args, Command};
use clap_complete::Shell;

use crate::exit::{Error, Exit};
use crate::print::print_line;

/// Print the completion script for a shell
///
/// Example: slipstream completions bash >> ~/.bashrc
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Shell that will read the script
    shell: Shell,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments, command: &mut Command) -> Result<Exit, Error> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, command, "slipstream", &mut script);
    print_line!("{}", String::from_utf8_lossy(&script).trim_end());
    Ok(Exit::Done)
}
