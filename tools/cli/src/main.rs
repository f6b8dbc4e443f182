//! The command line `slipstream`: parses arguments, calls the packages, prints results, sets the exit code.

mod check;
mod clean;
mod command_line;
mod common_options;
mod compare;
mod completions;
mod diagnose;
mod effects;
mod estimate;
mod exit;
mod export;
mod host_options;
mod import;
mod interrupt;
mod join;
mod keys;
mod man;
mod models;
mod output_file;
mod print;
mod progress;
mod provenance;
mod reading;
mod real;
mod reproduce;
mod robot;
mod robot_in_a_box;
mod run;
mod shard_files;
mod study;
mod subject;
mod summary;
mod trace;
mod trial;
mod view;
mod viewers;
mod watch;
mod wrap;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use slipstream_launch::processes::roles;

use crate::common_options::CommonOptions;
use crate::exit::{Error, Exit};
use crate::print::eprint_line;

/// Simulate differential-drive robots in formation, measure latency, and find what a robot model lacks
///
/// Without a command, slipstream runs the built-in platoon of three robots and prints a summary.
#[derive(Debug, Parser)]
#[command(name = "slipstream", version = env!("SLIPSTREAM_VERSION"))]
struct Arguments {
    #[command(flatten)]
    common: CommonOptions,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Arguments),
    Join(join::Arguments),
    Keys(keys::Arguments),
    Check(check::Arguments),
    Compare(compare::Arguments),
    Import(import::Arguments),
    Export(export::Arguments),
    Diagnose(diagnose::Arguments),
    Effects(effects::Arguments),
    Robot(robot::Arguments),
    RobotInABox(robot_in_a_box::Arguments),
    Trace(trace::Arguments),
    Reproduce(reproduce::Arguments),
    Study(study::Arguments),
    Trial(trial::Arguments),
    View(view::Arguments),
    Watch(watch::Arguments),
    Completions(completions::Arguments),
    Man(man::Arguments),
    /// Remove the files that dead runs left in shared memory
    Clean,
}

fn main() -> ExitCode {
    run().unwrap_or_else(report).into()
}

fn report(error: Error) -> Exit {
    eprint_line!("slipstream: {error}");
    error.exit()
}

fn run() -> Result<Exit, Error> {
    interrupt::catch_file_size_limit()?;
    let arguments: Vec<OsString> = std::env::args_os().collect();
    if roles::is_role(&arguments) {
        let report_written = roles::play(&arguments, env!("SLIPSTREAM_VERSION"));
        return Ok(if report_written {
            Exit::Done
        } else {
            Exit::Failed
        });
    }
    let matches = Arguments::command().get_matches();
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    arguments.common.apply(&matches)?;
    let is_alone = arguments.command.is_none();
    let command = arguments
        .command
        .unwrap_or_else(|| Command::Run(run::Arguments::default()));
    if !command.finishes_after_a_signal() {
        interrupt::end_at_once()?;
    }
    match command {
        Command::Run(arguments) => run::run(&arguments, is_alone),
        Command::Join(arguments) => join::run(&arguments),
        Command::Keys(arguments) => keys::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Import(arguments) => import::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Diagnose(arguments) => diagnose::run(&arguments),
        Command::Effects(arguments) => effects::run(&arguments),
        Command::Robot(arguments) => robot::run(&arguments),
        Command::RobotInABox(arguments) => robot_in_a_box::run(&arguments),
        Command::Trace(arguments) => trace::run(&arguments),
        Command::Reproduce(arguments) => reproduce::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
        Command::Trial(arguments) => trial::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Watch(arguments) => watch::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments, &mut Arguments::command()),
        Command::Man(arguments) => man::run(&arguments, Arguments::command()),
        Command::Clean => clean::run(),
    }
}

impl Command {
    /// Whether the command catches signals itself: it has processes to stop or results to keep.
    fn finishes_after_a_signal(&self) -> bool {
        match self {
            Self::Run(arguments) => !arguments.in_process(),
            Self::Study(_) | Self::Trial(_) | Self::Join(_) | Self::RobotInABox(_) => true,
            _ => false,
        }
    }
}
