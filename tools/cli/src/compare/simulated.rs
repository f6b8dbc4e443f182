//! `slipstream compare RECORDING`: simulates the recorded commands and plots the result over the recording.

use std::path::Path;

use slipstream_bus::InputError;
use slipstream_recording::CompareError;
use slipstream_report::compare::Comparison;

use super::arguments::Arguments;
use crate::command_line::command_line;
use crate::common_options::vacant;
use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::print::print_line;
use crate::provenance;

/// Compares the recording with its simulation.
pub(super) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let models = Models::read(&arguments.robot)?;
    let import = arguments.reading.read(&arguments.recording, &models)?;
    let channels = slipstream_recording::compare(&import.recording, |robot| models.of(robot))
        .map_err(|error| located(&arguments.recording, error))?;
    let page = slipstream_report::compare::page(&Comparison {
        recording: &import.recording,
        channels: &channels,
        command_line: command_line(),
        facts: provenance::facts(
            std::slice::from_ref(&arguments.recording),
            &arguments.robot,
            &import.recording.origin,
        ),
    });
    let report = arguments.report.clone();
    let report = report.unwrap_or_else(|| vacant(Path::new("compare.html")));
    crate::output_file::write(&report, &page)?;
    for channel in &channels {
        let (robot, name, unit) = (&channel.robot, &channel.name, channel.unit);
        match channel.rms_difference() {
            Some(rms) => print_line!("{robot:12} {name:12} rms difference {rms:.4} {unit}"),
            None => print_line!("{robot:12} {name:12} nothing to compare"),
        }
    }
    print_line!("{}", report.display());
    Ok(Exit::Done)
}

/// The error as an input error that names the recording.
fn located(recording: &Path, error: CompareError) -> InputError {
    match error {
        CompareError::NoModel(robot) => {
            let problem = format!("has no model of {robot}");
            InputError::file(recording, problem, "give one with --robot")
        }
        CompareError::Model { robot, source } => InputError {
            place: format!(
                "{}: model of {robot}: {}",
                recording.display(),
                source.place
            ),
            ..source
        },
        CompareError::NothingToSimulate => InputError::file(
            recording,
            "no robot has two rows in command.csv or wheels.csv",
            "record the commands to the drives",
        ),
    }
}
