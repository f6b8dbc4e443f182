//! `slipstream diagnose`: what the model leaves out, where, how much, how sure.

mod page;
mod points;
mod words;

use std::io::{IsTerminal, Write as _};
use std::path::PathBuf;

use clap::Args;
use slipstream_diagnose::{Answer, Illustrated, Unusable, diagnose, diagnose_with_figures};
use slipstream_recording::{Recording, robot_toml};

use crate::exit::{Error, Exit};
use crate::file;
use crate::models::Models;

/// Find what a robot's model leaves out, from a recording
///
/// A first form: it looks for effects that always act, on robots with recorded commands, one
/// recording at a time, and takes minutes. Patches, pushes, links and what the catalogue does not
/// hold are not looked for yet.
///
/// Example: slipstream diagnose RECORDING --robot robot.toml --improved better.toml
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder with recording.toml, or an MCAP file.
    recording: PathBuf,
    /// A robot's model, for all or for the robot NAME; without it the one in the recording.
    #[arg(long, value_name = "[NAME=]FILE.toml")]
    robot: Vec<String>,
    /// Write the answer to a file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page that shows the answer in figures.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the model with the found effects added (several robots: FILE.NAME.toml each).
    #[arg(long, value_name = "FILE.toml")]
    improved: Option<PathBuf>,
    /// Take an effect out of the catalogue.
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    for id in &arguments.without {
        if slipstream_sim::effects::find(id).is_none() {
            return Err(Error::Input(format!(
                "--without {id}: is no effect; `slipstream effects` lists those that are"
            )));
        }
    }
    let import = slipstream_recording::read(&arguments.recording)?;
    for warning in &import.warnings {
        eprintln!("{warning}");
    }
    let models = Models::read(&arguments.robot)?;
    let live = std::io::stderr().is_terminal();
    let began = std::time::Instant::now();
    let progress = |what: &str| {
        if std::env::var_os("DEBUG_D").is_some() { eprintln!("{:.1} {what}", began.elapsed().as_secs_f64()); }
        if live {
            // a progress line that cannot be shown is not worth an error
            let _ = write!(std::io::stderr(), "\r\x1b[K{what}");
        }
    };
    let done = examine(arguments, &import.recording, &models, &progress);
    if live {
        eprint!("\r\x1b[K");
    }
    let (answer, improved, figures) =
        done.map_err(|why| Error::Input(format!("{}: {why}", arguments.recording.display())))?;
    if let Some(file) = &arguments.json {
        file::write_json(file, &answer)?;
    }
    if let Some(file) = &arguments.report {
        let page = page::page(&import.recording.name, &answer, &figures);
        let page = page.map_err(|e| Error::Failed(format!("{}: {e}", file.display())))?;
        file::write(file, &page)?;
    }
    if let Some(file) = &arguments.improved {
        for (name, model) in &improved {
            let file = if improved.len() == 1 {
                file.clone()
            } else {
                file.with_extension(format!("{name}.toml"))
            };
            file::write(&file, &robot_toml::to_text(model))?;
        }
    }
    say(&answer);
    Ok(Exit::Done)
}

/// The diagnosis, with figures where a page is wanted.
fn examine(
    arguments: &Arguments,
    recording: &Recording,
    models: &Models,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Illustrated, Unusable> {
    let (model_of, excluded) = (|robot: &str| models.of(robot), &arguments.without);
    if arguments.report.is_some() {
        return diagnose_with_figures(recording, model_of, excluded, progress);
    }
    let (answer, improved) = diagnose(recording, model_of, excluded, progress)?;
    Ok((answer, improved, Vec::new()))
}

fn say(answer: &Answer) {
    let held = &answer.held_out;
    println!("{}.", words::verdict(answer.verdict));
    for finding in &answer.findings {
        println!("\n{}", finding.statement);
        for parameter in &finding.parameters {
            if let (Some(estimate), Some([low, high])) = (parameter.estimate, parameter.ci95) {
                let (name, unit) = (&parameter.name, &parameter.unit);
                println!("  {name} {estimate:.5} {unit}  (95 % between {low:.5} and {high:.5})");
            }
        }
        if !finding.confused_with.is_empty() {
            println!(
                "  cannot be told from {} here",
                finding.confused_with.join(", ")
            );
        }
    }
    for left in &answer.unexplained {
        println!("\nRobot {}, {}: {}", left.robot, left.channel, left.shape);
    }
    println!(
        "\nPrediction error over 5 s: {:.2} standard deviations before, {:.2} after.",
        held.nrmse_before, held.nrmse_after
    );
}
