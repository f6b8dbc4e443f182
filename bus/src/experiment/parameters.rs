//! Tables `[agents]` and `[controller]`: programs in place of the built-in controller, and their parameters.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::message::{RobotIndex, robot_name};

/// The name that stands for all robots.
pub const EVERY_ROBOT: &str = "*";

/// Parameters of a controller, by name.
pub type Parameters = BTreeMap<String, ParameterValue>;

/// The program that `agents` names for a robot, by its own name or for all; `None`: the built-in controller.
pub fn program_of(agents: &BTreeMap<String, String>, robot: RobotIndex) -> Option<&str> {
    let own = agents.get(&robot_name(robot));
    let program = own.or_else(|| agents.get(EVERY_ROBOT))?.trim();
    Some(program).filter(|program| !program.is_empty())
}

/// The value of a parameter of a controller. In postcard it carries its kind; TOML and JSON show it by the value itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub enum ParameterValue {
    /// A truth value.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// A list of numbers.
    Numbers(Vec<f64>),
}

impl Serialize for ParameterValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !serializer.is_human_readable() {
            return Self::serialize(self, serializer);
        }
        match self {
            Self::Bool(value) => serializer.serialize_bool(*value),
            Self::Integer(value) => serializer.serialize_i64(*value),
            Self::Number(value) => serializer.serialize_f64(*value),
            Self::Text(value) => serializer.serialize_str(value),
            Self::Numbers(values) => serializer.collect_seq(values),
        }
    }
}

impl<'de> Deserialize<'de> for ParameterValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            return deserializer.deserialize_any(AnyValue);
        }
        Self::deserialize(deserializer)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = ParameterValue;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, true or false, a text, or a list of numbers")
    }

    fn visit_bool<E>(self, value: bool) -> Result<ParameterValue, E> {
        Ok(ParameterValue::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<ParameterValue, E> {
        Ok(ParameterValue::Integer(value))
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<ParameterValue, E> {
        let whole = i64::try_from(value).map_err(|_| E::custom("is too large"))?;
        Ok(ParameterValue::Integer(whole))
    }

    fn visit_f64<E>(self, value: f64) -> Result<ParameterValue, E> {
        Ok(ParameterValue::Number(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<ParameterValue, E> {
        Ok(ParameterValue::Text(value.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<ParameterValue, A::Error> {
        let mut numbers = Vec::new();
        while let Some(number) = items.next_element()? {
            numbers.push(number);
        }
        Ok(ParameterValue::Numbers(numbers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_keeps_its_kind_in_bytes() {
        let values = vec![
            ParameterValue::Bool(true),
            ParameterValue::Integer(-3),
            ParameterValue::Number(3.0),
            ParameterValue::Text("x".to_owned()),
            ParameterValue::Numbers(vec![1.0, 2.5]),
        ];
        let bytes = postcard::to_allocvec(&values).unwrap();
        assert_eq!(
            postcard::from_bytes::<Vec<ParameterValue>>(&bytes).unwrap(),
            values
        );
    }
}
