//! Prediction of a run by a model that was improved on another run.

use slipstream_diagnose::{InputError, Prediction};
use slipstream_recording::Recording;

use crate::agreement::alone;
use crate::study::{Found, Study, predicted};

/// Recordings of one machine: fitted on, predicted.
const RECORDINGS: [[&str; 2]; 2] = [
    ["trento-wheelchair-01", "trento-wheelchair-03"],
    ["trento-wheelchair-03", "trento-wheelchair-01"],
];

/// Robots of one recording: fitted together, predicted.
const ROBOTS: [(&str, &[&str], &str); 3] = [
    ("mrclam7-robots123", &["robot1", "robot2"], "robot3"),
    (
        "husky-terrains-a",
        &["husky_asphalt_00"],
        "husky_asphalt_06",
    ),
    (
        "husky-terrains-a",
        &["husky_asphalt_06"],
        "husky_asphalt_00",
    ),
];

/// Recordings of one run: fitted on the first two thirds, predicted on the rest.
const TIMES: [&str; 1] = ["warthog-skid-a"];

/// A model tried on what it was not made from.
pub(crate) struct Transfer {
    pub(crate) fitted_on: String,
    pub(crate) tried_on: String,
    /// The effects that were found.
    pub(crate) effects: Vec<String>,
    pub(crate) before: Prediction,
    pub(crate) after: Prediction,
}

/// Every transfer of which the recordings are there.
pub(crate) fn transfers(
    recordings: &[Recording],
    studies: &[Study<'_>],
) -> Result<Vec<Transfer>, InputError> {
    let at = |name: &str| recordings.iter().position(|r| r.name == name);
    let mut list = Vec::new();
    for [from, to] in RECORDINGS {
        if let (Some(from), Some(to)) = (at(from), at(to)) {
            let found = &studies[from].found;
            let name = recordings[from].name.clone();
            list.extend(tried(found, name, &recordings[to], &[])?);
        }
    }
    for (name, from, to) in ROBOTS {
        let Some(recording) = at(name).map(|at| &recordings[at]) else {
            continue;
        };
        let place = |robot: &&str| recording.robots.iter().position(|r| r.name == **robot);
        let learnt: Option<Vec<usize>> = from.iter().map(place).collect();
        if let (Some(learnt), Some(to)) = (learnt, place(&to)) {
            let mut together = alone(recording, &learnt);
            together.same_robot = true;
            let found = Found::new(&[together], &[])?;
            let name = format!("{name}: {}", from.join(", "));
            list.extend(tried(&found, name, &alone(recording, &[to]), &[])?);
        }
    }
    for recording in TIMES.iter().filter_map(|name| Some(&recordings[at(name)?])) {
        let until_s = 2.0 / 3.0 * end_s(recording);
        let later = [[until_s, f64::MAX]];
        let found = Found::new(std::slice::from_ref(recording), &later)?;
        let name = format!("{}: 0 to {until_s:.0} s", recording.name);
        let mut tried = tried(&found, name, recording, &[[f64::MIN, until_s]])?;
        for one in &mut tried {
            one.tried_on = format!("{}: from {until_s:.0} s on", recording.name);
        }
        list.extend(tried);
    }
    Ok(list)
}

fn tried(
    found: &Found,
    fitted_on: String,
    recording: &Recording,
    excluded_s: &[[f64; 2]],
) -> Result<Vec<Transfer>, InputError> {
    let before = predicted(recording, &|_| None, excluded_s)?;
    let after = predicted(
        recording,
        &|robot| found.model_of(robot).cloned(),
        excluded_s,
    )?;
    let pairs = before.into_iter().zip(after);
    let effects = found.answer.findings.iter().map(|f| f.effect.clone());
    let effects: Vec<String> = effects.collect();
    let transfers = pairs.map(|(before, after)| Transfer {
        fitted_on: fitted_on.clone(),
        tried_on: format!("{}: {}", recording.name, before.robot),
        effects: effects.clone(),
        before,
        after,
    });
    Ok(transfers.collect())
}

/// The last stamp of anything that was told or measured (s).
fn end_s(recording: &Recording) -> f64 {
    let ends = recording.robots.iter().flat_map(|robot| {
        [
            robot.command.as_ref().and_then(|s| s.t_s.last()),
            robot.pose.as_ref().and_then(|s| s.t_s.last()),
            robot.wheels.as_ref().and_then(|s| s.t_s.last()),
        ]
    });
    ends.flatten().copied().fold(0.0, f64::max)
}
