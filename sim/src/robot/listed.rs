//! Effects that a model lists, checked against the catalogue.

use slipstream_bus::{EffectSpec, InputError, Parameter, RobotModel};

use crate::effects::{self, Domain, Info, ParameterInfo, Values};
use crate::parts::scalar::Scalar;

/// An effect and the values of its parameters.
pub type Listed<S> = (&'static Info, Values<S>);

/// The effects that `model` lists, judged against the vocabulary.
///
/// # Errors
/// An effect or parameter that is unknown, missing, twice there or out of bounds.
pub fn read_effects(model: &RobotModel) -> Result<Vec<Listed<f64>>, InputError> {
    let mut list: Vec<Listed<f64>> = Vec::new();
    for spec in &model.effects {
        let key = format!("effects.{}", spec.effect);
        let info = effects::find(&spec.effect).ok_or_else(|| {
            InputError::new(
                &key,
                "is not an effect",
                "`slipstream effects` lists those that are",
            )
        })?;
        if !info.repeats && list.iter().any(|(known, _)| known.id == info.id) {
            return Err(InputError::new(key, "is listed twice", "list it once"));
        }
        list.push((info, read_values(info, spec, &key)?));
    }
    Ok(list)
}

/// The same effects with other numbers: `number` is given the effect's place in the list, the
/// parameter's name and its value. For [`Robot::assemble`] with numbers that carry derivatives.
pub fn lift<S: Scalar>(
    list: &[Listed<f64>],
    mut number: impl FnMut(usize, &'static str, f64) -> S,
) -> Vec<Listed<S>> {
    let lifted = list.iter().enumerate();
    lifted
        .map(|(i, (info, values))| (*info, values.map(|name, value| number(i, name, value))))
        .collect()
}

fn read_values(info: &Info, spec: &EffectSpec, key: &str) -> Result<Values<f64>, InputError> {
    let mut numbers = Vec::new();
    let mut text = "";
    for (name, value) in &spec.parameters {
        let at = format!("{key}.{name}");
        let known = info.parameter(name);
        let known = known.ok_or_else(|| {
            let names: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
            let remedy = format!("its parameters are {}", names.join(", "));
            InputError::new(&at, "is no parameter of this effect", remedy)
        })?;
        match (known.domain, value) {
            (Domain::Number { lower, upper, .. }, &Parameter::Number(number)) => {
                if !(lower..=upper).contains(&number) {
                    let remedy = format!("give a number from {lower} to {upper} {}", known.unit);
                    return Err(InputError::new(at, format!("is {number}"), remedy));
                }
                numbers.push((known.name, number));
            }
            (Domain::Text(words), Parameter::Text(word)) => {
                let found = words.iter().find(|known| *known == word);
                text = found.ok_or_else(|| one_of(&at, word, words))?;
            }
            (Domain::Number { .. }, Parameter::Text(word)) => {
                return Err(InputError::new(
                    at,
                    format!("is \"{word}\""),
                    "give a number",
                ));
            }
            (Domain::Text(words), Parameter::Number(number)) => {
                return Err(one_of(&at, &number.to_string(), words));
            }
        }
    }
    complete(info, spec, key)?;
    Ok(Values::new(numbers, text))
}

fn one_of(at: &str, given: &str, words: &[&str]) -> InputError {
    InputError::new(
        at,
        format!("is \"{given}\""),
        format!("give one of {}", words.join(", ")),
    )
}

/// Every parameter is given once; of alternatives exactly one.
fn complete(info: &Info, spec: &EffectSpec, key: &str) -> Result<(), InputError> {
    let given = |p: &ParameterInfo| spec.parameters.iter().filter(|(n, _)| n == p.name).count();
    for parameter in info.parameters {
        let count = given(parameter);
        if count > 1 || (count == 0 && !parameter.alternative) {
            return Err(InputError::new(
                format!("{key}.{}", parameter.name),
                if count > 1 {
                    "is given twice"
                } else {
                    "is not given"
                },
                format!("give it once, in {}", parameter.unit),
            ));
        }
    }
    let mut alternatives = info.parameters.iter().filter(|p| p.alternative).peekable();
    if alternatives.peek().is_some() && alternatives.clone().map(given).sum::<usize>() != 1 {
        let names: Vec<&str> = alternatives.map(|p| p.name).collect();
        let remedy = format!("give exactly one of {}", names.join(", "));
        return Err(InputError::new(key, "has not one parameter", remedy));
    }
    Ok(())
}
