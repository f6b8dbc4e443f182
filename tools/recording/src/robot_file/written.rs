//! A description as the text of a robot.toml.

use super::described::{Described, Kind, Source};
use super::words::one_line;
use crate::toml_files::robot_toml;

impl Described {
    /// The text of a robot.toml with where each value is from. What is missing stands in a comment, to be
    /// filled in. If nothing is missing, parsing it gives [`Described::model`] bit for bit.
    pub fn to_robot_toml(&self) -> String {
        let plain = robot_toml::to_text(&self.draft);
        if self.kind == Kind::RobotToml {
            return plain;
        }
        let mut text = head(self);
        let mut table = "";
        for line in plain.lines() {
            if line.starts_with('[') {
                if table == "[robot]" {
                    text.push_str(&left_out(self));
                }
                table = line;
            }
            let commented = if table == "[robot]" {
                of_robot(self, line)
            } else {
                line.to_owned()
            };
            text.push_str(&commented);
            text.push('\n');
        }
        if table == "[robot]" {
            text.push_str(&left_out(self));
        }
        if self.draft.encoder.is_none() {
            text.push_str(ENCODER);
        }
        text
    }
}

/// What no description but a robot.toml has.
const ENCODER: &str = "# Runs need the encoders, and so do recordings of ticks:\n# [encoder]\n# counts_per_rev =   # per turn of a wheel\n";

/// Where the text is from, and what was assumed.
fn head(described: &Described) -> String {
    let source = |own: &Source| {
        let name = own.file.file_name().unwrap_or_default().to_string_lossy();
        format!("{} ({})", one_line(&name), one_line(&own.title))
    };
    let sources: Vec<String> = described.sources.iter().map(source).collect();
    let mut text = format!(
        "# Written by `slipstream robot` from {}.\n",
        sources.join(" and ")
    );
    for note in &described.notes {
        text.push_str(&format!("# - {note}\n"));
    }
    text
}

/// A line of the table `[robot]`, with where its value is from or what is to be done about it.
fn of_robot(described: &Described, line: &str) -> String {
    let Some((key, _)) = line.split_once(" = ") else {
        return line.to_owned();
    };
    if let Some(missing) = described.missing.iter().find(|missing| missing.key == key) {
        return format!(
            "# {key} =   # to fill in: {}; {}",
            missing.problem, missing.remedy
        );
    }
    match described.taken.iter().find(|taken| taken.key == key) {
        Some(taken) => format!("{line}  # {}", taken.from),
        None => line.to_owned(),
    }
}

/// The values that the model leaves out, as comments.
fn left_out(described: &Described) -> String {
    let lines = described.left_out.iter();
    lines
        .map(|own| {
            format!(
                "# {} = {}  # left out; {}\n",
                own.key,
                robot_toml::number(own.value),
                own.from
            )
        })
        .collect()
}
