//! Effects that begin at a time in a run.

use std::collections::VecDeque;

use slipstream_bus::experiment::Begins;
use slipstream_bus::{EffectSpec, Experiment, InputError, RobotModel};

use crate::effects::find;
use crate::{CommandKind, Robot, World};

/// Effects that cannot begin within a run, and what does instead.
const NOT_WITHIN: [(&str, &str); 2] = [
    (
        "link_delay",
        "give link = \"r1 to r2\" and delay_s in place of a robot",
    ),
    (
        "clock_drift",
        "list it in the robot model: a clock that drifts from then on is not simulated",
    ),
];

/// Robots that others are replaced by: when (ns), which one, by what.
#[derive(Debug)]
pub struct Changes(VecDeque<(i64, usize, Robot)>);

impl Changes {
    /// The effects that begin in an experiment.
    ///
    /// # Errors
    /// An effect or parameter that no robot can have.
    pub fn new(experiment: &Experiment) -> Result<Self, InputError> {
        let robots = experiment.robots.iter();
        let mut models: Vec<RobotModel> = robots.map(|own| own.model.clone()).collect();
        let mut all = VecDeque::new();
        for change in experiment.settings.changes_in_time()? {
            let Begins::Effect(robot, effect) = change.what else {
                continue;
            };
            let place = robot as usize;
            let Some(model) = models.get_mut(place) else {
                continue;
            };
            let named = |error: InputError| InputError {
                place: "changes".to_owned(),
                problem: format!(
                    "{}: {} {}",
                    experiment.robots[place].name, error.place, error.problem
                ),
                ..error
            };
            add(model, effect).map_err(named)?;
            let robot = Robot::new(model).map_err(named)?;
            robot.accepts(CommandKind::Torque).map_err(named)?;
            all.push_back((change.at_ns, place, robot));
        }
        Ok(Self(all))
    }

    /// Lets those begin that are due at the time of `world`.
    pub fn apply(&mut self, world: &mut World) {
        while let Some((_, robot, by)) = self.0.pop_front_if(|own| own.0 <= world.time_ns()) {
            world.replace(robot, by);
        }
    }
}

/// Adds an effect to a model, or gives it other numbers.
fn add(model: &mut RobotModel, effect: EffectSpec) -> Result<(), InputError> {
    if let Some((id, remedy)) = NOT_WITHIN.iter().find(|own| own.0 == effect.effect) {
        let place = format!("effects.{id}");
        return Err(InputError::new(place, "cannot begin within a run", *remedy));
    }
    let repeats = find(&effect.effect).is_some_and(|info| info.repeats);
    let known = model
        .effects
        .iter_mut()
        .find(|own| own.effect == effect.effect);
    match known {
        Some(own) if !repeats => *own = effect,
        _ => model.effects.push(effect),
    }
    Ok(())
}
