//! The older engine, for machines that are told speeds and torques: windows of 5 s, each simulated open loop.
//!
//! The nominal model is simulated from what drove the robot in windows of 5 s, each with a free
//! initial state. Every effect of the catalogue is a hypothesis, fitted together with those found
//! before by least squares; those that bring most are kept side by side, until nothing pays. Pushes
//! and patches are looked for by time and place first. What no effect explains is looked for as a
//! force that follows a variable. ARCHITECTURE.md has the steps, and the limits.

mod against;
mod answer;
mod around;
pub(crate) mod bench;
mod drivers;
mod figures;
mod fit;
#[cfg(test)]
pub(crate) mod fixture;
mod follow;
mod force;
pub(crate) mod hypothesis;
pub(crate) mod input;
mod interval;
mod law;
mod limits;
mod linear;
mod links;
mod local;
pub(crate) mod located;
pub(crate) mod misfit;
mod moment;
mod motion;
mod noise;
mod passing;
mod pay;
mod predict;
mod promise;
mod recut;
mod refine;
mod ridge;
mod sampled;
pub(crate) mod score;
mod search;
mod settle;
pub(crate) mod simulate;
mod start;
mod swell;
pub(crate) mod track;
mod unknown;
mod wander;
mod weigh;
pub(crate) mod window;
mod work;

use std::sync::Arc;

use slipstream_bus::RobotModel;
use slipstream_recording::Recording;
use slipstream_recording::recording::Robot as Recorded;

pub use predict::{Prediction, predict};

pub(crate) use figures::figures;
pub(crate) use links::{Course, add as add_links};

use crate::answer::Answer;
use crate::diagnosis::{Request, model_of};

use bench::Bench;
use search::{Outcome, Search};
use track::Track;
use weigh::Found;

use slipstream_bus::InputError;

/// Rows of a series above which it is thinned: more say no more.
const ROWS: usize = 9000;

/// How often windows are cut anew, so that none begins in a slide.
const CUTS: u32 = 4;

/// What is added while machine after machine is diagnosed.
#[derive(Default)]
pub(crate) struct Collected {
    pub(crate) answer: Answer,
    pub(crate) improved: Vec<(String, RobotModel)>,
    pub(crate) courses: Vec<Course>,
}

/// Diagnoses one machine; `each` sees what was found on it, block by block.
pub(crate) fn examine(
    request: &Request<'_>,
    machine: &[(&Recording, &Recorded)],
    collected: &mut Collected,
    each: impl FnOnce(&Bench, &Found),
) -> Result<(), InputError> {
    let Collected {
        answer,
        improved,
        courses,
    } = collected;
    let name = &machine[0].1.name;
    let bench = bench(request, machine)?;
    let unusable = || {
        let remedy = "check masses, lengths and units, and the kind of the commands";
        InputError::new(name, "cannot be simulated by its model", remedy)
    };
    let progress = |what: &str| (request.progress)(&format!("{name}: {what}"));
    let (mut again, mut known, mut slides) = (None, Vec::new(), Vec::new());
    let mut cuts = 0;
    let found = loop {
        let bench = again.as_ref().unwrap_or(&bench);
        let search = Search {
            bench,
            all: hypothesis::all(&bench.model, &bench.tracks, request.excluded),
            excluded: request.excluded,
            known,
            cuts: cuts < CUTS,
            progress: &progress,
        };
        match search.run().ok_or_else(unusable)? {
            Outcome::Found(found) => break found,
            Outcome::Slides(more, found) => {
                slides.extend(more);
                let next = bench.avoiding(&slides);
                cuts = if next.begins_as(bench) {
                    CUTS
                } else {
                    cuts + 1
                };
                (known, again) = (found, Some(next));
            }
        }
    };
    let bench = again.as_ref().unwrap_or(&bench);
    answer.add(bench, &found);
    each(bench, &found);
    courses.extend(Course::new(bench, &found.node));
    answer.judge(bench, &found.node.hypotheses, found.unknown.as_ref());
    let better = bench::with(&bench.model, &found.node.hypotheses);
    improved.push((name.clone(), better));
    Ok(())
}

pub(crate) fn bench(
    request: &Request<'_>,
    machine: &[(&Recording, &Recorded)],
) -> Result<Bench, InputError> {
    let robot = machine[0].1;
    let model = model_of(request, machine[0])?;
    let constants = slipstream_sim::Robot::new(&model)?;
    let mut tracks = Vec::new();
    for (recording, robot) in machine {
        let mut track = Track::new(recording, robot, &model)?;
        constants.accepts(track.kind())?;
        track.leave_out(request.excluded_s);
        track.thin(ROWS);
        tracks.push(track);
    }
    let windows = window::cut_fitted(&tracks, &[]);
    if windows.is_empty() {
        let remedy = "record at least a few seconds, or exclude less";
        return Err(InputError::new(&robot.name, "has nothing to fit", remedy));
    }
    Ok(Bench {
        tracks,
        windows,
        model,
        law: None,
        work: Arc::default(),
    })
}
