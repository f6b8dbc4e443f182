//! One recording: its diagnosis, and its prediction by the nominal, the intermediate and the improved model.

use slipstream_answer::Answer;
use slipstream_bus::RobotModel;
use slipstream_diagnose::{InputError, Prediction, Request, diagnose, predict};
use slipstream_recording::Recording;

/// Diagnosis of recordings of one or several machines.
pub(crate) struct Found {
    pub(crate) answer: Answer,
    /// Improved model of each machine.
    pub(crate) models: Vec<(String, RobotModel)>,
}

impl Found {
    /// Diagnoses `recordings` without the times `excluded_s`, by their own models.
    pub(crate) fn new(
        recordings: &[Recording],
        excluded_s: &[[f64; 2]],
    ) -> Result<Self, InputError> {
        let (answer, models) = diagnose(&Request {
            against: &[],
            recordings,
            model_of: &|_| None,
            excluded: &[],
            excluded_s,
            progress: &|_| (),
        })?;
        Ok(Self { answer, models })
    }

    /// The model of a machine that is not told from others, or of the one called so.
    pub(crate) fn model_of(&self, robot: &str) -> Option<&RobotModel> {
        let named = self.models.iter().find(|(name, _)| name == robot);
        named.or(self.models.first()).map(|(_, model)| model)
    }
}

/// How a recording's robots are predicted by the models that `model_of` gives, without the times
/// `excluded_s`.
pub(crate) fn predicted(
    recording: &Recording,
    model_of: &dyn Fn(&str) -> Option<RobotModel>,
    excluded_s: &[[f64; 2]],
) -> Result<Vec<Prediction>, InputError> {
    predict(&Request {
        against: &[],
        recordings: std::slice::from_ref(recording),
        model_of,
        excluded: &[],
        excluded_s,
        progress: &|_| (),
    })
}

/// One model on the way from the nominal to the improved one, and its predictions.
pub(crate) struct Step {
    pub(crate) robot: String,
    /// What was added last; none for the nominal model.
    pub(crate) added: Option<String>,
    pub(crate) prediction: Prediction,
}

/// A recording and what came of it.
pub(crate) struct Study<'a> {
    pub(crate) recording: &'a Recording,
    pub(crate) found: Found,
    /// Robot after robot, from the nominal model on.
    pub(crate) steps: Vec<Step>,
}

impl<'a> Study<'a> {
    pub(crate) fn new(recording: &'a Recording) -> Result<Self, InputError> {
        let found = Found::new(std::slice::from_ref(recording), &[])?;
        let own = recording.model.as_ref().map_or(0, |m| m.effects.len());
        let longest = found.models.iter().map(|(_, m)| m.effects.len()).max();
        let mut rounds = Vec::new();
        for count in own..=longest.unwrap_or(own) {
            let first = |robot: &str| found.model_of(robot).map(|model| first(model, count));
            rounds.push(predicted(recording, &first, &[])?);
        }
        let mut steps = Vec::new();
        for (i, robot) in recording.robots.iter().enumerate() {
            let effects = found.model_of(&robot.name).map_or(0, |m| m.effects.len());
            for (round, predictions) in rounds.iter().enumerate().take(effects + 1 - own) {
                let added = (round > 0).then(|| {
                    let model = found.model_of(&robot.name);
                    model.map_or(String::new(), |m| m.effects[own + round - 1].effect.clone())
                });
                steps.push(Step {
                    robot: robot.name.clone(),
                    added,
                    prediction: predictions[i].clone(),
                });
            }
        }
        Ok(Self {
            recording,
            found,
            steps,
        })
    }

    /// The first and the last model of a robot, predicted.
    pub(crate) fn ends(&self, robot: &str) -> Option<[&Prediction; 2]> {
        let mut own = self.steps.iter().filter(|step| step.robot == robot);
        let first = own.next()?;
        Some([
            &first.prediction,
            &own.next_back().unwrap_or(first).prediction,
        ])
    }
}

/// The model with no more than `count` of its effects.
fn first(model: &RobotModel, count: usize) -> RobotModel {
    let mut first = model.clone();
    first.effects.truncate(count);
    first
}
