//! Detectability of the concealed effects: expected log-likelihood gain and Cramér-Rao bound.
//!
//! The recording is cut into windows of 5 s. The initial state of each is free: what another initial state
//! could explain does not count.

use nalgebra::DVector;
use slipstream_bus::{EffectSpec, Parameter, RobotModel};

use super::information::{Nuisance, cramer_rao};
use super::prediction::{PredictionModel, Windows, perturbed};
use super::scene::Scene;
use super::simulate::SimulatedRobot;

/// Relative difference step of a parameter.
const RELATIVE_STEP: f64 = 1e-3;
/// Smallest size of a parameter that the relative step refers to, in the parameter's unit.
const MIN_SCALE: f64 = 1e-2;

/// How well the concealed effects of one robot can be detected.
pub(crate) struct Detectability {
    /// Expected log-likelihood gain of the true model over the model without each effect (nats), with a
    /// standard deviation of one count for the encoders. Under process noise, less.
    pub(crate) gains: Vec<f64>,
    /// Cramér-Rao bound of each numeric parameter of each effect, all estimated together, with the standard
    /// deviation of rounding (1/√12 counts) for the encoders.
    pub(crate) deviations: Vec<Vec<(String, f64)>>,
    /// The same gain for the effect outside the vocabulary.
    pub(crate) outside: f64,
}

/// How well the concealed effects of robot `i` can be detected.
///
/// # Errors
/// A model that cannot be simulated.
pub(crate) fn detectability(
    scene: &Scene,
    i: usize,
    robot_run: &SimulatedRobot,
) -> Result<Detectability, String> {
    let concealed = &scene.robots[i].concealed;
    let outside = scene.robots[i].outside;
    let model = scene.model(i);
    let truth = PredictionModel::new(scene, &model, outside)?;
    let windows = Windows::new(scene, i, robot_run);
    let predictions = windows.predict(&truth, None);
    let perturbed = perturbed(&windows, &truth);
    let measured = scene.noise.map(|_| windows.measured(&truth));
    let [for_gains, for_bounds] = [1.0, 12f64.sqrt()].map(|weight| TruePrediction {
        windows: &windows,
        predictions: &predictions,
        nuisances: windows.nuisances(&predictions, &perturbed, weight),
        measured: measured.as_deref(),
    });
    let mut gains = Vec::new();
    let mut columns: Vec<Vec<DVector<f64>>> = Vec::new();
    for effect in concealed {
        let without = replaced(&model, effect, listed(&scene.nominal, effect));
        gains.push(for_gains.gain_over(&PredictionModel::new(scene, &without, outside)?));
        for (at, (_, value)) in effect.parameters.iter().enumerate() {
            if let Parameter::Number(number) = value {
                let step = RELATIVE_STEP * number.abs().max(MIN_SCALE);
                let changed = with_parameter(effect, at, number + step);
                let other = replaced(&model, effect, Some(&changed));
                let column = for_bounds.difference(&PredictionModel::new(scene, &other, outside)?);
                columns.push(column.into_iter().map(|part| part / step).collect());
            }
        }
    }
    let outside = match outside {
        None => 0.0,
        Some(_) => for_gains.gain_over(&PredictionModel::new(scene, &model, None)?),
    };
    let deviations = if scene.noise.is_some() {
        // The bound knows only the noise of the sensors.
        vec![Vec::new(); concealed.len()]
    } else {
        named(concealed, &cramer_rao(&columns))
    };
    Ok(Detectability {
        gains,
        deviations,
        outside,
    })
}

/// The predictions of the true model, which those of other models are compared with.
struct TruePrediction<'a> {
    windows: &'a Windows<'a>,
    /// By window.
    predictions: &'a [DVector<f64>],
    /// By window.
    nuisances: Vec<Nuisance>,
    /// What was measured in each window, where process noise drives it away from the prediction.
    measured: Option<&'a [DVector<f64>]>,
}

impl TruePrediction<'_> {
    /// What another model predicts differently, without what the nuisance parameters can explain.
    fn difference(&self, model: &PredictionModel) -> Vec<DVector<f64>> {
        let other = self.windows.predict(model, None);
        let pairs = self.predictions.iter().zip(&other).zip(&self.nuisances);
        pairs
            .map(|((one, other), nuisance)| nuisance.project_out(one - other))
            .collect()
    }

    /// Expected log-likelihood gain over another model (nats).
    ///
    /// Under process noise half the square of the effect's size in standard deviations of its least-squares
    /// estimate, whose variance is taken from the sums over the windows (Huber's sandwich).
    fn gain_over(&self, model: &PredictionModel) -> f64 {
        let parts = self.difference(model);
        let square: f64 = parts.iter().map(DVector::norm_squared).sum();
        let Some(measured) = self.measured else {
            return square / 2.0;
        };
        let windows = measured.iter().zip(self.predictions).zip(&self.nuisances);
        let driven = windows
            .map(|((measured, predicted), nuisance)| nuisance.project_out(measured - predicted));
        let along = driven.zip(&parts).map(|(driven, part)| driven.dot(part));
        let variance = square + along.map(|sum| sum * sum).sum::<f64>();
        if variance > 0.0 {
            square * square / (2.0 * variance)
        } else {
            0.0
        }
    }
}

/// The effect of the same id that a model lists.
fn listed<'a>(model: &'a RobotModel, effect: &EffectSpec) -> Option<&'a EffectSpec> {
    model
        .effects
        .iter()
        .find(|listed| listed.effect == effect.effect)
}

/// The model with an effect replaced by another one, or removed.
fn replaced(model: &RobotModel, effect: &EffectSpec, other: Option<&EffectSpec>) -> RobotModel {
    let mut model = model.clone();
    if let Some(at) = model.effects.iter().position(|own| own == effect) {
        model.effects.remove(at);
    }
    model.effects.extend(other.cloned());
    model
}

/// The effect with another value of one parameter.
fn with_parameter(effect: &EffectSpec, at: usize, to: f64) -> EffectSpec {
    let mut effect = effect.clone();
    effect.parameters[at].1 = Parameter::Number(to);
    effect
}

/// The bounds with the names of their parameters, by effect.
fn named(concealed: &[EffectSpec], bounds: &[f64]) -> Vec<Vec<(String, f64)>> {
    let mut bounds = bounds.iter();
    let numbers = |effect: &EffectSpec| {
        let numbers = effect
            .parameters
            .iter()
            .filter(|(_, value)| matches!(value, Parameter::Number(_)));
        numbers
            .filter_map(|(name, _)| Some((name.clone(), *bounds.next()?)))
            .collect()
    };
    concealed.iter().map(numbers).collect()
}
