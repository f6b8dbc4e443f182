//! Diagnosis of a machine that is told speeds or nothing: from commands to wheels, from wheels to poses and
//! gyro, and what both say together.

mod beside;
mod machine;
mod task;

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::recording::{Command, Robot};

use self::machine::Machine;
pub(crate) use self::task::{Earlier, Found, Learnt, Task};
use super::bench::Bench;
use super::fitted::Fitted;
use super::open_loop::HORIZON_S;
use super::pictures;
use super::scene::Scene;
use super::search::Searched;
use super::sight;
use crate::data::streams::has_places;
use crate::judge::{Culprit, passing};
use crate::model::command_to_wheels::CommandToWheels;
use crate::model::from_wheels::FromWheels;
use crate::model::streams::Streams;
use crate::model::volts;
use crate::model::wheel_parameters::{LAW_FIRST, RUN_SCALE, RUN_TRACK};

/// Least deviation of scale or track among runs that differ.
const LEAST_SPREAD: f64 = 0.006;

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

impl Machine<'_> {
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
