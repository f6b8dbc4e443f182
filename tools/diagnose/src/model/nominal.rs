//! Values that the nominal model gives to the parameters of a kinematic robot.

use slipstream_bus::{Parameter, RobotModel};

/// The number `name` of an effect that the model lists.
pub(crate) fn number(model: &RobotModel, effect: &str, name: &str) -> Option<f64> {
    let spec = model.effects.iter().find(|spec| spec.effect == effect)?;
    spec.parameters.iter().find_map(|(own, value)| match value {
        Parameter::Number(value) if own == name => Some(*value),
        _ => None,
    })
}

/// The rate of the clock of a stream that the model lists.
pub(crate) fn clock_rate(model: &RobotModel, stream: &str) -> Option<f64> {
    let named = |value: &Parameter| matches!(value, Parameter::Text(text) if text == stream);
    let mut drifts = model
        .effects
        .iter()
        .filter(|spec| spec.effect == "clock_drift");
    let spec = drifts.find(|spec| spec.parameters.iter().any(|(_, value)| named(value)))?;
    spec.parameters.iter().find_map(|(own, value)| match value {
        Parameter::Number(value) if own == "rate" => Some(*value),
        _ => None,
    })
}
