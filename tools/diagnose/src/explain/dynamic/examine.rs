//! Diagnosis of one machine whose masses are known and that is told torques or voltages.

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::recording::{Command, Robot as Recorded};

use super::judged::{Judged, alone, whole};
use super::{answer, compare, pictures, prediction};
use crate::answer::{Figures, Finding};
use crate::data::track::Sensor;
use crate::explain::collected::Collected;
use crate::explain::finding::since;
use crate::explain::links::Course;
use crate::judge::{Culprit, Predictions, Score, passing};
use crate::model::hypothesis::with;
use crate::model::plant::filtered::Filtered;
use crate::model::plant::machine::Machine;
use crate::predict::predictor::Predictor;
use crate::request::{Request, Runs};

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
    runs: &Runs<'_>,
    before: Option<&Runs<'_>>,
    collected: &mut Collected,
    illustrate: bool,
) -> Result<Option<Figures>, InputError> {
    let name = &runs[0].1.name;
    let progress = |what: &str| (request.progress)(&format!("{name}: {what}"));
    let (mut found, refused) = passing(request.excluded, &progress, |excluded| {
        let own = Request {
            excluded,
            ..*request
        };
        let found = looked_for(&own, runs, before, &progress)?;
        if let Some(culprit) = found.culprit() {
            return Ok(Err(culprit));
        }
        let found = match before {
            None => found.whole(&progress).ok_or_else(|| unusable(name))?,
            Some(_) => found,
        };
        Ok(match found.culprit() {
            Some(culprit) => Err(culprit),
            None => Ok(found),
        })
    })?;
    found.predictions.refused = refused;
    add(&found, before, collected);
    let figures = illustrate.then(|| illustrated(&found, collected, &progress));
    collected.predictions.push(found.predictions);
    Ok(figures)
}

/// A machine, what it is predicted by, and what was found on it.
struct FoundOnMachine {
    predictor: Predictor,
    judged: Judged,
    predictions: Predictions,
}

impl FoundOnMachine {
    /// An effect that predicts worse.
    fn culprit(&self) -> Option<Culprit> {
        let worth = || prediction::worth(&self.predictor, &self.judged.selected.fit);
        self.predictions.culprit(worth)
    }

    /// The same with single pushes and forces outside of the catalogue, which may take the place of effects.
    fn whole(self, progress: &(dyn Fn(&str) + Sync)) -> Option<Self> {
        let at = self.judged.selected.at.clone();
        let judged = whole(self.judged, progress)?;
        let same = judged.selected.at == at;
        let predictions = if same {
            self.predictions
        } else {
            prediction::predictions(&judged, &self.predictor)
        };
        Some(Self {
            judged,
            predictions,
            ..self
        })
    }
}

pub(super) fn unusable(robot: &str) -> InputError {
    let remedy = "check masses, lengths and units, and the kind of the commands";
    InputError::new(robot, "cannot be simulated by its model", remedy)
}

fn looked_for(
    request: &Request<'_>,
    runs: &Runs<'_>,
    before: Option<&Runs<'_>>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<FoundOnMachine, InputError> {
    let mut predictor = Predictor::new(request, runs)?;
    let unusable = || unusable(&runs[0].1.name);
    let (judged, other) = match before {
        None => (
            alone(request, &predictor, progress).ok_or_else(unusable)?,
            None,
        ),
        Some(runs) => {
            let other = Predictor::new(request, runs)?;
            let judged = compare::judged(request, [&other, &predictor], progress);
            (judged.ok_or_else(unusable)?, Some(other))
        }
    };
    predictor.model = judged.machine.model.clone();
    progress("how well it predicts");
    let fit = &judged.selected.fit;
    let mut predictions = prediction::predictions(&judged, &predictor);
    if let Some(mut other) = other {
        // what was learnt from before is in the model by now
        other.model = judged.machine.model.clone();
        let scores = other.scores(&other.windows, &[]);
        predictions.expect_as(&Score::of_all(&scores), !fit.hypotheses.is_empty());
    }
    Ok(FoundOnMachine {
        predictor,
        judged,
        predictions,
    })
}

/// Adds what was found to the answer.
fn add(found: &FoundOnMachine, before: Option<&Runs<'_>>, collected: &mut Collected) {
    let Judged {
        machine, selected, ..
    } = &found.judged;
    let fit = &selected.fit;
    let answer = &mut collected.answer;
    answer.findings.extend(findings(&found.judged, before));
    answer
        .held_out
        .merge(&prediction::held_out(machine, &found.predictions));
    let worth = prediction::worth(&found.predictor, fit);
    answer.budget.extend(found.predictions.budgets(&worth));
    let noise = answer::process_noise(machine, selected.whole());
    answer.warnings.extend(answer::wandering(machine, &noise));
    answer.warnings.extend(answer::gusts(machine));
    answer.process_noise.extend(noise);
    let mut improved = with(&machine.model, &fit.hypotheses);
    if let Some(unknown) = &selected.unknown {
        let (finding, what) = answer::outside(machine, selected, unknown);
        answer.findings.push(finding);
        answer.unexplained.push(what);
        improved.effects.extend(unknown.spec.clone());
    }
    let name = machine.tracks[0].robot.clone();
    collected.improved.push((name, improved));
    collected.courses.extend(course(machine, fit));
}

/// The figures of a machine whose findings are the last of the answer.
fn illustrated(
    found: &FoundOnMachine,
    collected: &Collected,
    progress: &(dyn Fn(&str) + Sync),
) -> Figures {
    progress("figures");
    let Judged {
        machine,
        selected,
        all,
        ..
    } = &found.judged;
    let robot = &machine.tracks[0].robot;
    let findings = &collected.answer.findings;
    let first = findings.iter().position(|own| own.robot == *robot);
    let first = first.unwrap_or(findings.len());
    pictures::figures(machine, &found.predictor, selected, all, first)
}

/// What was found; of a comparison, as changes.
fn findings(judged: &Judged, before: Option<&Runs<'_>>) -> Vec<Finding> {
    let mut all = answer::findings(&judged.machine, &judged.selected);
    let Some(before) = before else { return all };
    for finding in &mut all {
        let effect = finding.effect.clone();
        since(finding, &before[0].0.name, |parameter| {
            let mut known = judged.nominal.iter();
            let own = known.find(|(own, name, _)| effect == *own && parameter.name == *name);
            own.map(|(.., interval)| *interval)
        });
    }
    all
}

/// Where the robot was in its first run, by the filter; none without a pose.
fn course(machine: &Machine, fit: &Filtered) -> Option<Course> {
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
