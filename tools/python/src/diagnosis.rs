//! Diagnoses.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use slipstream_answer::{Answer, Figures};
use slipstream_bus::{InputError, RobotModel};
use slipstream_diagnose::Request;
use slipstream_recording::recording::Recording as Inner;
use slipstream_recording::{robot_file, robot_toml};
use slipstream_report::diagnose as report;

use crate::errors::{failed, input};
use crate::interruptible::{Stop, interruptible};
use crate::recording::Recording;

/// Models by the name of the robot; without a name for every robot that has none of its own.
type ModelsByName = Vec<(Option<String>, RobotModel)>;

/// An answer with what its page shows.
#[pyclass(module = "slipstream._slipstream", frozen)]
pub(crate) struct Diagnosis {
    answer: Answer,
    improved: Vec<(String, RobotModel)>,
    figures: Vec<Figures>,
    recordings: Vec<Inner>,
    models: ModelsByName,
    command_line: String,
}

/// Diagnoses recordings, or what changed since those of `against`. `robots` are texts of robot.toml, URDF or
/// a controller's YAML by the name of the robot;
/// `figures` computes what a page shows.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "called from Python alone, by one function with named arguments"
)]
pub(crate) fn diagnose(
    py: Python<'_>,
    recordings: Vec<PyRef<'_, Recording>>,
    against: Vec<PyRef<'_, Recording>>,
    robots: Vec<(Option<String>, String)>,
    without: Vec<String>,
    exclude_time: Vec<[f64; 2]>,
    figures: bool,
    command_line: String,
) -> PyResult<Diagnosis> {
    let shared = |all: &[PyRef<'_, Recording>]| -> Vec<Arc<Inner>> {
        all.iter().map(|own| Arc::clone(&own.inner)).collect()
    };
    let [recordings, against] = [shared(&recordings), shared(&against)];
    let models: Result<ModelsByName, InputError> = robots
        .into_iter()
        .map(|(name, text)| {
            let place = PathBuf::from(name.as_deref().unwrap_or("robot"));
            Ok((name, robot_file::parse(&text, &place)?.model()?))
        })
        .collect();
    let models = models.map_err(|error| input(py, &error))?;
    for id in &without {
        if slipstream_sim::effects::find(id).is_none() {
            let error = InputError::new(id, "is not an effect", "see slipstream.effects()");
            return Err(input(py, &error));
        }
    }
    let own = models.clone();
    let work = move |stop: &Stop| {
        let owned = |all: &[Arc<Inner>]| all.iter().map(|own| (**own).clone()).collect();
        let [owned, before]: [Vec<Inner>; 2] = [owned(&recordings), owned(&against)];
        let request = Request {
            recordings: &owned,
            against: &before,
            model_of: &|robot| of(&own, robot),
            excluded: &without,
            excluded_s: &exclude_time,
            progress: &|_| stop.check(),
        };
        let answered = if figures {
            slipstream_diagnose::diagnose_with_figures(&request)
        } else {
            let answered = slipstream_diagnose::diagnose(&request);
            answered.map(|(answer, improved)| (answer, improved, Vec::new()))
        };
        answered.map(|answered| (owned, answered))
    };
    let done = interruptible(py, work)?;
    let (recordings, (answer, improved, figures)) = done.map_err(|error| input(py, &error))?;
    Ok(Diagnosis {
        answer,
        improved,
        figures,
        recordings,
        models,
        command_line,
    })
}

/// The model of a robot.
fn of(models: &ModelsByName, robot: &str) -> Option<RobotModel> {
    let named = models
        .iter()
        .find(|(name, _)| name.as_deref() == Some(robot));
    let chosen = named.or_else(|| models.iter().find(|(name, _)| name.is_none()));
    chosen.map(|(_, model)| model.clone())
}

#[pymethods]
impl Diagnosis {
    /// The answer as JSON.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string(&self.answer).map_err(|error| failed(&error))
    }

    /// The improved models as texts of robot.toml, by the name of the robot.
    fn improved(&self) -> Vec<(String, String)> {
        let each = self.improved.iter();
        each.map(|(name, model)| (name.clone(), robot_toml::to_text(model)))
            .collect()
    }

    /// The whole page.
    fn page(&self) -> String {
        self.with(report::page)
    }

    /// The first screen of the page, as a page of its own.
    fn first_screen(&self) -> String {
        self.with(report::first_screen_page)
    }
}

impl Diagnosis {
    fn with(&self, write: fn(&report::Diagnosis<'_>) -> String) -> String {
        let names: Vec<&str> = self
            .recordings
            .iter()
            .map(|own| own.name.as_str())
            .collect();
        write(&report::Diagnosis {
            subject: names.join(", "),
            answer: &self.answer,
            figures: &self.figures,
            recordings: &self.recordings,
            model_of: &|robot| of(&self.models, robot),
            improved: &self.improved,
            command_line: self.command_line.clone(),
            facts: Vec::new(),
        })
    }
}
