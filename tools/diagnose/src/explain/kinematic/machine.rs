//! One machine and the fits to its streams: what is compared, what the search finds, and the model with it.

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::recording::Robot;

use super::task::{Earlier, Task};
use crate::answer::Warning;
use crate::explain::bench::Measured;
use crate::explain::claim::Claim;
use crate::explain::fitted::Fitted;
use crate::explain::naming::Naming;
use crate::explain::search::{Search, Searched};
use crate::explain::today::of_today;
use crate::model::command_to_wheels::{CommandToWheels, NOISE};
use crate::model::comparison::Before;
use crate::model::drive::{DRIVE, SLOW_SHARE};
use crate::model::from_wheels::FromWheels;
use crate::model::streams::Streams;
use crate::model::volts::Load;
use crate::model::wheel_parameters::{COMMON, LAW_FIRST, RUN_SCALE, RUN_TRACK, TRACK};

/// Slow share of the response of a drive from before that has none: at 0 it has no derivative by its time.
const LEAST_SLOW: f64 = 1e-3;

/// One machine, and what was fitted to it.
pub(super) struct Machine<'a> {
    pub(super) name: &'a str,
    pub(super) robots: Vec<&'a Robot>,
    pub(super) model: &'a RobotModel,
    pub(super) excluded: &'a [String],
    pub(super) machine: FromWheels,
    pub(super) drive: Option<CommandToWheels>,
    /// The same with runs from before, where today is compared with them.
    pub(super) joint: Option<FromWheels>,
    pub(super) joint_drive: Option<CommandToWheels>,
}

/// What was fitted to a machine: to its runs of today, and beside those from before.
pub(super) struct Fits {
    pub(super) today: Searched,
    pub(super) all: Option<Searched>,
}

impl<'a> Machine<'a> {
    pub(super) fn new(task: &'a Task<'_>) -> Result<Self, InputError> {
        let robots: Vec<&Robot> = task.runs.iter().map(|(_, robot)| *robot).collect();
        let name = &robots[0].name;
        let drive = CommandToWheels::new(&robots, task.model, task.excluded_s);
        let mut machine = FromWheels::new(&robots, task.model, task.excluded_s);
        let (mut joint, mut joint_drive) = (None, None);
        if let Some(earlier) = task.before {
            let before: Vec<&Robot> = earlier.runs.iter().map(|(_, robot)| *robot).collect();
            let all = [before.as_slice(), robots.as_slice()].concat();
            let count = before.len();
            joint = FromWheels::new(&all, task.model, task.excluded_s);
            joint_drive = CommandToWheels::new(&all, task.model, task.excluded_s);
            if let Some(joint) = &mut joint {
                let earlier_runs = joint.runs.iter().filter(|run| run.robot < count);
                joint.compare(
                    Before {
                        runs: earlier_runs.count(),
                        robots: count,
                        spread: earlier.learnt.spread,
                        clusters: None,
                        stamped: Default::default(),
                    },
                    &all,
                );
                let mut today = joint.today();
                if joint.before.is_paired() && earlier.learnt.spread != [None; 2] {
                    today.offsets.clone_from(&earlier.learnt.offsets);
                }
                machine = Some(today).filter(|today| !today.runs.is_empty());
            }
            if let Some(joint) = &mut joint_drive {
                joint.compare(count, &all);
            }
            let both = |before: usize, all: usize| before > 0 && before < all;
            joint = joint.filter(|own| both(own.before.runs, own.runs.len()));
            joint_drive = joint_drive.filter(|own| both(own.before.runs, own.runs.len()));
            if joint.is_none() && joint_drive.is_none() {
                let problem = "cannot be compared: in one of the recordings it hardly moves, or no stream can be used";
                let remedy = "compare recordings in which it drives some metres with turns";
                return Err(InputError::new(name, problem, remedy));
            }
        }
        let machine = machine.filter(|m| m.has_pose() || m.has_gyro() || drive.is_some());
        let machine = machine.ok_or_else(|| {
            let remedy = "record wheels or commands of a robot that drives, and beside them a pose, a \
                gyro, or both wheels and commands";
            InputError::new(name, "has nothing to compare", remedy)
        })?;
        Ok(Machine {
            name,
            robots,
            model: task.model,
            excluded: task.excluded,
            machine,
            drive,
            joint,
            joint_drive,
        })
    }

    pub(super) fn streams(&self) -> Streams<'_> {
        Streams {
            reference: &self.machine,
            drive: self.drive.as_ref(),
        }
    }

    pub(super) fn fitted<'b>(&'b self, found: &'b Searched) -> Fitted<'b> {
        Fitted {
            streams: self.streams(),
            found,
        }
    }

    /// What the streams need; or what changed since runs from before.
    pub(super) fn fits(&mut self, task: &Task<'_>, warnings: &mut Vec<Warning>) -> Fits {
        let hear = |what: &str| (task.progress)(&format!("fitting with {what}"));
        (task.progress)("comparing commands, wheels, pose and gyro");
        let excluded = task.excluded;
        let found = match (task.before, &self.joint) {
            (Some(earlier), Some(joint)) => {
                let streams = Streams {
                    reference: joint,
                    drive: self.joint_drive.as_ref(),
                };
                let nominal = self.of_before(streams, &earlier);
                let mut all = Search {
                    streams,
                    nominal: &nominal,
                    excluded,
                    hear: &hear,
                }
                .run();
                if let Some(dense) = all.dense.take() {
                    self.machine = dense.today();
                    self.joint = Some(dense);
                }
                let nominal = self.streams().nominal(self.model);
                let today = of_today(&all, self.streams(), nominal, excluded);
                Fits {
                    today,
                    all: Some(all),
                }
            }
            _ => {
                let nominal = self.streams().nominal(self.model);
                let mut today = Search {
                    streams: self.streams(),
                    nominal: &nominal,
                    excluded,
                    hear: &hear,
                }
                .run();
                if let Some(dense) = today.dense.take() {
                    self.machine = dense;
                }
                Fits { today, all: None }
            }
        };
        if found.today.is_undetermined {
            warnings.push(self.warning(
                task,
                "not_fitted",
                "the streams do not determine what they are compared by",
                "record a run with turns both ways and some metres of way",
            ));
        }
        if !found.today.selected.fit.converged {
            warnings.push(self.warning(
                task,
                "unfinished",
                "a fit did not come to its end: sizes may be off",
                "put what was found into the model with --improved and diagnose again",
            ));
        }
        found
    }

    /// What the filters read of all runs where nothing changed.
    fn of_before(&self, streams: Streams<'_>, earlier: &Earlier<'_>) -> Vec<f64> {
        let mut nominal = streams.nominal(self.model);
        if streams.reference.before.any() {
            let shared = streams.reference.shared(0);
            nominal[shared..shared + LAW_FIRST].copy_from_slice(&earlier.learnt.at[..LAW_FIRST]);
        }
        let known = earlier.learnt.drive.as_ref();
        if let (Some(_), Some(known)) = (streams.drive, known) {
            let own = &mut nominal[streams.drive_first()..];
            let base = CommandToWheels::shared(0);
            own[base..base + DRIVE].copy_from_slice(&known[..DRIVE]);
            own[DRIVE..DRIVE + NOISE].copy_from_slice(&known[DRIVE..DRIVE + NOISE]);
            let slow = &mut own[CommandToWheels::shared(SLOW_SHARE)];
            if *slow == 0.0 {
                *slow = LEAST_SLOW;
            }
        }
        nominal
    }

    /// What was found: what is plausible, and what is not.
    pub(super) fn claims(&self, fits: &Fits) -> (Vec<Claim>, Vec<Claim>) {
        let is_excluded = |claim: &Claim| self.excluded.iter().any(|own| own == claim.effect);
        let naming = Naming {
            found: &fits.today,
            streams: self.streams(),
            compares: fits.all.is_some(),
        };
        let all = naming.claims().into_iter();
        let all = all.filter(|claim| !is_excluded(claim));
        all.partition(|claim| claim.is_plausible(self.model))
    }
}

impl Machine<'_> {
    /// Scale and track of each run beside those of `model` (logarithms).
    pub(super) fn offsets(&self, fitted: &[f64], model: &RobotModel) -> Vec<[f64; 2]> {
        let nominal = self.machine.nominal(model);
        let pairs = [(COMMON, RUN_SCALE), (TRACK, RUN_TRACK)];
        let of = |at: &[f64], run: usize| {
            pairs.map(|(all, own)| at[all] + at[self.machine.of_run(run, own)])
        };
        let each = (0..self.machine.runs.len()).map(|run| {
            let [own, known] = [of(fitted, run), of(&nominal, run)];
            [own[0] - known[0], own[1] - known[1]]
        });
        each.collect()
    }

    /// What predictions are made by.
    pub(super) fn measured<'b>(&'b self, fits: &'b Fits) -> Measured<'b> {
        Measured {
            name: self.name,
            robots: &self.robots,
            fitted: self.fitted(&fits.today),
        }
    }

    /// The fit of all runs, those from before among them.
    pub(super) fn of_all<'b>(&'b self, fits: &'b Fits) -> Fitted<'b> {
        match (&fits.all, &self.joint) {
            (Some(found), Some(reference)) => Fitted {
                streams: Streams {
                    reference,
                    drive: self.joint_drive.as_ref(),
                },
                found,
            },
            _ => self.fitted(&fits.today),
        }
    }

    pub(super) fn warning(
        &self,
        task: &Task<'_>,
        id: &str,
        statement: &str,
        remedy: &str,
    ) -> Warning {
        Warning {
            recording: task.runs[0].0.name.clone(),
            robot: Some(self.name.to_owned()),
            id: id.to_owned(),
            statement: statement.to_owned(),
            remedy: remedy.to_owned(),
        }
    }

    /// `model` with the masses that the motors move; those of the model stay where a slope is told by them.
    pub(super) fn loaded(&self, mut model: RobotModel, fits: &Fits) -> RobotModel {
        let is_level = model.number("floor_slope", "grade").is_none();
        let share = self.fitted(&fits.today).share();
        if let Some(share) = share.filter(|_| is_level) {
            Load::apply(share, &mut model);
        }
        model
    }

    /// The model with what was found; what differs from run to run as on average.
    pub(super) fn improved(&self, claims: &[Claim]) -> RobotModel {
        let mut model = self.model.clone();
        let mut written: Vec<&str> = Vec::new();
        for claim in claims {
            if claim.runs.is_none() {
                claim.write(&mut model);
            } else if !written.contains(&claim.effect) {
                written.push(claim.effect);
                let own: Vec<&Claim> = claims
                    .iter()
                    .filter(|other| other.effect == claim.effect)
                    .collect();
                mean(&own, self.machine.runs.len()).write(&mut model);
            }
        }
        model
    }
}

/// The mean of claims of single runs over all `runs`; a run without a claim counts as nominal.
fn mean(claims: &[&Claim], runs: usize) -> Claim {
    let mut mean = claims[0].clone();
    for value in &mut mean.values {
        let changes = claims.iter().flat_map(|claim| &claim.values);
        let own = changes.filter(|other| other.name == value.name);
        value.change = own.map(|other| other.change).sum::<f64>() / runs as f64;
        value.before = 0.0;
    }
    mean
}
