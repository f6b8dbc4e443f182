//! Interface of an effect: the values of its parameters, and the methods by which it changes a
//! robot.

use super::info::Info;
use crate::parts::parameters::{Friction, RobotParameters};
use crate::parts::scalar::{Pair, Scalar};

/// Values of one effect's parameters, validated against [`Info::parameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct Values<S> {
    numbers: Vec<(&'static str, S)>,
    pub(super) text: &'static str,
}

impl<S: Scalar> Values<S> {
    pub(crate) fn new(numbers: Vec<(&'static str, S)>, text: &'static str) -> Self {
        Self { numbers, text }
    }

    /// The same parameters with numbers of another scalar type.
    pub(crate) fn map<T: Scalar>(&self, mut number: impl FnMut(&'static str, S) -> T) -> Values<T> {
        let numbers = self
            .numbers
            .iter()
            .map(|&(name, value)| (name, number(name, value)));
        Values {
            numbers: numbers.collect(),
            text: self.text,
        }
    }

    /// The value of a numerical parameter, if it is given.
    pub fn get(&self, name: &str) -> Option<S> {
        self.numbers
            .iter()
            .find(|(known, _)| *known == name)
            .map(|&(_, value)| value)
    }

    /// The value of a parameter that is always given: [`crate::read_effects`] rejects effects
    /// without it.
    pub(super) fn number(&self, name: &str) -> S {
        self.get(name).unwrap_or_else(|| S::constant(f64::NAN))
    }
}

/// Motion of the robot, on which forces of effects may depend.
#[derive(Debug, Clone, Copy)]
pub struct Motion<S> {
    /// Time since the recording's start (s).
    pub t_s: f64,
    /// Length of the time from `t_s` over which the force is averaged (s).
    pub over_s: f64,
    /// Cosine and sine of the heading φ.
    pub heading: Pair<S>,
    /// Velocity of c along and across the body (m/s).
    pub velocity: Pair<S>,
}

/// Force along and across the body (N) and moment about the vertical (N m), at c.
#[derive(Debug, Clone, Copy)]
pub struct Wrench<S> {
    /// Force along the body (N).
    pub along: S,
    /// Force across the body, to the left (N).
    pub across: S,
    /// Moment, counter-clockwise (N m).
    pub moment: S,
}

/// Construction of an effect from the values of its parameters.
pub trait FromValues<S: Scalar>: Sized {
    /// The effect with these parameter values.
    fn from_values(values: &Values<S>) -> Self;
}

/// Declares the struct of an effect whose parameters are all numbers and always given: one field
/// for each, named as in `robot.toml`.
macro_rules! numbers {
    ($name:ident { $($field:ident),* }) => {
        /// The effect described by its `INFO`.
        #[derive(Debug, Clone)]
        pub(super) struct $name<S> {
            $($field: S,)*
        }

        impl<S: Scalar> $crate::effects::FromValues<S> for $name<S> {
            fn from_values(values: &$crate::effects::Values<S>) -> Self {
                Self {
                    $($field: values.number(stringify!($field)),)*
                }
            }
        }
    };
}
pub(super) use numbers;

/// One effect with its parameters. It implements only the methods for what it changes.
pub trait Effect<S: Scalar>: FromValues<S> {
    /// Its description.
    const INFO: Info;

    /// Changes the parameters of the robot; called once, before the run.
    fn apply(&self, _parameters: &mut RobotParameters<S>) {}

    /// Adds a force on the body that depends on time, heading or velocity; called in every step.
    fn force(&self, _motion: &Motion<S>, _wrench: &mut Wrench<S>) {}

    /// Whether [`Effect::force`] ever adds a force.
    fn has_force(&self) -> bool {
        false
    }

    /// Depth (m) at which `contact` (m, world frame) lies inside the part of the floor whose
    /// friction this effect replaces, negative outside, and that friction.
    fn floor(&self, _contact: Pair<S>) -> Option<(S, Friction<S>)> {
        None
    }
}
