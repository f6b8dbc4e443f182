//! Options that every command has: how much is printed, and whether files may be replaced.

use std::io::{IsTerminal as _, Read as _, stdout};
use std::path::{Path, PathBuf};

use clap::{ArgMatches, Args};
use slipstream_bus::InputError;

use crate::exit::Error;
use crate::print::{self, Prints};

/// Options of every command.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct CommonOptions {
    /// Print errors alone, no results and no notes
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print details
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Print bold and coloured text: auto does so on a terminal, unless NO_COLOR is set
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    color: Color,
    /// Show no progress
    #[arg(long, global = true)]
    no_progress: bool,
    /// Replace files that exist. Without it, only an earlier answer or page of slipstream is replaced, which the same
    /// command writes again
    #[arg(long, global = true)]
    force: bool,
}

/// When results are bold and coloured.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
enum Color {
    #[default]
    Auto,
    Always,
    Never,
}

impl Color {
    fn is_on(self) -> bool {
        match self {
            Self::Auto => {
                let is_unwanted =
                    |name: &str| std::env::var_os(name).is_some_and(|own| !own.is_empty());
                stdout().is_terminal() && !is_unwanted("NO_COLOR")
            }
            Self::Always => true,
            Self::Never => false,
        }
    }
}

/// Arguments that name a file to write.
const OUTPUTS: [&str; 10] = [
    "json",
    "report",
    "improved",
    "calibration",
    "out",
    "layout",
    "perfetto",
    "rtt",
    "write_topics",
    "write_columns",
];

impl CommonOptions {
    /// Makes them hold for this process. `matches` are those of the command.
    ///
    /// # Errors
    /// If a file to write exists, and may not be replaced.
    pub(crate) fn apply(&self, matches: &ArgMatches) -> Result<(), Error> {
        let command = innermost(matches);
        let json_on_terminal = output(command, "json").is_some_and(|file| file == Path::new("-"));
        print::set(Prints {
            results: !self.quiet && !json_on_terminal,
            notes: !self.quiet,
            details: self.verbose,
            progress: !self.quiet && !self.no_progress,
            colour: self.color.is_on(),
        });
        if self.force {
            return Ok(());
        }
        for id in OUTPUTS {
            if let Some(file) =
                output(command, id).filter(|file| is_taken(file) && !is_own_answer(file))
            {
                let place = format!("--{} {}", id.replace('_', "-"), file.display());
                let remedy = "give another name, or --force to replace it";
                return Err(InputError::new(place, "exists", remedy).into());
            }
        }
        Ok(())
    }
}

/// The matches of the command or of its subcommand.
fn innermost(matches: &ArgMatches) -> &ArgMatches {
    match matches.subcommand() {
        Some((_, inner)) => innermost(inner),
        None => matches,
    }
}

/// The file that an argument names, if the command has such an argument and it was given.
fn output<'a>(matches: &'a ArgMatches, id: &str) -> Option<&'a PathBuf> {
    let given = matches.try_contains_id(id).is_ok_and(|given| given);
    let source = if given {
        matches.value_source(id)
    } else {
        None
    };
    if source != Some(clap::parser::ValueSource::CommandLine) {
        return None;
    }
    matches.try_get_one(id).ok().flatten()
}

/// Whether a file has content that would be lost. Devices, pipes and empty files have none.
fn is_taken(file: &Path) -> bool {
    std::fs::metadata(file).is_ok_and(|metadata| metadata.is_file() && metadata.len() > 0)
}

/// Whether a file is an answer or a page that slipstream wrote, by its first bytes.
fn is_own_answer(file: &Path) -> bool {
    let mut head = Vec::new();
    let read = std::fs::File::open(file).and_then(|own| own.take(300).read_to_end(&mut head));
    let head = String::from_utf8_lossy(&head);
    let is_answer = head.starts_with("{\n  \"format\": 1,");
    read.is_ok() && (is_answer || head.contains("<meta name=\"generator\" content=\"slipstream"))
}

/// A name like `default` that no file has yet: `run.mcap`, `run-2.mcap`, and so on.
pub(crate) fn vacant(default: &Path) -> PathBuf {
    let stem = default.file_stem().unwrap_or_default().to_string_lossy();
    let extension = default.extension().unwrap_or_default().to_string_lossy();
    let numbered = |number: u32| default.with_file_name(format!("{stem}-{number}.{extension}"));
    let mut names = std::iter::once(default.to_owned()).chain((2..).map(numbered));
    names
        .find(|name| !is_taken(name))
        .unwrap_or_else(|| default.to_owned())
}
