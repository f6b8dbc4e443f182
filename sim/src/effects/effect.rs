//! What an effect does: its parameters' values, and the methods by which it changes a robot.

use super::info::Info;
use crate::parts::parameters::{Friction, RobotParameters};
use crate::parts::scalar::{Pair, Scalar};

/// The values of one effect's parameters, judged against [`Info::parameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct Values<S> {
    numbers: Vec<(&'static str, S)>,
    pub(super) text: &'static str,
}

impl<S: Scalar> Values<S> {
    pub(crate) fn new(numbers: Vec<(&'static str, S)>, text: &'static str) -> Self {
        Self { numbers, text }
    }

    /// The same with other numbers: constants become numbers with derivatives.
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

    /// The value of a parameter, if it is there and a number.
    pub fn get(&self, name: &str) -> Option<S> {
        self.numbers
            .iter()
            .find(|(known, _)| *known == name)
            .map(|&(_, value)| value)
    }

    /// The value of a parameter that every instance has: [`crate::robot`] refuses one without.
    pub(super) fn number(&self, name: &str) -> S {
        self.get(name).unwrap_or_else(|| S::constant(f64::NAN))
    }
}

/// The robot as the forces on its body see it.
#[derive(Debug, Clone, Copy)]
pub struct Motion<S> {
    /// Time since the recording's start (s).
    pub t_s: f64,
    /// Length of the time that the force is averaged over, from `t_s` on (s).
    pub over_s: f64,
    /// Cosine and sine of the heading φ.
    pub heading: Pair<S>,
    /// Velocity of c along and across the body (m/s).
    pub velocity: Pair<S>,
}

/// Forces along and across the body (N) and moment about the vertical (N m), all at c.
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
    /// The effect with these parameters.
    fn from_values(values: &Values<S>) -> Self;
}

/// Declares the struct of an effect whose parameters are all numbers that every instance has: a
/// field for each, named as in `robot.toml`.
macro_rules! numbers {
    ($name:ident { $($field:ident),* }) => {
        /// See its `INFO`.
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

/// One effect with its parameters. What a method does not override, the effect does not do.
pub trait Effect<S: Scalar>: FromValues<S> {
    /// What it is.
    const INFO: Info;

    /// Writes the effect into the numbers of the robot. Done once, before the run.
    fn apply(&self, _parameters: &mut RobotParameters<S>) {}

    /// Adds a force on the body that depends on time, place or speed. Done in every step.
    fn force(&self, _motion: &Motion<S>, _wrench: &mut Wrench<S>) {}

    /// Whether [`Effect::force`] adds anything, ever.
    fn has_force(&self) -> bool {
        false
    }

    /// How far `contact` (m, world frame) lies inside a place whose friction this effect replaces
    /// (negative: outside), and that friction.
    fn floor(&self, _contact: Pair<S>) -> Option<(S, Friction<S>)> {
        None
    }
}
