//! What changed since recordings from before: which machine is compared with which, and a finding as a
//! change.

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Robot as Recorded, Wheels};

use super::claim::{Claim, Value};
use super::finding::since;
use super::kinematic::{self, Learnt, Task};
use crate::answer::{Finding, Warning};
use crate::request::{Request, Runs, model_of};

/// Lengths of two models that differ by less are the same.
const SAME: f64 = 1e-6;

/// The runs from before that these are compared with, of a robot of the same name, or the only machine where
/// there is one on both sides (`is_alone`); `None` without any recording from before.
///
/// # Errors
/// No such robot in the recordings from before, or one that cannot be the same machine.
pub(crate) fn counterpart<'a, 'b>(
    request: &Request<'_>,
    today: &Runs<'_>,
    is_alone: bool,
    others: &'b [Vec<(&'a Recording, &'a Recorded)>],
) -> Result<Option<&'b Runs<'a>>, InputError> {
    if request.against.is_empty() {
        return Ok(None);
    }
    let (_, robot) = today[0];
    let named = others.iter().find(|own| own[0].1.name == robot.name);
    let other = match (named, others) {
        (Some(own), _) => own,
        (None, [own]) if is_alone => own,
        _ => {
            let problem = format!("is not in {}", names(request.against));
            let remedy = "compare recordings of one machine, its robot called the same in all";
            return Err(InputError::new(&robot.name, problem, remedy));
        }
    };
    same_machine(request, today, other)?;
    comparable(today, other)?;
    Ok(Some(other))
}

fn names(recordings: &[Recording]) -> String {
    let names: Vec<&str> = recordings.iter().map(|own| own.name.as_str()).collect();
    names.join(", ")
}

/// Whether both are the same machine, by their models.
fn same_machine(
    request: &Request<'_>,
    today: &Runs<'_>,
    other: &Runs<'_>,
) -> Result<(), InputError> {
    let [own, before] = [model_of(request, today[0])?, model_of(request, other[0])?];
    let [own, before] = [&own.robot, &before.robot];
    let lengths = [
        ("wheel_radius_m", own.wheel_radius_m, before.wheel_radius_m),
        ("half_track_m", own.half_track_m, before.half_track_m),
    ];
    for (name, now, then) in lengths {
        if (now - then).abs() > SAME * now.abs() {
            let problem = format!(
                "is another machine: {name} = {now}, and {then} in the recording from before"
            );
            let remedy = "compare recordings of one machine, or give its one model with --robot";
            return Err(InputError::new(&today[0].1.name, problem, remedy));
        }
    }
    Ok(())
}

/// What a run is told, and how its wheels were recorded.
fn kind(robot: &Recorded) -> [&'static str; 2] {
    let told = match robot.command.as_ref().map(|own| &own.values) {
        None => "nothing",
        Some(Command::Torque { .. }) => "torques",
        Some(Command::Voltage { .. }) => "voltages",
        Some(_) => "speeds",
    };
    let wheels = match robot.wheels.as_ref().map(|own| &own.values) {
        None => "not at all",
        Some(Wheels::Speed { .. }) => "as speeds",
        Some(_) => "as angles or ticks",
    };
    [told, wheels]
}

/// What can be compared of a run: its drive, its pose, its gyro.
fn channels(robot: &Recorded) -> [bool; 3] {
    let [wheels, driven] = [robot.wheels.is_some(), robot.command.is_some()];
    let moves = wheels || driven;
    [
        wheels && driven,
        robot.pose.is_some() && moves,
        robot.imu.is_some() && moves,
    ]
}

fn comparable(today: &Runs<'_>, other: &Runs<'_>) -> Result<(), InputError> {
    let place = &today[0].1.name;
    let remedy = "compare recordings that were made in the same way";
    let whats = ["is told", "has its wheels recorded"].into_iter();
    for ((what, now), then) in whats.zip(kind(today[0].1)).zip(kind(other[0].1)) {
        if now != then {
            let problem = format!("{what} {now}, and {then} in the recording from before");
            return Err(InputError::new(place, problem, remedy));
        }
    }
    let has = |runs: &Runs<'_>, i: usize| runs.iter().any(|(_, robot)| channels(robot)[i]);
    if !(0..3).any(|i| has(today, i) && has(other, i)) {
        let problem =
            "shares no pose, gyro, or commands with wheels with the recording from before";
        return Err(InputError::new(place, problem, remedy));
    }
    Ok(())
}

/// Streams that only one side has: what they show cannot be compared.
pub(crate) fn not_compared(today: &Runs<'_>, other: &Runs<'_>) -> Vec<Warning> {
    let has = |runs: &Runs<'_>| {
        let any = |stream: fn(&Recorded) -> bool| runs.iter().any(|own| stream(own.1));
        [
            any(|robot| robot.pose.is_some()),
            any(|robot| robot.imu.is_some()),
        ]
    };
    let streams = ["pose", "gyro"].into_iter().zip(has(today)).zip(has(other));
    let apart = streams.filter(|((_, now), then)| now != then);
    apart
        .map(|((name, now), _)| Warning {
            recording: today[0].0.name.clone(),
            robot: Some(today[0].1.name.clone()),
            id: "not_compared".to_owned(),
            statement: if now {
                format!("the recording from before has no {name}: what it shows is not compared")
            } else {
                format!("this recording has no {name}: what that of before shows is not compared")
            },
            remedy: format!("record the {name} in both"),
        })
        .collect()
}

/// What the runs from before say of a machine that is told speeds or nothing.
///
/// # Errors
/// As [`kinematic::examine`].
pub(crate) fn learn(
    request: &Request<'_>,
    runs: &Runs<'_>,
    model: &RobotModel,
) -> Result<Learnt, InputError> {
    let name = &runs[0].0.name;
    let progress = |what: &str| (request.progress)(&format!("{name}, from before: {what}"));
    kinematic::learn(&Task {
        runs,
        model,
        excluded: request.excluded,
        excluded_s: &[],
        progress: &progress,
        illustrate: None,
        before: None,
    })
}

/// Makes the finding of a claim one of what changed.
pub(crate) fn compared(finding: &mut Finding, claim: &Claim, learnt: &Learnt, before: &str) {
    let same =
        |own: &&Claim| own.effect == claim.effect && own.word == claim.word && own.runs.is_none();
    let known = learnt.claims.iter().find(same);
    since(finding, before, |parameter| {
        let value = known?
            .values
            .iter()
            .find(|own| own.name == parameter.name)?;
        let nominal = parameter.nominal?;
        let as_before = Value {
            change: 0.0,
            ..value.clone()
        };
        Some(as_before.interval(Some(nominal)))
    });
}
