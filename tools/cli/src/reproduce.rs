//! `slipstream reproduce`: the paper's experiments, compared with its printed numbers.

use std::path::PathBuf;

use clap::Args;
use slipstream_study::reproduce::{self, Row};

use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::output_file::{write, write_json};
use crate::print::print_line;

/// Run the paper's experiments and compare every number that it prints with the computed one
///
/// Example: slipstream reproduce --report reproduce.html
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Write the table as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with the table and the paper's figures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let reproduction = reproduce::reproduce()?;
    if let Some(path) = &arguments.json {
        write_json(path, &reproduction.comparison)?;
    }
    if let Some(path) = &arguments.report {
        write(
            path,
            &slipstream_report::reproduce::page(&reproduction, &command_line()),
        )?;
    }
    print_line!(
        "{:<62} {:>9} {:>9}  agrees",
        "quantity",
        "paper",
        "computed"
    );
    for row in &reproduction.comparison.rows {
        print_line!("{}", format_row(row));
    }
    let agreements = reproduction
        .comparison
        .rows
        .iter()
        .filter_map(|row| row.agrees);
    let (yes, all) = agreements.fold((0, 0), |(yes, all), agrees| {
        (yes + u32::from(agrees), all + 1)
    });
    print_line!("{yes} of {all} agree; --json and --report give the reasons for the others");
    print_line!(
        "\nbeyond the paper      law             limit      slip (s)  spacing error (m)  odometry error (m)"
    );
    for beyond in &reproduction.comparison.extensions {
        print_line!(
            "{:<21} {:<15} {:<10} {:>8.3} {:>18.3} {:>19.3}",
            beyond.experiment,
            beyond.law,
            beyond.torque_limit,
            beyond.slip_time_s,
            beyond.max_spacing_error_m,
            beyond.mean_final_gap_m
        );
    }
    Ok(Exit::Done)
}

fn format_row(row: &Row) -> String {
    let number = |value: Option<f64>| value.map_or("—".to_owned(), |value| format!("{value:.4}"));
    let agrees = row
        .agrees
        .map_or("", |agrees| if agrees { "yes" } else { "no" });
    let (paper, computed) = (number(row.paper), number(row.computed));
    format!("{:<62} {paper:>9} {computed:>9}  {agrees}", row.quantity)
}
