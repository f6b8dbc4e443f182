//! Description of the controllers that programs have, before a run: their parameters take their place among the keys, and a
//! program that is no agent is refused.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::process::{ExitStatus, Stdio};
use std::time::{Duration, Instant};

use slipstream_agents::ControllerError;
use slipstream_agents::process::{Arguments, Description};
use slipstream_bus::InputError;
use slipstream_bus::experiment::{EVERY_ROBOT, Parameters};
use slipstream_bus::message::{RobotIndex, robot_name};

use crate::program::Program;
use crate::resolve::{Origin, Resolved};

/// Time that a program has to describe its controller. Python with its libraries takes a second or two.
const TIMEOUT: Duration = Duration::from_secs(20);
/// Interval between two looks whether a program has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(2);
/// Longest part of what a program says that is passed on (bytes).
const MAX_SAID: usize = 8 << 10;

/// Asks every program of the experiment for the parameters of its controller and adds them to the keys. `say` passes on what a program
/// that cannot be used has to say.
///
/// # Errors
/// A program that does not describe a controller; a parameter that it does not have, or of another type.
pub fn describe(resolved: &mut Resolved, say: &dyn Fn(&str)) -> Result<(), InputError> {
    if resolved.programs.is_empty() {
        return Ok(());
    }
    let unwritable = |error: std::io::Error| {
        InputError::new("the temporary folder", error.to_string(), "make room there")
    };
    let folder = tempfile::Builder::new()
        .prefix("slipstream-")
        .tempdir()
        .map_err(unwritable)?;
    let experiment = postcard::to_allocvec(&resolved.experiment)
        .map_err(|error| unwritable(std::io::Error::other(error)))?;
    std::fs::write(folder.path().join(Description::EXPERIMENT), experiment).map_err(unwritable)?;
    // Robots with one program and one set of parameters are asked once.
    let mut known: Vec<(&Program, Parameters, Parameters)> = Vec::new();
    let mut all: BTreeMap<RobotIndex, Parameters> = BTreeMap::new();
    for (&robot, program) in &resolved.programs {
        let given = resolved.experiment.settings.parameters(robot);
        let same = |(other, own, _): &&(&Program, Parameters, Parameters)| {
            *other == program && *own == given
        };
        let described = match known.iter().find(same) {
            Some((.., described)) => described.clone(),
            None => {
                let described = ask(program, robot, folder.path(), say)
                    .map_err(|error| refusal(resolved, program, robot, error))?;
                known.push((program, given, described.clone()));
                described
            }
        };
        all.insert(robot, described);
    }
    add_keys(resolved, &all);
    Ok(())
}

/// Asks one program for the parameters of its controller.
fn ask(
    program: &Program,
    robot: RobotIndex,
    folder: &Path,
    say: &dyn Fn(&str),
) -> Result<Parameters, ControllerError> {
    let system = |error: std::io::Error| format!("cannot be started: {error}");
    let described = folder.join(Description::FILE);
    let said = folder.join("said");
    // There is none before the first program.
    let _ = std::fs::remove_file(&described);
    let mut command = program.command();
    command.args(Arguments::to_start(folder, robot, None));
    command.stdin(Stdio::null()).stdout(Stdio::null());
    command.stderr(File::create(&said).map_err(system)?);
    let mut child = command.spawn().map_err(system)?;
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().map_err(system)? {
            break Some(status);
        }
        if begin.elapsed() > TIMEOUT {
            // It may have ended just now.
            let _ = child.kill();
            let _ = child.wait();
            break None;
        }
        std::thread::sleep(POLL_INTERVAL);
    };
    let description = std::fs::read(&described).ok();
    let description =
        description.and_then(|json| serde_json::from_slice::<Description>(&json).ok());
    let error = match description.map(|own| own.parameters) {
        Some(Ok(parameters)) => return Ok(parameters),
        Some(Err(error)) => error,
        None => no_agent(program, robot, status).into(),
    };
    let said = std::fs::read(&said).unwrap_or_default();
    let tail = said.get(said.len().saturating_sub(MAX_SAID)..);
    let text = String::from_utf8_lossy(tail.unwrap_or_default());
    let say_text = |text: &str| {
        if !text.trim().is_empty() {
            say(text.trim_end());
        }
    };
    say_text(&text);
    // What follows the first line, such as a traceback, is no part of the sentence.
    Err(match error {
        ControllerError::Failed(reason) => {
            let (first, more) = reason.split_once('\n').unwrap_or((&reason, ""));
            say_text(more);
            first.into()
        }
        other => other,
    })
}

/// What is wrong with a program that has described no controller.
fn no_agent(program: &Program, robot: RobotIndex, status: Option<ExitStatus>) -> InputError {
    let problem = match status.map(|status| status.code()) {
        Some(Some(127)) => "is not found".to_owned(),
        Some(Some(126)) => "cannot be executed".to_owned(),
        Some(Some(code)) => format!("ended with exit code {code} and described no controller"),
        Some(None) => "was killed and described no controller".to_owned(),
        None => format!("described no controller within {} s", TIMEOUT.as_secs()),
    };
    let remedy = "give --agent the command of a program that calls run_agent";
    InputError::new(place(program, robot), problem, remedy)
}

/// A program as the place of an error.
fn place(program: &Program, robot: RobotIndex) -> String {
    format!("the program of {} ({})", robot_name(robot), program.command)
}

/// The error of a program, or of a key for it: that is at fault where it was given.
fn refusal(
    resolved: &Resolved,
    program: &Program,
    robot: RobotIndex,
    error: ControllerError,
) -> InputError {
    let error = match error {
        ControllerError::Input(error) => error,
        ControllerError::Failed(reason) => {
            return InputError::new(place(program, robot), reason, "correct the program");
        }
    };
    let key = resolved.keys.iter().find(|(key, ..)| *key == error.place);
    match key {
        Some((key, _, origin)) => {
            let problem = format!("{key} {}", error.problem);
            InputError::new(origin.to_string(), problem, error.remedy)
        }
        None => error,
    }
}

/// Puts the parameters of all robots in the place of those that were given.
fn add_keys(resolved: &mut Resolved, all: &BTreeMap<RobotIndex, Parameters>) {
    let given: BTreeMap<String, Origin> = resolved
        .keys
        .iter()
        .map(|(key, _, origin)| (key.clone(), origin.clone()))
        .collect();
    resolved
        .keys
        .retain(|(key, ..)| !key.starts_with("controller."));
    for (&robot, parameters) in all {
        let name = robot_name(robot);
        for (parameter, value) in parameters {
            let own = format!("controller.{name}.{parameter}");
            let shared = format!("controller.{EVERY_ROBOT}.{parameter}");
            let origin = given.get(&own).or_else(|| given.get(&shared)).cloned();
            let program = || Origin::Program(resolved.programs[&robot].command.clone());
            let value = toml::Value::try_from(value).map(|value| value.to_string());
            let origin = origin.unwrap_or_else(program);
            resolved.keys.push((own, value.unwrap_or_default(), origin));
        }
    }
    resolved.keys.sort_by(|one, other| one.0.cmp(&other.0));
}
