//! What is known when a controller is made, and its parameters.

use std::cell::RefCell;

use serde::Serialize;
use serde::de::DeserializeOwned;
use slipstream_bus::experiment::{EVERY_ROBOT, Experiment, ParameterValue, Parameters, Topology};
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_bus::{InputError, Settings};

use crate::geometry::Geometry;

/// What is known when the controller of a robot is made.
#[derive(Debug)]
pub struct AgentContext<'a> {
    experiment: &'a Experiment,
    robot: RobotIndex,
    /// The parameters that the controller has, with their values.
    declared: RefCell<Parameters>,
}

impl<'a> AgentContext<'a> {
    /// The context of a robot of an experiment.
    ///
    /// # Errors
    /// There is no such robot.
    pub fn new(experiment: &'a Experiment, robot: RobotIndex) -> Result<Self, InputError> {
        if experiment.robots.get(robot as usize).is_none() {
            let problem = format!("has no robot {}", robot_name(robot));
            let remedy = "increase the number of robots";
            return Err(InputError::new("robots.count", problem, remedy));
        }
        Ok(Self {
            experiment,
            robot,
            declared: RefCell::default(),
        })
    }

    /// Index of the robot; 0 is the front robot.
    pub fn robot(&self) -> RobotIndex {
        self.robot
    }

    /// Name of the robot; `r1` is the front robot.
    pub fn name(&self) -> String {
        robot_name(self.robot)
    }

    /// Every key of the experiment.
    pub fn settings(&self) -> &'a Settings {
        &self.experiment.settings
    }

    /// The robots that this one hears, in order.
    pub fn hears(&self) -> Vec<RobotIndex> {
        Topology::new(self.experiment).hears(self.robot)
    }

    /// Lengths, masses and inertias of the robot, as its nominal model has them.
    ///
    /// # Errors
    /// The model lacks one.
    pub fn geometry(&self) -> Result<Geometry, InputError> {
        let setup = self.experiment.robots.get(self.robot as usize);
        let model = setup.map(|setup| &setup.model);
        Geometry::new(model.unwrap_or(&slipstream_bus::RobotModel::default()))
    }

    /// The controller's own parameters: `P::default()` with what the experiment gives in `[controller.NAME]`. `P` has numbers,
    /// truth values, texts and lists of numbers.
    ///
    /// ```
    /// use serde::{Deserialize, Serialize};
    /// use slipstream_agents::AgentContext;
    /// use slipstream_bus::experiment::ParameterValue;
    /// use slipstream_bus::{Experiment, RobotModel, Settings};
    ///
    /// #[derive(Serialize, Deserialize)]
    /// struct Gains {
    ///     gain: f64,
    ///     headway_s: f64,
    /// }
    ///
    /// impl Default for Gains {
    ///     fn default() -> Self {
    ///         Self { gain: 1.0, headway_s: 0.5 }
    ///     }
    /// }
    ///
    /// let mut settings = Settings::default();
    /// settings.agents.insert("r2".into(), "./my_agent".into());
    /// settings.controller.entry("r2".into()).or_default().insert("gain".into(), ParameterValue::Integer(2));
    /// let experiment = Experiment::new(settings, &RobotModel::default());
    /// let gains: Gains = AgentContext::new(&experiment, 1)?.parameters()?;
    /// assert_eq!((gains.gain, gains.headway_s), (2.0, 0.5));
    /// # Ok::<(), slipstream_bus::InputError>(())
    /// ```
    ///
    /// # Errors
    /// A parameter that the controller does not have, or a value of another type.
    pub fn parameters<P: Default + Serialize + DeserializeOwned>(&self) -> Result<P, InputError> {
        let unusable = |error: serde_json::Error| {
            let place = format!("the parameters of {}", self.name());
            let remedy = "give a struct of numbers, truth values, texts and lists of numbers";
            InputError::new(place, error.to_string(), remedy)
        };
        let defaults = serde_json::to_value(P::default()).map_err(unusable)?;
        let defaults: Parameters = serde_json::from_value(defaults).map_err(unusable)?;
        let merged = serde_json::to_value(self.merge(defaults)?).map_err(unusable)?;
        serde_json::from_value(merged).map_err(unusable)
    }

    /// The defaults of a controller's parameters with what the experiment gives in their place.
    ///
    /// # Errors
    /// As [`Self::parameters`].
    pub fn merge(&self, defaults: Parameters) -> Result<Parameters, InputError> {
        let mut merged = defaults;
        self.check_given(&merged)?;
        for (name, value) in &mut merged {
            *value = self.parameter(name, value.clone())?;
        }
        Ok(merged)
    }

    /// One parameter of the controller that is a number: what the experiment gives as `controller.NAME.…`, or else the default.
    ///
    /// # Errors
    /// The experiment gives something else than a number.
    pub fn number(&self, name: &str, default: f64) -> Result<f64, InputError> {
        match self.parameter(name, ParameterValue::Number(default))? {
            ParameterValue::Number(value) => Ok(value),
            _ => Ok(default),
        }
    }

    /// One parameter of the controller: what the experiment gives, or else the default.
    ///
    /// # Errors
    /// A value of another type than the default.
    pub fn parameter(
        &self,
        name: &str,
        default: ParameterValue,
    ) -> Result<ParameterValue, InputError> {
        let given = self.settings().parameters(self.robot).remove(name);
        let value = match given {
            None => default,
            Some(given) => fit(&default, given).map_err(|kind| {
                let problem = format!("is not {kind}");
                InputError::new(self.place(name), problem, format!("give {kind}"))
            })?,
        };
        let mut declared = self.declared.borrow_mut();
        declared.insert(name.to_owned(), value.clone());
        Ok(value)
    }

    /// The parameters that the controller has asked for so far, with their values.
    ///
    /// # Errors
    /// The experiment gives one that it has not asked for.
    pub fn declared(&self) -> Result<Parameters, InputError> {
        let declared = self.declared.borrow().clone();
        self.check_given(&declared)?;
        Ok(declared)
    }

    /// Checks that the experiment gives only parameters that the controller has.
    fn check_given(&self, known: &Parameters) -> Result<(), InputError> {
        let given = self.settings().parameters(self.robot);
        let Some(name) = given.keys().find(|name| !known.contains_key(*name)) else {
            return Ok(());
        };
        let names: Vec<&str> = known.keys().map(String::as_str).collect();
        let remedy = match names.is_empty() {
            true => "leave it out: it has none".to_owned(),
            false => format!("give one of {}", names.join(", ")),
        };
        let problem = format!("is no parameter of the controller of {}", self.name());
        Err(InputError::new(self.place(name), problem, remedy))
    }

    /// The key that gives a parameter.
    fn place(&self, name: &str) -> String {
        let own = self.name();
        let table = self.settings().controller.get(&own);
        let is_own = table.is_some_and(|table| table.contains_key(name));
        format!(
            "controller.{}.{name}",
            if is_own { &own } else { EVERY_ROBOT }
        )
    }
}

/// A value in the type of the default.
///
/// # Errors
/// What is needed.
fn fit(default: &ParameterValue, given: ParameterValue) -> Result<ParameterValue, &'static str> {
    use ParameterValue::{Bool, Integer, Number, Numbers, Text};
    match (default, given) {
        #[expect(
            clippy::cast_precision_loss,
            reason = "a number given as a whole one is small"
        )]
        (Number(_), Integer(whole)) => Ok(Number(whole as f64)),
        (Number(_), value @ Number(_))
        | (Integer(_), value @ Integer(_))
        | (Bool(_), value @ Bool(_))
        | (Text(_), value @ Text(_))
        | (Numbers(_), value @ Numbers(_)) => Ok(value),
        (Numbers(_), _) => Err("a list of numbers"),
        (Number(_), _) => Err("a number"),
        (Integer(_), _) => Err("a whole number"),
        (Bool(_), _) => Err("true or false"),
        (Text(_), _) => Err("a text"),
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;

    fn merged(given: &[(&str, &str, ParameterValue)]) -> Result<Parameters, InputError> {
        let mut settings = Settings::default();
        settings.agents.insert("*".to_owned(), "./agent".to_owned());
        for (robot, name, value) in given {
            let table = settings.controller.entry((*robot).to_owned()).or_default();
            table.insert((*name).to_owned(), value.clone());
        }
        let experiment = Experiment::new(settings, &RobotModel::default());
        let defaults = [
            ("gain", ParameterValue::Number(1.0)),
            ("leads", ParameterValue::Bool(false)),
        ];
        let defaults = defaults.map(|(name, value)| (name.to_owned(), value));
        AgentContext::new(&experiment, 1)?.merge(defaults.into())
    }

    #[test]
    fn what_the_experiment_gives_replaces_the_defaults() {
        let whole = ParameterValue::Integer(3);
        let both = merged(&[
            ("*", "gain", whole),
            ("r2", "leads", ParameterValue::Bool(true)),
        ]);
        let both = both.unwrap();
        assert_eq!(both["gain"], ParameterValue::Number(3.0));
        assert_eq!(both["leads"], ParameterValue::Bool(true));
    }

    #[test]
    fn a_parameter_that_is_unknown_or_of_another_type_is_refused_with_its_key() {
        let error = merged(&[("*", "gian", ParameterValue::Number(1.0))]).unwrap_err();
        assert_eq!(error.place, "controller.*.gian");
        assert!(error.remedy.contains("gain, leads"), "{error}");
        let text = ParameterValue::Text("x".to_owned());
        let error = merged(&[("r2", "gain", text)]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "controller.r2.gain: is not a number; give a number"
        );
    }
}
