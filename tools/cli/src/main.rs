//! `slipstream`: arguments in, words and exit codes out.

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
enum Command {}

fn main() -> ExitCode {
    match Arguments::parse().command {}
}
