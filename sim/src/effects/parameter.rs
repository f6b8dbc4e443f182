//! Parameters of an effect: name, unit, meaning and the values that they may take.

/// Set of values that a parameter may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Domain {
    /// A number in [`lower`, `upper`].
    Number {
        /// Smallest physical value.
        lower: f64,
        /// Largest plausible value.
        upper: f64,
        /// Values spread over what robots show, from which a search for the effect starts.
        probes: &'static [f64],
    },
    /// One of these words.
    Text(&'static [&'static str]),
    /// Numbers in [`lower`, `upper`], from 1 to [`LIST_MAX`] of them. All lists of an effect have the
    /// same length.
    List {
        /// Smallest value of each.
        lower: f64,
        /// Largest value of each.
        upper: f64,
        /// Whether each number is larger than the one before.
        increasing: bool,
    },
}

/// Largest number of values in a list.
pub const LIST_MAX: usize = 64;

/// Meaning of a parameter, which determines how a search treats it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Strength of the effect; at zero the effect is absent.
    Size,
    /// Multiple of a nominal quantity; at one the effect is absent.
    Factor,
    /// Upper limit of a force, torque or speed; at infinity the effect is absent.
    Limit,
    /// Mass that is added to the robot.
    Mass,
    /// Time on the recording's time axis.
    Time,
    /// Coordinate of a point on the floor or on the robot.
    Position,
    /// Radius of a part of the floor.
    Radius,
    /// Angle that wraps at a full turn.
    Direction,
    /// Name of a part of the robot, as text.
    Name,
    /// Values of a driver at which a table has entries.
    Knots,
    /// Entries of a table.
    Entries,
}

impl Role {
    /// The role's name in `slipstream effects --json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Size => "size",
            Self::Factor => "factor",
            Self::Limit => "limit",
            Self::Mass => "mass",
            Self::Time => "time",
            Self::Position => "position",
            Self::Radius => "radius",
            Self::Direction => "direction",
            Self::Name => "name",
            Self::Knots => "knots",
            Self::Entries => "entries",
        }
    }
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterInfo {
    /// Its meaning.
    pub role: Role,
    /// Its key in `robot.toml`, which ends with the unit if it has one.
    pub name: &'static str,
    /// Its unit; "1" for a plain number.
    pub unit: &'static str,
    /// The values it may take.
    pub domain: Domain,
    /// Whether it is one of several alternatives, of which a model gives exactly one.
    pub alternative: bool,
    /// Whether a model may leave it out: it is then 0.
    pub optional: bool,
}

impl ParameterInfo {
    const fn new(role: Role, name: &'static str, unit: &'static str, domain: Domain) -> Self {
        Self {
            role,
            name,
            unit,
            domain,
            alternative: false,
            optional: false,
        }
    }

    /// The same parameter as one of several alternatives.
    pub(super) const fn as_alternative(self) -> Self {
        Self {
            alternative: true,
            ..self
        }
    }

    /// The same parameter, which is 0 where it is left out.
    pub(super) const fn as_optional(self) -> Self {
        Self {
            optional: true,
            ..self
        }
    }
}

/// A number in [`lower`, `upper`], with the values from which a search starts.
pub(super) const fn number(
    role: Role,
    name: &'static str,
    unit: &'static str,
    [lower, upper]: [f64; 2],
    probes: &'static [f64],
) -> ParameterInfo {
    let domain = Domain::Number {
        lower,
        upper,
        probes,
    };
    ParameterInfo::new(role, name, unit, domain)
}

/// A strength.
pub(super) const fn size(
    name: &'static str,
    unit: &'static str,
    bounds: [f64; 2],
    probes: &'static [f64],
) -> ParameterInfo {
    number(Role::Size, name, unit, bounds, probes)
}

/// A multiple.
pub(super) const fn factor(
    name: &'static str,
    bounds: [f64; 2],
    probes: &'static [f64],
) -> ParameterInfo {
    number(Role::Factor, name, "1", bounds, probes)
}

/// An upper limit.
pub(super) const fn limit(
    name: &'static str,
    unit: &'static str,
    bounds: [f64; 2],
    probes: &'static [f64],
) -> ParameterInfo {
    number(Role::Limit, name, unit, bounds, probes)
}

/// A coordinate, at most `reach_m` from the origin.
pub(super) const fn position(
    name: &'static str,
    reach_m: f64,
    probes: &'static [f64],
) -> ParameterInfo {
    number(Role::Position, name, "m", [-reach_m, reach_m], probes)
}

/// An angle, at most `reach_rad` from 0.
pub(super) const fn direction(
    name: &'static str,
    reach_rad: f64,
    probes: &'static [f64],
) -> ParameterInfo {
    number(
        Role::Direction,
        name,
        "rad",
        [-reach_rad, reach_rad],
        probes,
    )
}

/// One of these words.
pub(super) const fn text(name: &'static str, words: &'static [&'static str]) -> ParameterInfo {
    ParameterInfo::new(Role::Name, name, "text", Domain::Text(words))
}

/// The variables over which a table has entries, its knots, and its values, of a size of at most `largest`.
pub(super) const fn list(
    role: Role,
    name: &'static str,
    unit: &'static str,
    largest: f64,
) -> ParameterInfo {
    let domain = Domain::List {
        lower: -largest,
        upper: largest,
        increasing: matches!(role, Role::Knots),
    };
    ParameterInfo::new(role, name, unit, domain)
}
