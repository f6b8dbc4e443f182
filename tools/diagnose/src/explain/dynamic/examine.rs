//! Diagnosis of one machine whose masses are known and that is told torques or voltages.

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Robot as Recorded};

use super::machine::Machine;
use super::selection::Selection;
use super::{answer, pictures, prediction};
use crate::answer::Figures;
use crate::data::track::Sensor;
use crate::diagnosis::Collected;
use crate::diagnosis::Request;
use crate::explain::links::Course;
use crate::model::hypothesis::{self, with};
use crate::predict::predictor::Predictor;

/// Rows of a series over all runs above which it is thinned, and that each run keeps: what is denser says
/// little more, and every fit filters all of them.
const ROWS: usize = 6000;
const LEAST_ROWS: usize = 500;

/// Whether the filter over the plant diagnoses a machine: its masses are known, and torques or
/// voltages drive it.
pub(crate) fn applies(robots: &[&Recorded], model: &RobotModel) -> bool {
    let kind = |robot: &&&Recorded| match robot.command.as_ref().map(|stream| &stream.values) {
        Some(Command::Torque { .. }) => Some(slipstream_sim::CommandKind::Torque),
        Some(Command::Voltage { .. }) => Some(slipstream_sim::CommandKind::Voltage),
        _ => None,
    };
    let accepted = slipstream_sim::Robot::new(model);
    let Ok(plant) = accepted else { return false };
    robots
        .iter()
        .all(|robot| kind(&robot).is_some_and(|kind| plant.accepts(kind).is_ok()))
}

/// Diagnoses a machine; returns what its figures show, if they are asked for.
///
/// # Errors
/// A machine that cannot be diagnosed.
pub(crate) fn examine(
    request: &Request<'_>,
    runs: &[(&Recording, &Recorded)],
    collected: &mut Collected,
    illustrate: bool,
) -> Result<Option<Figures>, InputError> {
    let name = &runs[0].1.name;
    let progress = |what: &str| (request.progress)(&format!("{name}: {what}"));
    let predictor = Predictor::new(request, runs)?;
    let all = hypothesis::all(&predictor.model, &predictor.tracks, request.excluded);
    let mut tracks = predictor.tracks.clone();
    let most = (ROWS / tracks.len().max(1)).max(LEAST_ROWS);
    tracks.iter_mut().for_each(|track| track.thin(most));
    let machine = Machine::new(tracks, predictor.model.clone(), request.excluded);
    let mut selection = Selection {
        machine,
        all: &all,
        progress: &progress,
    };
    let unusable = || {
        let remedy = "check masses, lengths and units, and the kind of the commands";
        InputError::new(name, "cannot be simulated by its model", remedy)
    };
    let selected = selection.run().ok_or_else(unusable)?;
    let machine = selection.machine;
    progress("how well it predicts");
    let fit = &selected.fit;
    let answer = &mut collected.answer;
    let first_finding = answer.findings.len();
    answer
        .findings
        .extend(answer::findings(&machine, &selected));
    answer
        .held_out
        .merge(&prediction::held_out(&machine, &predictor, fit));
    answer
        .budget
        .extend(prediction::budgets(&machine, &predictor, fit));
    let noise = answer::process_noise(&machine, selected.whole());
    answer.warnings.extend(answer::wandering(&machine, &noise));
    answer.warnings.extend(answer::gusts(&machine));
    answer.process_noise.extend(noise);
    let mut improved = with(&machine.model, &fit.hypotheses);
    if let Some(unknown) = &selected.unknown {
        let (finding, what) = answer::outside(&machine, &selected, unknown);
        answer.findings.push(finding);
        answer.unexplained.push(what);
        improved.effects.extend(unknown.spec.clone());
    }
    collected.improved.push((name.clone(), improved));
    collected.courses.extend(course(&machine, fit));
    if !illustrate {
        return Ok(None);
    }
    progress("figures");
    Ok(Some(pictures::figures(
        &machine,
        &predictor,
        &selected,
        &all,
        first_finding,
    )))
}

/// Where the robot was in its first run, by the filter; none without a pose.
fn course(machine: &Machine, fit: &super::fit::Fit) -> Option<Course> {
    let track = &machine.tracks[0];
    let deviation = track.of(Sensor::Pose)?.deviation;
    let mut points: Vec<(f64, [f64; 3])> = Vec::new();
    machine.watched(fit, &fit.hypotheses, |run, t_s, state, _| {
        if run == 0 && points.last().is_none_or(|(last, _)| *last < t_s) {
            points.push((t_s, state.pose()));
        }
    })?;
    Some(Course::of(track.robot.clone(), points, deviation))
}
