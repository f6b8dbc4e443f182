//! The filters of a robot, as its baseline was fitted.

use std::sync::Arc;

use slipstream_bus::{EffectSpec, InputError, RobotModel};

use super::bank::{Bank, Source};
use super::changes;
use super::dynamic::Dynamic;
use super::hypotheses::{self, Hypotheses};
use super::kinematic::Kinematic;
use super::learnt::{Learnt, remembers_s};
use crate::data::feed::{Feed, Habits};
use crate::data::wheels::changes_every_s;
use crate::explain::dynamic::baseline::baseline as of_forces;
use crate::explain::dynamic::examine;
use crate::explain::kinematic::{self, Task};
use crate::request::{Request, Runs};

/// The filters of one robot on their way.
#[derive(Default)]
pub(super) struct Filters {
    /// From commands to wheels, from wheels to poses and gyro.
    wheels: Option<Kinematic>,
    /// From torques or voltages to wheels.
    forces: Option<Dynamic>,
    /// How many of the parameters are those of the wheels.
    of_wheels: usize,
}

/// What a baseline says of a robot.
pub(super) struct Prepared {
    /// The model by which rows are read, and the one with everything that the baseline showed.
    pub(super) model: RobotModel,
    pub(super) improved: RobotModel,
    pub(super) filters: Filters,
    pub(super) sources: Vec<Source>,
    pub(super) hypotheses: Hypotheses,
    /// The parameter that is the bias of a gyro.
    pub(super) bias: Option<usize>,
    pub(super) habits: Habits,
}

impl Filters {
    pub(super) fn restart(&mut self) {
        if let Some(own) = &mut self.wheels {
            own.restart();
        }
        if let Some(own) = &mut self.forces {
            own.restart();
        }
    }

    /// From now on the robot has parameters that are off those of the baseline by `shift`; `besides` are what wheels have of
    /// that as effects, so that forces know of it, too. Returns whether filters can follow.
    pub(super) fn move_to(&mut self, shift: &[f64], besides: &[EffectSpec]) -> bool {
        let (of_wheels, of_forces) = shift.split_at(self.of_wheels.min(shift.len()));
        let wheels = self.wheels.as_mut();
        let forces = self.forces.as_mut();
        wheels.is_none_or(|own| own.move_to(of_wheels))
            && forces.is_none_or(|own| own.move_to(of_forces, besides))
    }

    /// Whether a parameter is one of the wheels.
    pub(super) fn is_of_wheels(&self, place: usize) -> bool {
        place < self.of_wheels
    }

    pub(super) fn hear(&mut self, feed: &mut Feed, bank: &mut Bank) {
        if let Some(own) = &mut self.forces {
            own.hear(feed, bank);
        }
        match &mut self.wheels {
            Some(own) => own.hear(feed, bank),
            None => feed.drop_all(),
        }
    }
}

/// Fits the runs of one machine.
///
/// # Errors
/// Runs that say nothing of the robot.
pub(super) fn prepared(
    request: &Request<'_>,
    runs: &Runs<'_>,
    model: &RobotModel,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Prepared, InputError> {
    let mut own = Prepared {
        model: model.clone(),
        improved: model.clone(),
        filters: Filters::default(),
        sources: Vec::new(),
        hypotheses: Hypotheses::default(),
        bias: None,
        habits: Habits::default(),
    };
    let robots: Vec<_> = runs.iter().map(|(_, robot)| *robot).collect();
    let by_forces = !kinematic::applies(&robots, model) && examine::applies(&robots, model);
    let wheels = own.add_wheels(request, runs, by_forces, progress);
    if by_forces {
        own.add_forces(request, runs, progress)?;
    } else {
        wheels?;
    }
    Ok(own)
}

/// A law of motion takes minutes to find, and the forces that a robot is told are none.
const LAW: &str = "motion_law";

impl Prepared {
    fn add_wheels(
        &mut self,
        request: &Request<'_>,
        runs: &Runs<'_>,
        by_forces: bool,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<(), InputError> {
        let mut excluded = request.excluded.to_vec();
        if by_forces {
            excluded.push(LAW.to_owned());
        }
        let baseline = kinematic::baseline(&Task {
            runs,
            model: &self.model,
            excluded: &excluded,
            excluded_s: request.excluded_s,
            progress,
            illustrate: None,
            before: None,
        })?;
        let changes = runs
            .iter()
            .filter_map(|(_, robot)| changes_every_s(robot, &self.model));
        self.habits.changes_every_s = changes.reduce(f64::max);
        self.habits.remembers_s = remembers_s(&baseline);
        self.improved = baseline.model.clone();
        let learnt = Learnt::new(Arc::new(baseline), &[]);
        self.hypotheses = hypotheses::all(&learnt, request.excluded);
        self.bias = learnt.bias();
        let (filter, sources) = Kinematic::new(learnt);
        self.sources = sources;
        self.filters.of_wheels = self.hypotheses.wide.len();
        self.filters.wheels = Some(filter);
        Ok(())
    }

    fn add_forces(
        &mut self,
        request: &Request<'_>,
        runs: &Runs<'_>,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<(), InputError> {
        let baseline = of_forces(request, runs, progress)?;
        self.habits.of_forces = true;
        self.improved.clone_from(&baseline.machine.model);
        let Some((forces, hypotheses)) = changes::of(baseline) else {
            return Ok(());
        };
        let first = self.hypotheses.wide.len();
        let (filter, source) = Dynamic::new(forces, self.sources.len(), first);
        self.sources.push(source);
        self.filters.forces = Some(filter);
        self.hypotheses.extend(hypotheses);
        Ok(())
    }
}
