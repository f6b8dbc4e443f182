//! Values that the nominal model gives to the parameters of a kinematic robot.

use slipstream_bus::{EffectSpec, Parameter, RobotModel};

use crate::filter::motion_law::Table;

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

/// The laws of the kind of a table that the model lists: pairs of knot and value.
pub(crate) fn laws<'a>(
    model: &'a RobotModel,
    table: &'a Table,
) -> impl Iterator<Item = Vec<[f64; 2]>> + 'a {
    let has = |spec: &EffectSpec, key: &str, word: &str| {
        let named = |(own, value): &(String, Parameter)| {
            own == key && matches!(value, Parameter::Text(text) if text == word)
        };
        spec.parameters.iter().any(named)
    };
    let laws = model.effects.iter().filter(move |spec| {
        spec.effect == "motion_law"
            && has(spec, "acts_on", table.acts_on)
            && has(spec, "driver", table.driver)
    });
    laws.filter_map(|spec| {
        let list = |name: &str| {
            spec.parameters.iter().find_map(|(own, value)| match value {
                Parameter::List(list) if own == name => Some(list),
                _ => None,
            })
        };
        let pairs = list("knots")?.iter().zip(list("values")?);
        Some(pairs.map(|(knot, value)| [*knot, *value]).collect())
    })
}
