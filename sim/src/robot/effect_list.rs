//! The effects that a robot model lists, validated against the catalogue.

use slipstream_bus::range::within;
use slipstream_bus::{EffectSpec, InputError, Parameter, RobotModel};

use crate::effects::{self, Domain, Info, LIST_MAX, ParameterInfo, Values};
use crate::parts::scalar::Scalar;

/// An effect of the catalogue with the values of its parameters.
pub type ListedEffect<S> = (&'static Info, Values<S>);

/// Reads the effects that `model` lists and validates them against the catalogue.
///
/// # Errors
/// An effect or parameter that is unknown, missing, given twice or out of bounds.
pub fn read_effects(model: &RobotModel) -> Result<Vec<ListedEffect<f64>>, InputError> {
    let mut list: Vec<ListedEffect<f64>> = Vec::new();
    for spec in &model.effects {
        let key = format!("effects.{}", spec.effect);
        let info = effects::find(&spec.effect).ok_or_else(|| {
            InputError::new(
                &key,
                "is not a known effect",
                "`slipstream effects` lists all effects",
            )
        })?;
        if !info.repeats && list.iter().any(|(known, _)| known.id == info.id) {
            return Err(InputError::new(key, "is listed twice", "list it once"));
        }
        list.push((info, read_values(info, spec, &key)?));
    }
    Ok(list)
}

/// Converts the parameters of `list` into another scalar type, for [`crate::Robot::assemble`].
/// `number` gets the effect's index in the list, the parameter's name and its value; of a parameter that
/// is a list, each value in turn.
///
/// With dual numbers the plant carries derivatives with respect to the parameters that `number`
/// seeds with a derivative of one:
///
/// ```
/// use num_dual::Dual64;
/// use slipstream_bus::RobotModel;
/// use slipstream_sim::{Command, Robot, lift, read_effects};
///
/// let model = RobotModel::default().with("viscous_drag", &[("coefficient", 0.4)]);
/// let list = lift(&read_effects(&model)?, |_, name, value| {
///     let number = Dual64::from(value);
///     if name == "coefficient" { number.derivative() } else { number }
/// });
/// let robot = Robot::assemble(&model, &list)?;
///
/// let mut state = robot.start([Dual64::from(0.0); 3]);
/// let torque = Command::Torque { right_nm: Dual64::from(0.05), left_nm: Dual64::from(0.05) };
/// for step in 0..1000 {
///     robot.step(&mut state, f64::from(step) * 1e-3, 1e-3, &torque);
/// }
///
/// let [x, ..] = state.pose();
/// // More drag, less distance: dx/dc in metres per N s/m.
/// assert!(x.re > 0.3 && x.eps < 0.0);
/// # Ok::<(), slipstream_bus::InputError>(())
/// ```
pub fn lift<S: Scalar>(
    list: &[ListedEffect<f64>],
    mut number: impl FnMut(usize, &'static str, f64) -> S,
) -> Vec<ListedEffect<S>> {
    lift_entries(list, |i, name, _, value| number(i, name, value))
}

/// The same as [`lift`], where `number` gets before the value its place in the parameter's list: 0 for a
/// single number.
pub fn lift_entries<S: Scalar>(
    list: &[ListedEffect<f64>],
    mut number: impl FnMut(usize, &'static str, usize, f64) -> S,
) -> Vec<ListedEffect<S>> {
    let lifted = list.iter().enumerate();
    lifted
        .map(|(i, (info, values))| {
            let values = values.map(|name, at, value| number(i, name, at, value));
            (*info, values)
        })
        .collect()
}

fn read_values(info: &Info, spec: &EffectSpec, key: &str) -> Result<Values<f64>, InputError> {
    let mut values = Values::none();
    for (name, value) in &spec.parameters {
        let at = format!("{key}.{name}");
        let known = info.parameter(name).ok_or_else(|| {
            let names: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
            let remedy = format!("its parameters are {}", names.join(", "));
            InputError::new(&at, "is not a parameter of this effect", remedy)
        })?;
        match (known.domain, value) {
            (Domain::Number { lower, upper, .. }, &Parameter::Number(number)) => {
                within(&at, number, [lower, upper])?;
                values.add_number(known.name, number);
            }
            (Domain::Text(words), Parameter::Text(word)) => {
                let found = words.iter().find(|known| *known == word);
                let found = found.ok_or_else(|| not_one_of(&at, word, words))?;
                values.add_text(known.name, found);
            }
            (
                Domain::List {
                    lower,
                    upper,
                    increasing,
                },
                Parameter::List(list),
            ) => {
                check_list(&at, list, [lower, upper], increasing)?;
                values.add_list(known.name, list.clone());
            }
            (Domain::Number { .. }, _) => {
                let problem = format!("is {}", words_of(value));
                return Err(InputError::new(at, problem, "give a number"));
            }
            (Domain::Text(words), Parameter::Number(number)) => {
                return Err(not_one_of(&at, &number.to_string(), words));
            }
            (Domain::Text(words), Parameter::List(_)) => {
                return Err(not_one_of(&at, "a list", words));
            }
            (Domain::List { .. }, _) => {
                let problem = format!("is {}", words_of(value));
                let remedy = "give a list of numbers, such as [0.0, 0.5]";
                return Err(InputError::new(at, problem, remedy));
            }
        }
    }
    check_complete(info, spec, key)?;
    check_lengths(info, &values, key)?;
    Ok(values)
}

/// A parameter's value in an error.
fn words_of(value: &Parameter) -> String {
    match value {
        Parameter::Number(number) => number.to_string(),
        Parameter::Text(word) => format!("\"{word}\""),
        Parameter::List(_) => "a list".to_owned(),
    }
}

/// Checks the values of a list, each by itself and in order.
fn check_list(at: &str, list: &[f64], range: [f64; 2], increasing: bool) -> Result<(), InputError> {
    if list.is_empty() || list.len() > LIST_MAX {
        let problem = format!("has {} values", list.len());
        let remedy = format!("give from 1 to {LIST_MAX}");
        return Err(InputError::new(at, problem, remedy));
    }
    for (i, &value) in list.iter().enumerate() {
        within(&format!("{at}[{i}]"), value, range)?;
    }
    let mut pairs = list.windows(2).enumerate();
    match pairs.find(|(_, pair)| increasing && pair[0] >= pair[1]) {
        None => Ok(()),
        Some((i, pair)) => Err(InputError::new(
            format!("{at}[{}]", i + 1),
            format!("is {}, not larger than the {} before it", pair[1], pair[0]),
            "give numbers that increase",
        )),
    }
}

/// Checks that all lists have the length of the first.
fn check_lengths(info: &Info, values: &Values<f64>, key: &str) -> Result<(), InputError> {
    let is_list = |p: &&ParameterInfo| matches!(p.domain, Domain::List { .. });
    let mut lists = info.parameters.iter().filter(is_list);
    let Some(first) = lists.next() else {
        return Ok(());
    };
    let length = |p: &ParameterInfo| values.list(p.name).len();
    match lists.find(|other| length(other) != length(first)) {
        None => Ok(()),
        Some(other) => Err(InputError::new(
            format!("{key}.{}", other.name),
            format!("has {} values", length(other)),
            format!("give as many as {}: {}", first.name, length(first)),
        )),
    }
}

fn not_one_of(at: &str, given: &str, words: &[&str]) -> InputError {
    let remedy = format!("give one of {}", words.join(", "));
    InputError::new(at, format!("is \"{given}\""), remedy)
}

/// Checks that every parameter is given once unless it is optional, and of alternatives exactly one.
fn check_complete(info: &Info, spec: &EffectSpec, key: &str) -> Result<(), InputError> {
    let given = |p: &ParameterInfo| spec.parameters.iter().filter(|(n, _)| n == p.name).count();
    for parameter in info.parameters {
        let problem = match given(parameter) {
            0 if parameter.alternative || parameter.optional => continue,
            0 => "is missing",
            1 => continue,
            _ => "is given twice",
        };
        return Err(InputError::new(
            format!("{key}.{}", parameter.name),
            problem,
            format!("give it once, in {}", parameter.unit),
        ));
    }
    let mut alternatives = info.parameters.iter().filter(|p| p.alternative).peekable();
    if alternatives.peek().is_some() && alternatives.clone().map(given).sum::<usize>() != 1 {
        let names: Vec<&str> = alternatives.map(|p| p.name).collect();
        let remedy = format!("give exactly one of {}", names.join(", "));
        return Err(InputError::new(
            key,
            "needs exactly one of its alternative parameters",
            remedy,
        ));
    }
    Ok(())
}
