//! `slipstream reproduce`: the paper's experiments, compared with its printed numbers.

use std::path::PathBuf;

use clap::Args;
use slipstream_study::reproduce::{self, Explanation, PaperRow};

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
    print_explanation(&reproduction.comparison.explanation);
    print_line!("{:<79} {:>9} {:>9}  agrees", "", "paper", "computed");
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
    print_line!(
        "{yes} of {all} numbers and claims agree as assumed; --report gives the reasons for the others"
    );
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

/// The answer first: causes, with what else it could be, what remains, and how well they predict.
fn print_explanation(explanation: &Explanation) {
    let cm = |m: f64| 100.0 * m;
    print_line!("{}\n", explanation.sentence);
    for (number, cause) in (1..).zip(&explanation.causes) {
        print_line!(
            "{number}. {} (without it {:.1} cm are left, with it {:.1})",
            cause.sentence,
            cm(cause.without_it_m),
            cm(explanation.after_m)
        );
        if let Some(rival) = cause.rivals.first() {
            let more = match cause.rivals.len() {
                1 => String::new(),
                count => format!(", or {} more", count - 1),
            };
            print_line!("   or: {rival}{more}");
        }
    }
    if !explanation.remains.is_empty() {
        print_line!("\nwhat remains: {}", explanation.remains);
    }
    print_line!("\nleft out, and predicted by what the others show:");
    for own in &explanation.held_out {
        print_line!(
            "  {:<18} {:5.1} cm off as assumed, {:5.1} cm predicted",
            own.words(),
            cm(own.before_m),
            cm(own.after_m)
        );
    }
    print_line!("");
}

fn format_row(row: &PaperRow) -> String {
    let number = |value: Option<f64>| value.map_or("—".to_owned(), |value| format!("{value:.4}"));
    let agrees = row
        .agrees
        .map_or("", |agrees| if agrees { "yes" } else { "no" });
    let (paper, computed) = (number(row.paper), number(row.computed));
    format!("{:<79} {paper:>9} {computed:>9}  {agrees}", row.name)
}
