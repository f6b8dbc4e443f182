//! `slipstream diagnose`: finds what a robot model lacks, from a recording.

mod table;
mod text;

use std::path::{Path, PathBuf};

use clap::Args;
use slipstream_answer::{Answer, Verdict, calibration};
use slipstream_bus::RobotModel;
use slipstream_diagnose::{Illustrated, InputError, Request, diagnose, diagnose_with_figures};
use slipstream_recording::{Recording, robot_toml};
use slipstream_report::diagnose::Diagnosis;

use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::output_file;
use crate::print::{self, print_line, prints};
use crate::reading::Reading;
use crate::{progress, provenance};

/// Find what a robot model lacks, from a recording
///
/// Prints one of three verdicts. Explained: effects of the catalogue that the model lacks, with
/// parameters, 95 % intervals, and when they act. Match: nothing was found that the model lacks. For both, the
/// error over 5 s is at most twice what noise explains. Unexplained: more is left, or something outside of the
/// catalogue acts.
///
/// Example: slipstream diagnose RECORDING --robot robot.toml --improved better.toml
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Recording: a folder of CSV files, or a bag (MCAP, SQLite or ROS 1; a file, or a folder as ROS 2 writes it);
    /// several are taken as runs of the same robots
    #[arg(required = true)]
    recording: Vec<PathBuf>,
    /// Recording of the same robot from before; may be repeated. What changed since is found, and not what
    /// the model leaves out
    #[arg(long, value_name = "OTHER", num_args = 1..)]
    against: Vec<PathBuf>,
    /// Robot model for all robots, or for the robot NAME: robot.toml, URDF or controller YAML; several of one robot fill
    /// what the others lack [default: the one in the recording]
    #[arg(long, value_name = "[NAME=]FILE")]
    robot: Vec<String>,
    #[command(flatten)]
    reading: Reading,
    /// Write the answer as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with the answer and its figures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the model with the effects that were found (several robots: one FILE.NAME.toml each)
    #[arg(long, value_name = "FILE.toml")]
    improved: Option<PathBuf>,
    /// Write the calibration as parameters of ros2_control's diff_drive_controller, with the transform of the
    /// pose sensor (several robots: one FILE.NAME.yaml each)
    #[arg(long, value_name = "FILE.yaml")]
    calibration: Option<PathBuf>,
    /// Ignore measurements between A and B seconds; may be repeated
    #[arg(long, value_name = "A:B", value_parser = time_span)]
    exclude_time: Vec<[f64; 2]>,
    /// End with exit code 0 for match, 3 for explained and 4 for unexplained
    #[arg(long)]
    exit_code: bool,
    /// Leave an effect out of the catalogue; may be repeated
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    for id in &arguments.without {
        if slipstream_sim::effects::find(id).is_none() {
            let place = format!("--without {id}");
            return Err(
                InputError::new(place, "is not an effect", "see slipstream effects").into(),
            );
        }
    }
    let models = Models::read(&arguments.robot)?;
    let read_all = |paths: &[PathBuf]| -> Result<Vec<Recording>, Error> {
        let read = |path: &PathBuf| Ok(arguments.reading.read(path, &models)?.recording);
        paths.iter().map(read).collect()
    };
    let recordings = read_all(&arguments.recording)?;
    let against = read_all(&arguments.against)?;
    let line = progress::line();
    let request = Request {
        recordings: &recordings,
        against: &against,
        model_of: &|robot| models.of(robot),
        excluded: &arguments.without,
        excluded_s: &arguments.exclude_time,
        progress: &|step| line.set_message(step.to_owned()),
    };
    let result = run_diagnosis(&request, arguments.report.is_some());
    line.finish_and_clear();
    let (answer, improved, figures) = result?;
    if let Some(file) = &arguments.json {
        output_file::write_json(file, &answer)?;
    }
    if let Some(file) = &arguments.report {
        let names: Vec<&str> = recordings.iter().map(|own| own.name.as_str()).collect();
        let origins: Vec<&str> = recordings.iter().map(|own| own.origin.as_str()).collect();
        let page = slipstream_report::diagnose::page(&Diagnosis {
            subject: names.join(", "),
            answer: &answer,
            figures: &figures,
            recordings: &recordings,
            model_of: &|robot| models.of(robot),
            improved: &improved,
            command_line: command_line(),
            facts: provenance::facts(&arguments.recording, &arguments.robot, &distinct(&origins)),
        });
        output_file::write(file, &page)?;
    }
    if let Some(file) = &arguments.improved {
        write_each(file, "toml", &improved, &|_, model| {
            robot_toml::to_text(model)
        })?;
    }
    if let Some(file) = &arguments.calibration {
        write_each(file, "yaml", &improved, &|name, model| {
            calibration(&answer, name, model, &recordings)
        })?;
    }
    print_answer(&answer);
    Ok(match answer.verdict {
        _ if !arguments.exit_code => Exit::Done,
        Verdict::Match => Exit::Done,
        Verdict::Explained => Exit::Explained,
        Verdict::Unexplained => Exit::Unexplained,
    })
}

/// Writes the text of each robot: one robot to `file`, several to files that end with NAME.`extension`.
fn write_each(
    file: &Path,
    extension: &str,
    improved: &[(String, RobotModel)],
    text: &dyn Fn(&str, &RobotModel) -> String,
) -> Result<(), Error> {
    for (name, model) in improved {
        let file = if improved.len() == 1 {
            file.to_owned()
        } else {
            file.with_extension(format!("{name}.{extension}"))
        };
        output_file::write(&file, &text(name, model))?;
    }
    Ok(())
}

/// Texts without repetition.
fn distinct(texts: &[&str]) -> String {
    let mut own: Vec<&str> = Vec::new();
    for text in texts.iter().filter(|text| !text.is_empty()) {
        if !own.contains(text) {
            own.push(text);
        }
    }
    own.join("; ")
}

/// Parses a time span `A:B` (s).
fn time_span(text: &str) -> Result<[f64; 2], String> {
    let ends = text
        .split_once(':')
        .and_then(|(a, b)| Some([a.parse().ok()?, b.parse().ok()?]));
    ends.filter(|[a, b]| a < b)
        .ok_or_else(|| "give two times in seconds, such as 12.5:14".to_owned())
}

/// Runs the diagnosis; computes figures only for a page.
fn run_diagnosis(request: &Request<'_>, with_figures: bool) -> Result<Illustrated, InputError> {
    if with_figures {
        return diagnose_with_figures(request);
    }
    let (answer, improved) = diagnose(request)?;
    Ok((answer, improved, Vec::new()))
}

fn print_answer(answer: &Answer) {
    let details = prints().details;
    print_line!("{}", print::bold(&format!("{}.", answer.statement)));
    for budget in &answer.budget {
        print_line!("{}.", text::budget(budget, answer.held_out.horizon_s));
    }
    for warning in &answer.warnings {
        print_line!("Warning: {}.", text::warning(warning));
    }
    let table = table::table(answer, details);
    if !table.is_empty() {
        print::out(format_args!("\n{table}"));
    }
    for difference in text::unstated(answer) {
        print_line!(
            "\nRobot {}, {}: {}",
            difference.robot,
            difference.channel,
            difference.shape
        );
    }
    let held_out = &answer.held_out;
    print_line!(
        "\nPrediction error over 5 s: {:.2} sensor standard deviations before, {:.2} after (noise alone: 1).",
        held_out.nrmse_before,
        held_out.nrmse_after
    );
    if details {
        print::out(format_args!("{}", text::details(answer)));
    }
}
