//! The command line `slipstream`: parses arguments, calls the packages, prints results, sets the exit code.

mod check;
mod clean;
mod command_line;
mod compare;
mod completions;
mod diagnose;
mod effects;
mod exit;
mod export;
mod import;
mod models;
mod output_file;
mod print;
mod progress;
mod reproduce;
mod run;
mod study;
mod summary;
mod trace;
mod trial;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::exit::Exit;
use crate::print::eprint_line;

/// Simulate differential-drive robots in formation, measure latency, and find what a robot model lacks
///
/// Without a command, slipstream runs the built-in platoon of three robots and prints a summary.
#[derive(Debug, Parser)]
#[command(name = "slipstream", version = env!("SLIPSTREAM_VERSION"))]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Arguments),
    Check(check::Arguments),
    Compare(compare::Arguments),
    Import(import::Arguments),
    Export(export::Arguments),
    Diagnose(diagnose::Arguments),
    Effects(effects::Arguments),
    Trace(trace::Arguments),
    Reproduce(reproduce::Arguments),
    Study(study::Arguments),
    Trial(trial::Arguments),
    Completions(completions::Arguments),
    /// Remove the files that dead runs left in shared memory
    Clean,
}

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    if slipstream_launch::processes::roles::is_role(&arguments) {
        let report_written = slipstream_launch::processes::roles::play(&arguments);
        return if report_written {
            Exit::Done.into()
        } else {
            Exit::Failed.into()
        };
    }
    let result = match Arguments::parse().command {
        None => run::run(&run::Arguments::default()),
        Some(Command::Run(arguments)) => run::run(&arguments),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::Compare(arguments)) => compare::run(&arguments),
        Some(Command::Import(arguments)) => import::run(&arguments),
        Some(Command::Export(arguments)) => export::run(&arguments),
        Some(Command::Diagnose(arguments)) => diagnose::run(&arguments),
        Some(Command::Effects(arguments)) => effects::run(&arguments),
        Some(Command::Trace(arguments)) => trace::run(&arguments),
        Some(Command::Reproduce(arguments)) => reproduce::run(&arguments),
        Some(Command::Study(arguments)) => study::run(&arguments),
        Some(Command::Trial(arguments)) => trial::run(&arguments),
        Some(Command::Completions(arguments)) => {
            completions::run(&arguments, &mut Arguments::command())
        }
        Some(Command::Clean) => clean::run(),
    };
    result
        .unwrap_or_else(|error| {
            eprint_line!("slipstream: {error}");
            error.exit()
        })
        .into()
}
