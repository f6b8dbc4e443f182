//! `slipstream man`: manual pages.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use crate::exit::{Error, Exit};
use crate::print::print_line;

/// Print the manual page, or write the pages of all commands
///
/// Example: slipstream man --folder ~/.local/share/man/man1
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder for slipstream.1, slipstream-run.1, and so on
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments, command: Command) -> Result<Exit, Error> {
    let Some(folder) = &arguments.folder else {
        print_line!("{}", page(command)?.trim_end());
        return Ok(Exit::Done);
    };
    let written =
        std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(command, folder));
    written.map_err(|error| {
        Error::UnusableOutput(format!("--folder {}: {error}", folder.display()))
    })?;
    print_line!("{}", folder.display());
    Ok(Exit::Done)
}

/// One page in the language of `man`.
fn page(command: Command) -> Result<String, Error> {
    let mut text = Vec::new();
    let rendered = Man::new(command).render(&mut text);
    rendered.map_err(|error| Error::Failed(format!("manual page: {error}")))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}
