//! A diagnosis: machine after machine, by the engine that its model asks for.

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::Recording;
use slipstream_recording::recording::Robot as Recorded;

use crate::answer::{Answer, Figures, advise};
use crate::data::faults;
use crate::data::track::Track;
use crate::explain::against;
use crate::explain::collected::Collected;
use crate::explain::dynamic::examine as dynamic;
use crate::explain::finding::finding;
use crate::explain::kinematic::{self, Earlier, Learnt, Task};
use crate::explain::links;
use crate::judge::conclude;
use crate::request::{Request, Runs, model_of};

/// The answer, each robot's improved model, and the figures of each machine.
pub type Illustrated = (Answer, Vec<(String, RobotModel)>, Vec<Figures>);

/// Diagnoses every robot of the recordings. Returns the answer and each robot's improved model.
///
/// # Errors
/// A robot that cannot be diagnosed, or a model that is none.
pub fn diagnose(request: &Request<'_>) -> Result<(Answer, Vec<(String, RobotModel)>), InputError> {
    let (answer, improved, _) = examine(request, false)?;
    Ok((answer, improved))
}

/// The same, with what the figures of a report show.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_with_figures(request: &Request<'_>) -> Result<Illustrated, InputError> {
    examine(request, true)
}

fn examine(request: &Request<'_>, illustrate: bool) -> Result<Illustrated, InputError> {
    let mut recordings = request.recordings.iter();
    if let Some(empty) = recordings.find(|own| own.robots.is_empty()) {
        let problem = "holds no robot to diagnose";
        let remedy = "give one with commands, wheels or poses of a robot";
        return Err(InputError::new(&empty.name, problem, remedy));
    }
    let (recordings, mut warnings) = faults::mended(request.recordings, request.model_of);
    let (against, _) = faults::mended(request.against, request.model_of);
    let request = &Request {
        recordings: &recordings,
        against: &against,
        ..*request
    };
    warnings.extend(faults::warnings(request)?);
    let mut collected = Collected::default();
    collected.answer.format = 1;
    collected.answer.warnings = warnings;
    let mut all: Vec<Figures> = Vec::new();
    let others = machines(request.against);
    let machines = machines(request.recordings);
    let is_alone = machines.len() == 1;
    for machine in machines {
        let other = against::counterpart(request, &machine, is_alone, &others)?;
        all.extend(one(request, &machine, other, &mut collected, illustrate)?);
    }
    let Collected {
        mut answer,
        mut improved,
        courses,
        predictions,
    } = collected;
    if let [recording] = request.recordings {
        let excluded = request.excluded;
        links::add(recording, &courses, excluded, &mut answer, &mut improved);
    }
    advise(&mut answer, &improved, request.recordings);
    answer.against = request.against.iter().map(|own| own.name.clone()).collect();
    conclude(&mut answer, &predictions);
    Ok((answer, improved, all))
}

/// Diagnoses one machine beside its runs from before; returns its figures, if they are asked for.
fn one(
    request: &Request<'_>,
    machine: &Runs<'_>,
    other: Option<&Runs<'_>>,
    collected: &mut Collected,
    illustrate: bool,
) -> Result<Option<Figures>, InputError> {
    let robots: Vec<&Recorded> = machine.iter().map(|(_, robot)| *robot).collect();
    let model = model_of(request, machine[0])?;
    slipstream_sim::Robot::new(&model)?;
    if kinematic::applies(&robots, &model) {
        let learnt = other.map(|other| against::learn(request, other, &model));
        let learnt = learnt.transpose()?;
        let model = learnt.as_ref().map_or(&model, |learnt| &learnt.model);
        let known = (model, other.zip(learnt.as_ref()));
        by_filter(request, machine, known, collected, illustrate)
    } else if dynamic::applies(&robots, &model) {
        let figures = dynamic::examine(request, machine, other, collected, illustrate)?;
        let runs = (0..machine.len()).map(|run| run_name(machine, run));
        Ok(figures.map(|figures| Figures {
            runs: runs.collect(),
            ..figures
        }))
    } else {
        Err(told_apart(machine, &model))
    }
}

/// Why a machine is neither told speeds alone nor efforts alone, or cannot be told its efforts.
fn told_apart(machine: &Runs<'_>, model: &RobotModel) -> InputError {
    let place = &machine[0].1.name;
    let accepts = |(recording, robot): &(&Recording, &Recorded)| {
        let kind = Track::new(recording, robot, model)?.kind();
        slipstream_sim::Robot::<f64>::new(model)?.accepts(kind)
    };
    if let Some(error) = machine.iter().find_map(|run| accepts(run).err()) {
        return error;
    }
    let problem = "is told speeds in one recording, torques or voltages in another";
    let remedy = "diagnose the recordings of each kind by themselves";
    InputError::new(place, problem, remedy)
}

/// Diagnoses a machine that is told speeds or nothing.
fn by_filter(
    request: &Request<'_>,
    machine: &Runs<'_>,
    (model, before): (&RobotModel, Option<(&Runs<'_>, &Learnt)>),
    collected: &mut Collected,
    illustrate: bool,
) -> Result<Option<Figures>, InputError> {
    let name = &machine[0].1.name;
    let progress = |what: &str| (request.progress)(&format!("{name}: {what}"));
    let found = kinematic::examine(&Task {
        runs: machine,
        model,
        excluded: request.excluded,
        excluded_s: request.excluded_s,
        progress: &progress,
        illustrate: illustrate.then_some(collected.answer.findings.len()),
        before: before.map(|(runs, learnt)| Earlier { runs, learnt }),
    })?;
    let runs: Vec<String> = found.robots.iter().map(|i| run_name(machine, *i)).collect();
    let answer = &mut collected.answer;
    for claim in &found.claims {
        let run = claim.runs.as_ref().and_then(|runs| runs.first());
        let span_s = found.spans_s[run.copied().unwrap_or(0)];
        let (mut finding, unexplained) = finding(claim, name, &runs, model, span_s);
        if let Some((earlier, learnt)) = before {
            against::compared(&mut finding, claim, learnt, &earlier[0].0.name);
        }
        answer.findings.push(finding);
        answer.unexplained.extend(unexplained);
    }
    answer.held_out.merge(&found.held_out);
    answer.budget.extend(found.budget);
    answer.outliers.extend(found.outliers);
    answer.detectable.extend(found.detectable);
    answer.process_noise.extend(found.process_noise);
    answer.warnings.extend(found.warnings);
    if let Some((earlier, _)) = before {
        let warnings = against::not_compared(machine, earlier);
        answer.warnings.extend(warnings);
    }
    collected.improved.push((name.clone(), found.improved));
    collected.predictions.push(found.predictions);
    collected.courses.extend(found.courses);
    Ok(found.figures.map(|figures| Figures { runs, ..figures }))
}

/// Name of a run: of its recording where there are several, else of its robot.
fn run_name(machine: &Runs<'_>, run: usize) -> String {
    let (recording, robot) = machine[run];
    let alone = machine
        .iter()
        .all(|(other, _)| std::ptr::eq(*other, recording));
    if alone {
        robot.name.clone()
    } else {
        recording.name.clone()
    }
}

/// The runs of each machine: robots of one name, or all robots of a recording that says so. Single
/// robots of several recordings are one machine whatever they are called.
pub(crate) fn machines(recordings: &[Recording]) -> Vec<Vec<(&Recording, &Recorded)>> {
    let alone = recordings.len() > 1 && recordings.iter().all(|r| r.robots.len() == 1);
    let mut machines: Vec<Vec<(&Recording, &Recorded)>> = Vec::new();
    for recording in recordings {
        for robot in &recording.robots {
            let known = machines.iter_mut().find(|machine| {
                let (first, other) = machine[0];
                let runs = recording.same_robot && std::ptr::eq(first, recording);
                alone || runs || other.name == robot.name
            });
            match known {
                Some(machine) => machine.push((recording, robot)),
                None => machines.push(vec![(recording, robot)]),
            }
        }
    }
    machines
}
