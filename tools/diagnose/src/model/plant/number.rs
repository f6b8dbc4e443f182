//! One number of an effect, and the parameter that moves it.

use slipstream_sim::effects::{Domain, Info, Role};

use super::filtered::least_change;
use super::machine::Machine;
use crate::model::hypothesis::{Hypothesis, come_round};

/// How a number of an effect changes with its parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Link {
    /// It is added.
    Added,
    /// It is added to the inverse: a limit that is infinite does nothing.
    Inverse,
    /// The same as an angle.
    Angle,
}

/// One number of an effect.
#[derive(Debug, Clone, Copy)]
pub(super) struct Number {
    pub(super) name: &'static str,
    pub(super) link: Link,
    /// Change of the number, or of its inverse, by a parameter of 1.
    pub(super) unit: f64,
    /// The number, or its inverse, where the parameter is 0.
    pub(super) nothing: f64,
    pub(super) bounds: [f64; 2],
}

impl Number {
    pub(super) fn new(own: &Hypothesis, name: &'static str, machine: &Machine) -> Self {
        let info = own.info;
        let parameter = info.parameter(name);
        let (role, bounds) = match parameter.map(|p| (p.role, p.domain)) {
            Some((role, Domain::Number { lower, upper, .. })) => (role, [lower, upper]),
            _ => (Role::Size, [f64::NEG_INFINITY, f64::INFINITY]),
        };
        let link = match role {
            Role::Limit => Link::Inverse,
            Role::Direction => Link::Angle,
            _ => Link::Added,
        };
        let nominal = own.nominal(&machine.model, name);
        let nothing = match (link, nominal) {
            (Link::Inverse, Some(limit)) => 1.0 / limit,
            (Link::Inverse, None) => 0.0,
            _ => own.nothing(&machine.model, name),
        };
        let length_m = machine.model.robot.half_track_m;
        let unit = match (link, role) {
            (Link::Inverse, _) => own.value(name).map_or(1.0, |value| 1.0 / value),
            (Link::Angle, _) => 1.0,
            (_, Role::Position | Role::Radius) => length_m,
            (_, Role::Mass) => 0.1 * machine.model.robot.body_mass_kg.unwrap_or(1.0),
            _ => least_change(info, name),
        };
        Self {
            name,
            link,
            unit: if unit > 0.0 && unit.is_finite() {
                unit
            } else {
                1.0
            },
            nothing,
            bounds,
        }
    }

    /// The number at a parameter.
    pub(super) fn value(&self, info: &Info, at: f64) -> f64 {
        let own = self.nothing + self.unit * at;
        let [lower, upper] = self.bounds;
        match self.link {
            Link::Added => own.clamp(lower, upper),
            Link::Angle => come_round(info, self.name, own),
            Link::Inverse => (1.0 / own.max(1.0 / upper)).clamp(lower, upper),
        }
    }

    /// The parameter of a number.
    pub(super) fn at(&self, value: f64) -> f64 {
        let own = match self.link {
            Link::Inverse => 1.0 / value,
            _ => value,
        };
        (own - self.nothing) / self.unit
    }

    /// Change of the number by its parameter.
    pub(super) fn slope(&self, value: f64) -> f64 {
        match self.link {
            Link::Inverse => -value * value * self.unit,
            _ => self.unit,
        }
    }
}
