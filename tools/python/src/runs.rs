//! Runs, traces, studies, and the catalogue of effects.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use pyo3::prelude::*;
use slipstream_agents::{AgentContext, BuiltIn, Controller, ControllerError};
use slipstream_bus::experiment::EVERY_ROBOT;
use slipstream_bus::message::robot_name;
use slipstream_bus::{InputError, Shard};
use slipstream_launch::{Request, RunError, in_process, resolve};
use slipstream_sim::effects::CATALOGUE;
use slipstream_study::StudyError;
use slipstream_study::delay::{Grid, study as delay_study};

use crate::controllers::{PythonController, Watch};
use crate::errors::{failed, input, of_recording};
use crate::interruptible::interruptible;

/// Runs an experiment on the virtual clock in this process; returns its summary as JSON. `controllers` are controllers or what makes
/// them, by the names of robots or `*`.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "called from Python alone, by one function with named arguments"
)]
pub(crate) fn run(
    py: Python<'_>,
    experiment: Option<String>,
    robots: Option<u32>,
    models: Vec<(Option<String>, PathBuf)>,
    set: Vec<(String, String)>,
    seed: Option<u64>,
    out: Option<PathBuf>,
    controllers: Vec<(String, Py<PyAny>)>,
) -> PyResult<String> {
    let agent = |(name, made): &(String, Py<PyAny>)| (name.clone(), described(py, made));
    let request = Request {
        experiment,
        robots,
        agents: controllers.iter().map(agent).collect(),
        models,
        set,
        clock: Some(slipstream_bus::experiment::Clock::Virtual),
        seed,
        real: None,
    };
    let resolved = resolve(&request).map_err(|error| input(py, &error))?;
    let own = |name: &str| controllers.iter().any(|(given, _)| given == name);
    let lacking = resolved
        .programs
        .iter()
        .find(|(robot, _)| !own(&robot_name(**robot)) && !own(EVERY_ROBOT));
    if let Some((robot, program)) = lacking {
        let name = robot_name(*robot);
        let problem = format!("names {}, and this run has no processes", program.command);
        let remedy =
            format!("give controllers={{\"{name}\": …}}, or use the command slipstream run");
        return Err(input(
            py,
            &InputError::new(format!("agents.{name}"), problem, remedy),
        ));
    }
    let raised: Arc<Mutex<Option<PyErr>>> = Arc::default();
    let slot = Arc::clone(&raised);
    let done = interruptible(py, move |stop| {
        let make = |context: &AgentContext<'_>| -> Result<Box<dyn Controller>, ControllerError> {
            let given = |name: &str| controllers.iter().find(|(own, _)| own == name);
            Ok(
                match given(&context.name()).or_else(|| given(EVERY_ROBOT)) {
                    Some((_, made)) => {
                        let watch = Watch {
                            raised: Arc::clone(&slot),
                            stop: stop.clone(),
                        };
                        Box::new(PythonController::new(made, context, Some(watch))?)
                    }
                    None => Box::new(BuiltIn::new(context)?),
                },
            )
        };
        in_process::summary_controlled(&resolved, out.as_deref(), make)
    })?;
    let summary = done.map_err(|error| {
        let raised = raised.lock().ok().and_then(|mut slot| slot.take());
        match (error, raised) {
            (RunError::Input(error), None) => input(py, &error),
            (error, raised) => {
                let failed = failed(&error);
                failed.set_cause(py, raised);
                failed
            }
        }
    })?;
    serde_json::to_string(&summary).map_err(|error| failed(&error))
}

/// What stands for a controller of this process among the keys of the experiment.
fn described(py: Python<'_>, made: &Py<PyAny>) -> String {
    let made = made.bind(py);
    let class = made.get_type();
    let named = made
        .getattr("__name__")
        .or_else(|_| class.getattr("__name__"));
    named.map_or_else(|_| "Python".to_owned(), |name| format!("{name} (Python)"))
}

/// Latency of the positions of a recording, stage by stage, as JSON.
#[pyfunction]
pub(crate) fn trace(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let done = interruptible(py, move |_| {
        let reading = slipstream_trace::read(&path)?;
        let answer = slipstream_trace::answer(&reading.log, &reading.robots);
        reading.log.check()?;
        Ok(serde_json::to_string(&answer))
    })?;
    let text = done.map_err(|error| of_recording(py, error))?;
    text.map_err(|error| failed(&error))
}

/// Lists of a study by their names, as they arrive.
type StudyLists = Vec<(String, Vec<f64>)>;
type Words = Vec<(String, Vec<String>)>;

/// A study of communication delay, as JSON. What is not given is as in the command.
#[pyfunction]
pub(crate) fn study(
    py: Python<'_>,
    robots: Option<u32>,
    runs: Option<u32>,
    numbers: StudyLists,
    words: Words,
    threads: Option<usize>,
) -> PyResult<String> {
    let mut grid = Grid::default();
    grid.robots = robots.unwrap_or(grid.robots);
    grid.runs = runs.unwrap_or(grid.runs);
    for (name, values) in numbers {
        let list = match name.as_str() {
            "delay" => &mut grid.delay_s,
            "jitter" => &mut grid.jitter_s,
            "loss" => &mut grid.loss,
            "k_x" => &mut grid.k_x,
            _ => return Err(input(py, &unknown(&name))),
        };
        *list = values;
    }
    for (name, values) in words {
        let list = match name.as_str() {
            "torque_limit" => &mut grid.torque_limit,
            "protocol" => &mut grid.protocol,
            _ => return Err(input(py, &unknown(&name))),
        };
        *list = values;
    }
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = threads.unwrap_or_else(cores);
    let done = interruptible(py, move |stop| {
        delay_study(&grid, Shard::WHOLE, threads, stop.flag())
    })?;
    let study = done.map_err(|error| match error {
        StudyError::Input(error) => input(py, &error),
        other => failed(&other),
    })?;
    serde_json::to_string(&study).map_err(|error| failed(&error))
}

fn unknown(name: &str) -> InputError {
    let remedy = "lists are delay, jitter, loss, k_x, torque_limit, protocol";
    InputError::new(name, "is not a list of a study", remedy)
}

/// An effect as it leaves: id, summary, equation, source, and names and units of its parameters.
type EffectTuple = (String, String, String, String, Vec<(String, String)>);

/// The catalogue of effects: identity, summary, equation, source, and names and units of the parameters.
#[pyfunction]
pub(crate) fn effects() -> Vec<EffectTuple> {
    CATALOGUE
        .iter()
        .map(|info| {
            let parameters = info.parameters.iter();
            let parameters = parameters.map(|own| (own.name.to_owned(), own.unit.to_owned()));
            (
                info.id.to_owned(),
                info.summary.to_owned(),
                info.equation.to_owned(),
                info.source.to_owned(),
                parameters.collect(),
            )
        })
        .collect()
}
