//! Diagnosis of a machine that is told speeds or nothing: from commands to wheels, from wheels to poses and
//! gyro, and what both say together.

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Robot};

use super::bench::{Bench, Measured, ORDINARY};
use super::claim::Claim;
use super::fitted::Fitted;
use super::links::Course;
use super::naming::Naming;
use super::open_loop::HORIZON_S;
use super::pictures;
use super::scene::Scene;
use super::search::{Search, Searched};
use super::sight;
use super::today::of_today;
use crate::answer::{Budget, Detectable, Figures, HeldOut, Outliers, ProcessNoise, Warning};
use crate::data::reference::POSE_STEP_S;
use crate::data::streams::has_places;
use crate::judge::{Culprit, Predictions, QUANTITIES, Score, passing};
use crate::model::command_to_wheels::{CommandToWheels, NOISE};
use crate::model::comparison::Before;
use crate::model::drive::{DRIVE, SLOW_SHARE};
use crate::model::from_wheels::{COMMON, FromWheels, LAW_FIRST, RUN_SCALE, RUN_TRACK, TRACK};
use crate::model::streams::Streams;
use crate::model::view::View;
use crate::model::volts::{self, Load};

/// Least deviation of scale or track among runs that differ.
const LEAST_SPREAD: f64 = 0.006;
/// Slow share of the response of a drive from before that has none: at 0 it has no derivative by its time.
const LEAST_SLOW: f64 = 1e-3;
/// What two simulators differ by, in metres or radians; a smaller part is none.
const NOTHING: f64 = 1e-6;

/// What was found on one machine.
pub(crate) struct Found {
    pub(crate) claims: Vec<Claim>,
    pub(crate) held_out: HeldOut,
    pub(crate) predictions: Predictions,
    pub(crate) detectable: Vec<Detectable>,
    pub(crate) budget: Vec<Budget>,
    pub(crate) outliers: Vec<Outliers>,
    pub(crate) process_noise: Vec<ProcessNoise>,
    pub(crate) warnings: Vec<Warning>,
    pub(crate) improved: RobotModel,
    /// Begin and end of each run (s).
    pub(crate) spans_s: Vec<[f64; 2]>,
    /// What a report shows, where it is asked for.
    pub(crate) figures: Option<Figures>,
    /// Where each run went, as the filter has it.
    pub(crate) courses: Vec<Course>,
    /// Number of each run's robot among those given.
    pub(crate) robots: Vec<usize>,
}

/// One machine, and what was fitted to it.
struct Machine<'a> {
    name: &'a str,
    robots: Vec<&'a Robot>,
    model: &'a RobotModel,
    excluded: &'a [String],
    machine: FromWheels,
    drive: Option<CommandToWheels>,
    /// The same with runs from before, where today is compared with them.
    joint: Option<FromWheels>,
    joint_drive: Option<CommandToWheels>,
}

/// What was fitted to a machine: to its runs of today, and beside those from before.
struct Fits {
    today: Searched,
    all: Option<Searched>,
}

/// What is asked of a machine.
pub(crate) struct Task<'a> {
    pub(crate) runs: &'a [(&'a Recording, &'a Robot)],
    pub(crate) model: &'a RobotModel,
    pub(crate) excluded: &'a [String],
    pub(crate) excluded_s: &'a [[f64; 2]],
    pub(crate) progress: &'a dyn Fn(&str),
    /// Number of the first finding, if figures are asked for.
    pub(crate) illustrate: Option<usize>,
    /// What it is compared with; `model` is then that of before.
    pub(crate) before: Option<Earlier<'a>>,
}

/// Runs from before, and what was learnt of them.
#[derive(Clone, Copy)]
pub(crate) struct Earlier<'a> {
    pub(crate) runs: &'a [(&'a Recording, &'a Robot)],
    pub(crate) learnt: &'a Learnt,
}

/// What runs from before say of a machine.
pub(crate) struct Learnt {
    /// The model with everything that it lacked.
    pub(crate) model: RobotModel,
    pub(crate) claims: Vec<Claim>,
    /// Deviations of scale and track among the runs, where they differ.
    pub(crate) spread: [Option<f64>; 2],
    /// Scale and track of each run beside those of the model (logarithms).
    pub(crate) offsets: Vec<[f64; 2]>,
    /// What the filters read of the machine as it was fitted, but for laws.
    pub(crate) at: Vec<f64>,
    /// The same of its drive, with its noise.
    pub(crate) drive: Option<Vec<f64>>,
    /// What is left of its own predictions with that model.
    pub(crate) errors: Score,
}

/// Diagnoses one machine.
///
/// # Errors
/// A machine that is not known to have moved, or of which nothing can be compared.
pub(crate) fn examine(task: &Task<'_>) -> Result<Found, InputError> {
    let (mut found, refused) = passing(task.excluded, task.progress, |excluded| {
        let own = Task { excluded, ..*task };
        Ok(Machine::new(&own)?.examine(&own))
    })?;
    found.predictions.refused = refused;
    Ok(found)
}

/// What the runs of one machine say of it, to compare others with.
///
/// # Errors
/// As [`examine`].
pub(crate) fn learn(task: &Task<'_>) -> Result<Learnt, InputError> {
    let mut machine = Machine::new(task)?;
    let fits = machine.fits(task, &mut Vec::new());
    let (claims, _) = machine.claims(&fits);
    let own = machine.fitted(&fits.today);
    let at = &fits.today.selected.fit.at;
    let fitted = own.machine_at(at);
    let drive = own.drive_at(at);
    let by_run = fits.today.by_run;
    let kinds = [RUN_SCALE, RUN_TRACK].into_iter().zip(by_run);
    let spread = kinds.map(|(parameter, differs)| {
        let runs = 0..machine.machine.runs.len();
        let all = runs.map(|run| fitted[machine.machine.of_run(run, parameter)]);
        differs.then(|| deviation(&all.collect::<Vec<_>>()))
    });
    let spread: Vec<Option<f64>> = spread.collect();
    let model = machine.improved(&claims);
    let errors = {
        let measured = machine.measured(&fits);
        let bench = Bench::new(&measured, &claims);
        bench.predictions(&bench.errors()).after()
    };
    Ok(Learnt {
        errors,
        offsets: machine.offsets(&fitted, &model),
        model,
        spread: [spread[0], spread[1]],
        at: fitted[..LAW_FIRST].to_vec(),
        drive,
        claims,
    })
}

/// A machine as it was fitted to recordings, for whoever watches it go on.
pub(crate) struct Baseline {
    pub(crate) machine: FromWheels,
    pub(crate) drive: Option<CommandToWheels>,
    pub(crate) found: Searched,
    /// The model with everything that it lacked.
    pub(crate) model: RobotModel,
}

impl Baseline {
    /// What was fitted.
    pub(crate) fn fitted(&self) -> Fitted<'_> {
        Fitted {
            streams: Streams {
                reference: &self.machine,
                drive: self.drive.as_ref(),
            },
            found: &self.found,
        }
    }
}

/// Fits one machine.
///
/// # Errors
/// As [`examine`].
pub(crate) fn baseline(task: &Task<'_>) -> Result<Baseline, InputError> {
    let mut machine = Machine::new(task)?;
    let fits = machine.fits(task, &mut Vec::new());
    let (claims, _) = machine.claims(&fits);
    let model = machine.improved(&claims);
    Ok(Baseline {
        machine: machine.machine,
        drive: machine.drive,
        found: fits.today,
        model,
    })
}

/// Standard deviation of numbers, and no less than what nobody would call a difference.
fn deviation(all: &[f64]) -> f64 {
    let count = all.len() as f64;
    let mean = all.iter().sum::<f64>() / count;
    let squares: f64 = all.iter().map(|x| (x - mean) * (x - mean)).sum();
    (squares / (count - 1.0).max(1.0)).sqrt().max(LEAST_SPREAD)
}

impl<'a> Machine<'a> {
    fn new(task: &'a Task<'_>) -> Result<Self, InputError> {
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

    fn streams(&self) -> Streams<'_> {
        Streams {
            reference: &self.machine,
            drive: self.drive.as_ref(),
        }
    }

    fn fitted<'b>(&'b self, found: &'b Searched) -> Fitted<'b> {
        Fitted {
            streams: self.streams(),
            found,
        }
    }

    /// What the streams need; or what changed since runs from before.
    fn fits(&mut self, task: &Task<'_>, warnings: &mut Vec<Warning>) -> Fits {
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
    fn claims(&self, fits: &Fits) -> (Vec<Claim>, Vec<Claim>) {
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
    fn offsets(&self, fitted: &[f64], model: &RobotModel) -> Vec<[f64; 2]> {
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
    fn measured<'b>(&'b self, fits: &'b Fits) -> Measured<'b> {
        Measured {
            name: self.name,
            robots: &self.robots,
            fitted: self.fitted(&fits.today),
        }
    }

    /// What is found; or by which effect it predicts worse than the nominal model.
    fn examine(mut self, task: &Task<'_>) -> Result<Found, Culprit> {
        let mut warnings = Vec::new();
        let fits = self.fits(task, &mut warnings);
        let (mut claims, odd) = self.claims(&fits);
        warnings.extend(self.not_constant(task, &claims));
        if task.before.is_some() {
            // a change is one that both halves tell
            claims.retain(|claim| !claim.is_disputed());
        }
        warnings.extend(odd.iter().map(|claim| self.implausible(task, claim)));
        (task.progress)("predicting 5 s ahead, with and without the findings");
        let measured = self.measured(&fits);
        let bench = Bench::new(&measured, &claims);
        let errors = bench.errors();
        let mut predictions = bench.predictions(&errors);
        if let Some(earlier) = &task.before {
            predictions.expect_as(&earlier.learnt.errors, !claims.is_empty());
        }
        let is_paired = self
            .joint
            .as_ref()
            .is_some_and(|joint| joint.before.is_paired());
        // a change between rows of one course is known far below what either recording is predicted to
        if !is_paired && let Some(culprit) = predictions.culprit(|| bench.worth()) {
            return Err(culprit);
        }
        let figures = task.illustrate.map(|first_finding| {
            (task.progress)("computing what the page shows");
            pictures::figures(&Scene {
                robot: self.name,
                machine: &self.machine,
                predictors: (0..self.machine.runs.len())
                    .map(|run| bench.predictor(run))
                    .collect(),
                own: measured.fitted,
                all: self.of_all(&fits),
                at: bench.found_at(),
                claims: &claims,
                first_finding,
                nominal: &bench.nominal,
                with_all: &bench.found,
                errors: &errors,
                deviations: &bench.deviations,
                nominal_of: &|claim, name| claim.nominal(self.model, name),
            })
        });
        Ok(Found {
            figures,
            detectable: sight::detectable(self.name, &self.of_all(&fits)),
            held_out: predictions.held_out(HORIZON_S, &|channel| bench.unit(channel)),
            budget: predictions.budgets(&bench.worth()),
            predictions,
            outliers: self.outliers(&bench.all),
            process_noise: self.process_noise(&bench.all),
            improved: self.loaded(self.improved(&claims), &fits),
            spans_s: self
                .machine
                .runs
                .iter()
                .map(|run| run.blocks.span_s.map(|t| t + run.origin_s))
                .collect(),
            courses: self.courses(&bench.all, &bench.deviations),
            robots: self.machine.runs.iter().map(|run| run.robot).collect(),
            claims,
            warnings,
        })
    }

    /// The fit of all runs, those from before among them.
    fn of_all<'b>(&'b self, fits: &'b Fits) -> Fitted<'b> {
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

    /// What is taken for a constant and differs between the halves of the recordings.
    fn not_constant(&self, task: &Task<'_>, claims: &[Claim]) -> Vec<Warning> {
        let values = claims.iter().flat_map(|claim| {
            let own = claim.values.iter();
            own.filter_map(move |value| Some((claim, value, value.halves?)))
        });
        let each = values.map(|(claim, value, halves)| {
            let nominal = claim.nominal(self.model, value.name);
            let [first, second] = halves.map(|change| value.applied(nominal, change));
            let effect = claim.effect.replace('_', " ");
            let what = format!(
                "{effect}, {}: {first:.4} in the first half, {second:.4} in the second; it is not constant, and its \
                 interval holds both",
                value.name
            );
            let remedy = "diagnose the halves by themselves with --exclude-time, and look what else changed";
            self.warning(task, "not_constant", &what, remedy)
        });
        each.collect()
    }

    /// What fits best and is no physics.
    fn implausible(&self, task: &Task<'_>, claim: &Claim) -> Warning {
        let run = claim.runs.as_ref().and_then(|runs| runs.first());
        let of = run.map_or(String::new(), |run| {
            let robot = self.robots[self.machine.runs[*run].robot];
            format!(" in run {}", robot.name)
        });
        let values = claim.values.iter();
        let values: Vec<String> = values
            .map(|value| {
                let nominal = claim.nominal(self.model, value.name);
                format!("{} {:.3}", value.name, value.estimate(nominal))
            })
            .collect();
        let statement = format!(
            "what would fit best{of} is {} with {}, which no robot has: wheels and reference hardly \
             follow each other",
            claim.effect.replace('_', " "),
            values.join(", "),
        );
        let remedy =
            "look whether the wheels slip all the time, and whether both streams share a clock";
        self.warning(task, "implausible", &statement, remedy)
    }

    fn warning(&self, task: &Task<'_>, id: &str, statement: &str, remedy: &str) -> Warning {
        Warning {
            recording: task.runs[0].0.name.clone(),
            robot: Some(self.name.to_owned()),
            id: id.to_owned(),
            statement: statement.to_owned(),
            remedy: remedy.to_owned(),
        }
    }

    fn courses(&self, fitted: &[f64], deviations: &[[f64; QUANTITIES]]) -> Vec<Course> {
        let runs = self.machine.runs.iter().enumerate();
        let with_pose = runs.filter(|(_, run)| run.pose.is_some());
        with_pose
            .map(|(i, _)| {
                let deviation = [deviations[i][2], deviations[i][3], deviations[i][4]];
                let points = self.machine.course(i, fitted);
                Course::of(self.name.to_owned(), points, deviation)
            })
            .collect()
    }

    fn outliers(&self, fitted: &[f64]) -> Vec<Outliers> {
        let view = View {
            machine: &self.machine,
            robust: true,
        };
        let mut outliers: Vec<Outliers> = Vec::new();
        for (stream, times_s) in view.extraordinary(fitted, ORDINARY) {
            if !times_s.is_empty() {
                outliers.push(Outliers {
                    robot: self.name.to_owned(),
                    stream,
                    count: times_s.len(),
                    times_s,
                });
            }
        }
        outliers
    }

    fn process_noise(&self, fitted: &[f64]) -> Vec<ProcessNoise> {
        if !self.machine.has_pose() && !self.machine.has_gyro() {
            return Vec::new();
        }
        let [speed, turn] = self.machine.process_noise(fitted);
        let all = [("speed", speed, "m/s"), ("turn_rate", turn, "rad/s")];
        all.into_iter()
            .filter(|(_, size, _)| *size > NOTHING)
            .map(|(acts_on, size, unit)| ProcessNoise {
                robot: self.name.to_owned(),
                acts_on,
                size,
                unit,
                correlation_time_s: POSE_STEP_S,
            })
            .collect()
    }

    /// `model` with the masses that the motors move; those of the model stay where a slope is told by them.
    fn loaded(&self, mut model: RobotModel, fits: &Fits) -> RobotModel {
        let is_level = model.number("floor_slope", "grade").is_none();
        let share = self.fitted(&fits.today).share();
        if let Some(share) = share.filter(|_| is_level) {
            Load::apply(share, &mut model);
        }
        model
    }

    /// The model with what was found; what differs from run to run as on average.
    fn improved(&self, claims: &[Claim]) -> RobotModel {
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

/// Whether this engine diagnoses a machine: what drives it are speeds, whatever its masses; or voltages of a robot whose
/// masses are unknown, or of which no place is.
pub(crate) fn applies(robots: &[&Robot], model: &RobotModel) -> bool {
    robots.iter().all(|robot| match &robot.command {
        None => true,
        Some(stream) => match stream.values {
            Command::Twist { .. } | Command::WheelSpeed { .. } => true,
            Command::Voltage { .. } => volts::applies(model, has_places(robot)),
            Command::Torque { .. } => false,
        },
    })
}
