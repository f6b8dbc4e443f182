//! Interface of an effect: the values of its parameters, and the methods by which it changes a
//! robot.

use super::info::Info;
use crate::parts::parameters::{Friction, RobotParameters};
use crate::parts::scalar::{Pair, Scalar};

/// Values of one effect's parameters by name, validated against the parameters of its [`Info`].
#[derive(Debug, Clone, PartialEq)]
pub struct Values<S> {
    numbers: Vec<(&'static str, S)>,
    lists: Vec<(&'static str, Vec<S>)>,
    texts: Vec<(&'static str, &'static str)>,
}

impl<S: Scalar> Values<S> {
    pub(crate) fn none() -> Self {
        Self {
            numbers: Vec::new(),
            lists: Vec::new(),
            texts: Vec::new(),
        }
    }

    pub(crate) fn add_number(&mut self, name: &'static str, value: S) {
        self.numbers.push((name, value));
    }

    pub(crate) fn add_list(&mut self, name: &'static str, list: Vec<S>) {
        self.lists.push((name, list));
    }

    pub(crate) fn add_text(&mut self, name: &'static str, text: &'static str) {
        self.texts.push((name, text));
    }

    /// The same parameters with numbers of another scalar type. `number` gets a parameter's name, the
    /// place in its list (0 for a single number) and the value.
    pub(crate) fn map<T: Scalar>(
        &self,
        mut number: impl FnMut(&'static str, usize, S) -> T,
    ) -> Values<T> {
        let numbers = self.numbers.iter();
        let numbers = numbers
            .map(|&(name, value)| (name, number(name, 0, value)))
            .collect();
        let mut list = |name, list: &[S]| {
            let values = list.iter().enumerate();
            values.map(|(at, &value)| number(name, at, value)).collect()
        };
        let lists = self.lists.iter();
        Values {
            numbers,
            lists: lists
                .map(|(name, values)| (*name, list(name, values)))
                .collect(),
            texts: self.texts.clone(),
        }
    }

    /// The list of this name; empty without one.
    pub fn list(&self, name: &str) -> &[S] {
        let mut lists = self.lists.iter();
        let list = lists.find(|(known, _)| *known == name);
        list.map_or(&[], |(_, values)| values)
    }

    /// The text of this name; empty without one.
    pub(super) fn text(&self, name: &str) -> &'static str {
        let mut texts = self.texts.iter();
        let text = texts.find(|(known, _)| *known == name);
        text.map_or("", |(_, text)| text)
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
    /// Yaw rate (rad/s).
    pub yaw_rate: S,
    /// x and y of c (m) and heading φ (rad, not wrapped), world frame.
    pub pose: [S; 3],
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

    /// Adds to the speed (m/s) and the turn rate (rad/s) with which the wheels carry the body. `motion`
    /// is that of the wheels alone; called in every step.
    fn carry(&self, _motion: &Motion<S>, _added: &mut Pair<S>) {}

    /// Whether [`Effect::carry`] ever adds motion.
    fn has_carry(&self) -> bool {
        false
    }

    /// Depth (m) at which `contact` (m, world frame) lies inside the part of the floor whose
    /// friction this effect replaces, negative outside, and that friction.
    fn floor(&self, _contact: Pair<S>) -> Option<(S, Friction<S>)> {
        None
    }
}
