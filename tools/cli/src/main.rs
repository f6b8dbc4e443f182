//! `slipstream`: arguments in, words and exit codes out.

mod check;
mod compare;
mod export;
mod failure;
mod import;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Robots in formation on real floors: run them, measure them, find the physics a model leaves out.
#[derive(Debug, Parser)]
#[command(name = "slipstream", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Check(check::Arguments),
    Compare(compare::Arguments),
    Import(import::Arguments),
    Export(export::Arguments),
}

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Check(arguments) => check::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Import(arguments) => import::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
    };
    failure::exit_code(done)
}
