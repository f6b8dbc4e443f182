//! `slipstream robot`: what the description of a robot says, as a robot.toml.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use slipstream_recording::describe_robot;
use slipstream_recording::robot_file::{Described, Kind, Missing, Source, Taken};

use crate::exit::{Error, Exit};
use crate::output_file;
use crate::print::{self, print_line};

/// Show what URDF, controller's YAML or robot.toml say about a robot, and write it as robot.toml
///
/// Prints each value with its unit and where it is from, what a human must fill in, and what was assumed. Several files are
/// about one robot: each fills what the others lack, and contradictions are said.
///
/// Example: slipstream robot husky.urdf control.yaml --out robot.toml
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// URDF, YAML or JSON with the parameters of a controller, source file with the constants of a drive, robot.toml, or a
    /// bag with a topic robot_description
    #[arg(required = true)]
    file: Vec<PathBuf>,
    /// Write a robot.toml, with a comment where something must be filled in
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Write the answer as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct RobotAnswer<'a> {
    format: u32,
    file: String,
    kind: Kind,
    sources: &'a [Source],
    /// Whether the file can be given to `--robot`.
    complete: bool,
    taken: &'a [Taken],
    left_out: &'a [Taken],
    missing: &'a [Missing],
    notes: &'a [String],
    /// Right and left.
    wheel_joints: &'a [Vec<String>; 2],
    robot_toml: String,
}

/// What is said of poses where the centre of mass is known.
const POSES: &str = "\nPoses in a folder with recording.toml are those of the centre of mass, unless it says pose_point = \"axle\"; poses \
    in bags and in other CSV files are those of the axle's middle.\n";

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let files: Vec<&Path> = arguments.file.iter().map(PathBuf::as_path).collect();
    let described = describe_robot(&files)?;
    print::out(format_args!("{}", text(&described)));
    if let Some(path) = &arguments.json {
        let answer = RobotAnswer {
            format: 1,
            file: files
                .first()
                .map_or_else(String::new, |own| own.display().to_string()),
            kind: described.kind,
            sources: &described.sources,
            complete: described.missing.is_empty(),
            taken: &described.taken,
            left_out: &described.left_out,
            missing: &described.missing,
            notes: &described.notes,
            wheel_joints: &described.wheel_joints,
            robot_toml: described.to_robot_toml(),
        };
        output_file::write_json(path, &answer)?;
    }
    if let Some(path) = &arguments.out {
        output_file::write(path, &described.to_robot_toml())?;
        print_line!("{}", path.display());
    }
    Ok(Exit::Done)
}

/// The table of values, and below it what is missing, left out and assumed.
fn text(described: &Described) -> String {
    let titles: Vec<&str> = described.sources.iter().map(|own| &*own.title).collect();
    let mut text = format!("{}\n", titles.join(" and "));
    text.push_str(&table(&described.taken));
    for (side, names) in ["right", "left"].iter().zip(&described.wheel_joints) {
        if !names.is_empty() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "Wheel joints, {side}: {}", names.join(", "));
        }
    }
    let missing = described.missing.iter();
    let missing = missing.map(|own| format!("{}: {}; {}", own.key, own.problem, own.remedy));
    section(&mut text, "To fill in:", missing);
    if !described.left_out.is_empty() {
        text.push_str("\nKnown, and left out of the model:\n");
        text.push_str(&table(&described.left_out));
    }
    section(&mut text, "Notes:", described.notes.iter().cloned());
    if described
        .model()
        .is_ok_and(|model| model.robot.com_to_axle_m.is_some())
    {
        text.push_str(POSES);
    }
    text
}

/// Key, value, unit and source of each value.
fn table(values: &[Taken]) -> String {
    let cells = |own: &Taken| [own.key.clone(), short(own.value), own.unit.clone()];
    let rows: Vec<[String; 3]> = values.iter().map(cells).collect();
    let width = |column: usize| {
        let widths = rows.iter().map(|row| row[column].chars().count());
        widths.max().unwrap_or(0)
    };
    let [key, value, unit] = [width(0), width(1), width(2)];
    let lines = rows.iter().zip(values);
    lines
        .map(|(row, own)| {
            let [a, b, c] = row;
            format!("{a:key$}  {b:>value$} {c:unit$}  {}\n", own.from)
        })
        .collect()
}

/// A number with nine digits after the point, without zeros at its end.
fn short(value: f64) -> String {
    let text = format!("{value:.9}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A heading and a list, if the list has any.
fn section(text: &mut String, heading: &str, lines: impl Iterator<Item = String>) {
    for (place, line) in lines.enumerate() {
        if place == 0 {
            let _ = writeln!(text, "\n{heading}");
        }
        let _ = writeln!(text, "- {line}");
    }
}
