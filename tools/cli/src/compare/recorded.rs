//! `slipstream compare REAL SIMULATED`: two recordings of one experiment beside each other.

use std::path::Path;

use slipstream_bus::InputError;
use slipstream_recording::two_runs::{
    Experiment, LinkPair, Run, TwoRuns, TwoRunsError, compare_runs,
};
use slipstream_report::two_runs::Page;

use super::arguments::Arguments;
use super::table;
use crate::command_line::command_line;
use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::output_file;
use crate::print::{self, bold, note_line, print_line};
use crate::provenance;
use crate::reading::Reading;

/// Distance between the first poses from which on a note says that the robots start apart (m).
const START_APART_M: f64 = 0.05;

/// Compares the recording with that of a simulated run.
pub(super) fn run(arguments: &Arguments, simulated: &Path) -> Result<Exit, Error> {
    let real = &*arguments.recording;
    let models = Models::read(&arguments.robot)?;
    let read = [
        arguments.reading.read(real, &models)?,
        Reading::default().read(simulated, &models)?,
    ];
    let experiments = [real, simulated].map(Experiment::of);
    let names = [real, simulated].map(|path| path.display().to_string());
    let [first, second] = [0, 1].map(|side| Run {
        name: &names[side],
        recording: &read[side].recording,
        experiment: experiments[side].as_ref(),
    });
    let answer = compare_runs(first, second, |robot| models.of(robot))
        .map_err(|error| refused(real, simulated, &error))?;
    let answer = answer.with_links(links(real, simulated)?);
    note(&answer, experiments.iter().all(Option::is_none));
    if let Some(file) = &arguments.json {
        output_file::write_json(file, &answer)?;
    }
    let next = next(
        arguments,
        simulated,
        &answer,
        read[0].recording.model.is_some(),
    );
    if let Some(file) = &arguments.report {
        let files = [real.to_owned(), simulated.to_owned()];
        let page = slipstream_report::two_runs::page(&Page {
            answer: &answer,
            next: &next,
            command_line: command_line(),
            facts: provenance::facts(&files, &arguments.robot, &read[0].recording.origin),
        });
        output_file::write(file, &page)?;
    }
    print_line!("{}", bold(&answer.headline));
    print::out(format_args!("{}", table::table(&answer)));
    for command in &next {
        print_line!("Try: {command}");
    }
    Ok(Exit::Done)
}

/// The error as an input error that names both recordings.
fn refused(real: &Path, simulated: &Path, error: &TwoRunsError) -> InputError {
    let place = format!("{} and {}", real.display(), simulated.display());
    let remedy = match error {
        TwoRunsError::NoCommonRobot { .. } => "give recordings whose robots have the same names",
        TwoRunsError::NoCommonTime { .. } => {
            "give recordings whose times count from the start of the run"
        }
    };
    InputError::new(place, error.to_string(), remedy)
}

/// The links in the traces of both; none, with a note, if one of them has no trace.
fn links(real: &Path, simulated: &Path) -> Result<Vec<LinkPair>, Error> {
    let mut traces = Vec::new();
    for recording in [real, simulated] {
        match slipstream_trace::read(recording) {
            Ok(trace) => traces.push(trace),
            Err(error) => {
                note_line!("delays are left out: {error}");
                return Ok(Vec::new());
            }
        }
    }
    let [real, simulated] = &*traces else {
        return Ok(Vec::new());
    };
    let links = slipstream_trace::both(real, simulated);
    real.log.check()?;
    simulated.log.check()?;
    Ok(links)
}

/// Says what is left out, and which robots start at other places.
fn note(answer: &TwoRuns, has_no_experiment: bool) {
    if !answer.left_out.is_empty() {
        let robots = answer.left_out.join(", ");
        note_line!("in one of the recordings alone, and left out: {robots}");
    }
    if has_no_experiment && answer.robots.len() > 1 {
        note_line!(
            "spacing errors are left out: no recording has experiment.toml with formation.spacing_m; give one that `slipstream run` wrote"
        );
    }
    for pair in &answer.robots {
        if let Some(path) = pair.path.filter(|path| path.start_m > START_APART_M) {
            note_line!(
                "{}: starts {:.1} cm from its place in the simulation: it stood elsewhere, or its poses have another frame",
                pair.robot,
                100.0 * path.start_m
            );
        }
    }
}

/// The commands that say more.
fn next(arguments: &Arguments, simulated: &Path, answer: &TwoRuns, has_model: bool) -> Vec<String> {
    let real = arguments.recording.display();
    let given = arguments.robot.iter().map(|own| format!(" --robot {own}"));
    let robots = match given.collect::<String>() {
        none if none.is_empty() && !has_model => " --robot robot.toml".to_owned(),
        given => given,
    };
    let mut commands = vec![format!("slipstream diagnose {real}{robots}")];
    let mut stages = answer.links.iter().flat_map(|link| &link.stages);
    if stages.any(|own| own.changed == Some(true)) {
        let simulated = simulated.display();
        commands.push(format!("slipstream trace {real} --against {simulated}"));
    }
    commands
}
