//! Recording and model in; what the model leaves out, where, how much and how sure, out.
//!
//! The nominal model is simulated from the recorded commands in windows of 5 s, each with a free
//! initial state. Every effect of the catalogue is a hypothesis, fitted together with those found
//! before by least squares with the plant's own derivatives; the one that pays most is kept, until
//! none pays. Effects that need a search over place or time (`friction_patch`, `push`), inertial
//! sensors, links and recordings without commands are not searched yet, and the answer says so.

mod answer;
mod bench;
mod drivers;
mod figures;
mod fit;
mod force;
mod hypothesis;
mod limits;
mod linear;
mod local;
mod misfit;
mod noise;
mod score;
mod search;
mod simulate;
mod track;
mod unknown;
mod window;

use slipstream_bus::RobotModel;
use slipstream_recording::Recording;

pub use answer::{
    Answer, Finding, HeldOut, HeldOutChannel, ParameterEstimate, Unexplained, Verdict,
};
pub use figures::{Against, Figures, MissingForce, Paths, Point, Residuals};
pub use limits::{Limit, Seen};

use crate::bench::Bench;
use crate::search::{Found, Search};
use crate::track::Track;

/// Why a recording cannot be diagnosed: the place, what is wrong and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}; {remedy}")]
pub struct Unusable {
    /// File, robot or key.
    pub place: String,
    /// What is wrong.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
}

impl Unusable {
    pub(crate) fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }
}

/// Diagnoses every robot of `recording` that has commands. `model_of` gives each robot's nominal
/// model, `excluded` names effects that are not to be tried, `progress` hears what is being done.
///
/// # Errors
/// A recording in which no robot can be diagnosed, or a model that is none.
pub fn diagnose(
    recording: &Recording,
    model_of: impl Fn(&str) -> Option<RobotModel>,
    excluded: &[String],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<(Answer, Vec<(String, RobotModel)>), Unusable> {
    examine(recording, model_of, excluded, progress, |_, _| ())
}

/// The answer, each robot's improved model, and the figures of each machine.
pub type Illustrated = (Answer, Vec<(String, RobotModel)>, Vec<Figures>);

/// The same, with what the figures of a report show.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_with_figures(
    recording: &Recording,
    model_of: impl Fn(&str) -> Option<RobotModel>,
    excluded: &[String],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Illustrated, Unusable> {
    let mut figures = Vec::new();
    let each = |search: &Search<'_>, found: &Found| figures.push(Figures::new(search, found));
    let (answer, improved) = examine(recording, model_of, excluded, progress, each)?;
    Ok((answer, improved, figures))
}

/// Diagnoses machine after machine; `each` sees what was found on it.
fn examine(
    recording: &Recording,
    model_of: impl Fn(&str) -> Option<RobotModel>,
    excluded: &[String],
    progress: &(dyn Fn(&str) + Sync),
    mut each: impl FnMut(&Search<'_>, &Found),
) -> Result<(Answer, Vec<(String, RobotModel)>), Unusable> {
    let mut answer = Answer::default();
    let mut improved = Vec::new();
    for robot in &recording.robots {
        let model = model_of(&robot.name)
            .or_else(|| recording.model.clone())
            .ok_or_else(|| {
                Unusable::new(
                    &robot.name,
                    "has no model",
                    "give one with --robot robot.toml",
                )
            })?;
        let track = Track::new(recording, robot, &model)?;
        slipstream_sim::Robot::new(&model)
            .map_err(|error| Unusable::new(error.key, error.problem, error.remedy))?;
        let windows = window::cut(&track, 0, window::WINDOW_S);
        let tracks = vec![track];
        let all = hypothesis::all(&model, &tracks, excluded);
        let bench = Bench {
            tracks,
            windows,
            model,
        };
        let search = Search {
            bench: &bench,
            all,
            excluded,
            progress: &|what| progress(&format!("{}: {what}", robot.name)),
        };
        let found = search.run().ok_or_else(|| {
            let remedy = "check masses, lengths and units, and that commands are of the named kind";
            Unusable::new(&robot.name, "cannot be simulated by its model", remedy)
        })?;
        answer.add(&bench, &found);
        each(&search, &found);
        improved.push((robot.name.clone(), answer::improved(&bench, &found)));
    }
    answer.conclude();
    Ok((answer, improved))
}
