//! `slipstream man`: manual pages.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use crate::exit::{Error, Exit};
use crate::output_file;
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
    std::fs::create_dir_all(folder).map_err(|error| {
        Error::UnusableOutput(format!("--folder {}: {error}", folder.display()))
    })?;
    let mut pages = vec![command.clone()];
    for own in command.get_subcommands() {
        let name = format!("slipstream-{}", own.get_name());
        pages.push(own.clone().name(name.clone()).display_name(name));
    }
    for own in pages {
        let file = folder.join(format!("{}.1", own.get_name()));
        output_file::write(&file, &page(own)?)?;
    }
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
