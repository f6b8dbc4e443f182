//! Units in the names of columns, such as `heading_deg` and `w_x [rad s^-1]`.

use std::f64::consts::{PI, TAU};

use crate::sides::split_humps;

/// What a column of the format measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    Time,
    Length,
    Angle,
    Speed,
    TurnRate,
    Acceleration,
    Voltage,
    Current,
    Torque,
    /// Counts and parts of quaternions.
    One,
}

const DEGREE: f64 = PI / 180.0;

/// Words that name a unit, what it measures, and its size in SI units.
const UNITS: [(&str, Dimension, f64); 55] = [
    ("s", Dimension::Time, 1.0),
    ("sec", Dimension::Time, 1.0),
    ("secs", Dimension::Time, 1.0),
    ("seconds", Dimension::Time, 1.0),
    ("ms", Dimension::Time, 1e-3),
    ("msec", Dimension::Time, 1e-3),
    ("millis", Dimension::Time, 1e-3),
    ("milliseconds", Dimension::Time, 1e-3),
    ("us", Dimension::Time, 1e-6),
    ("usec", Dimension::Time, 1e-6),
    ("micros", Dimension::Time, 1e-6),
    ("microseconds", Dimension::Time, 1e-6),
    ("ns", Dimension::Time, 1e-9),
    ("nsec", Dimension::Time, 1e-9),
    ("nanos", Dimension::Time, 1e-9),
    ("nanoseconds", Dimension::Time, 1e-9),
    ("m", Dimension::Length, 1.0),
    ("meters", Dimension::Length, 1.0),
    ("cm", Dimension::Length, 1e-2),
    ("mm", Dimension::Length, 1e-3),
    ("in", Dimension::Length, 0.0254),
    ("inches", Dimension::Length, 0.0254),
    ("ft", Dimension::Length, 0.3048),
    ("rad", Dimension::Angle, 1.0),
    ("radians", Dimension::Angle, 1.0),
    ("deg", Dimension::Angle, DEGREE),
    ("degree", Dimension::Angle, DEGREE),
    ("degrees", Dimension::Angle, DEGREE),
    ("rev", Dimension::Angle, TAU),
    ("rotations", Dimension::Angle, TAU),
    ("m s", Dimension::Speed, 1.0),
    ("m s 1", Dimension::Speed, 1.0),
    ("mps", Dimension::Speed, 1.0),
    ("cm s", Dimension::Speed, 1e-2),
    ("mm s", Dimension::Speed, 1e-3),
    ("rad s", Dimension::TurnRate, 1.0),
    ("rad s 1", Dimension::TurnRate, 1.0),
    ("rads", Dimension::TurnRate, 1.0),
    ("deg s", Dimension::TurnRate, DEGREE),
    ("dps", Dimension::TurnRate, DEGREE),
    ("rpm", Dimension::TurnRate, TAU / 60.0),
    ("rps", Dimension::TurnRate, TAU),
    ("rev s", Dimension::TurnRate, TAU),
    ("m s2", Dimension::Acceleration, 1.0),
    ("m s 2", Dimension::Acceleration, 1.0),
    ("mg", Dimension::Acceleration, 9.80665e-3),
    ("g", Dimension::Acceleration, 9.80665),
    ("v", Dimension::Voltage, 1.0),
    ("mv", Dimension::Voltage, 1e-3),
    // `mV` and `mA` are split like humps.
    ("m v", Dimension::Voltage, 1e-3),
    ("m a", Dimension::Current, 1e-3),
    ("a", Dimension::Current, 1.0),
    ("ma", Dimension::Current, 1e-3),
    ("nm", Dimension::Torque, 1.0),
    ("n m", Dimension::Torque, 1.0),
];

impl Dimension {
    /// What a column of the format measures, by the unit at the end of its name.
    pub(super) fn of(column: &str) -> Self {
        let endings = [
            ("t_s", Self::Time),
            ("_m_s2", Self::Acceleration),
            ("_rad_s", Self::TurnRate),
            ("_m_s", Self::Speed),
            ("_rad", Self::Angle),
            ("_nm", Self::Torque),
            ("_m", Self::Length),
            ("_v", Self::Voltage),
            ("_a", Self::Current),
        ];
        let mut endings = endings
            .iter()
            .filter(|(ending, _)| column.ends_with(ending));
        endings
            .next()
            .map_or(Self::One, |(_, dimension)| *dimension)
    }
}

/// The words of a name, in small letters.
pub(super) fn words(name: &str) -> Vec<String> {
    let signs = [
        ("°", " deg "),
        ("²", "2"),
        ("µs", " us "),
        ("μs", " us "),
        ("θ", "theta"),
        ("ψ", "yaw"),
        ("ω", "omega"),
    ];
    let name = signs.iter().fold(name.to_owned(), |name, (sign, word)| {
        name.replace(sign, word)
    });
    let name = split_humps(&name);
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    words
        .filter(|word| !word.is_empty())
        .map(str::to_owned)
        .collect()
}

/// Words of times besides units.
const TIMES: [&str; 7] = ["t", "time", "timestamp", "stamp", "zeit", "datetime", "ts"];

/// Whether a name has a word of time.
pub(super) fn is_of_time(name: &[String]) -> bool {
    let units = UNITS.iter().filter(|(_, of, _)| *of == Dimension::Time);
    let units = units.map(|(unit, ..)| *unit);
    let mut known = units.chain(TIMES);
    known.any(|known| name.iter().any(|word| word == known))
}

/// The size of the unit that a name has after `wanted`, whose words may stand in any order: 1 without a unit. `None` if
/// the name is another one.
pub(super) fn unit_after(name: &[String], wanted: &str, dimension: Dimension) -> Option<Unit> {
    let mut wanted: Vec<&str> = wanted.split(' ').filter(|word| !word.is_empty()).collect();
    // A unit has at most three words.
    if !(wanted.len()..=wanted.len() + 3).contains(&name.len()) {
        return None;
    }
    wanted.sort_unstable();
    let is_wanted = |words: &[String]| {
        let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
        words.sort_unstable();
        words == wanted
    };
    if is_wanted(name) {
        return Some(Unit::NotSaid);
    }
    let units = UNITS.iter().filter(|(_, of, _)| *of == dimension);
    let mut sizes = units.filter_map(|(unit, _, size)| {
        let unit: Vec<&str> = unit.split(' ').collect();
        let (before, last) = name.split_at_checked(name.len().checked_sub(unit.len())?)?;
        (last == unit && is_wanted(before)).then_some(Unit::Said(*size))
    });
    sizes.next()
}

/// The unit in a name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unit {
    /// The name says none.
    NotSaid,
    /// Its size in SI units.
    Said(f64),
}

impl Unit {
    /// Whether the name says it.
    pub(super) fn is_said(self) -> bool {
        self != Self::NotSaid
    }

    /// The factor to SI units.
    pub(super) fn factor(self) -> f64 {
        match self {
            Self::NotSaid => 1.0,
            Self::Said(factor) => factor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_units() {
        let unit = |name: &str, wanted, column| {
            unit_after(&words(name), wanted, Dimension::of(column)).map(Unit::factor)
        };
        assert_eq!(unit("time_ms", "time", "t_s"), Some(1e-3));
        assert_eq!(unit("timestamp [ns]", "timestamp", "t_s"), Some(1e-9));
        assert_eq!(unit("Heading (°)", "heading", "yaw_rad"), Some(DEGREE));
        assert_eq!(
            unit("w_RS_S_z [rad s^-1]", "w rs s z", "gz_rad_s"),
            Some(1.0)
        );
        assert_eq!(unit("gyro z (deg/s)", "gyro z", "gz_rad_s"), Some(DEGREE));
        assert_eq!(
            unit("leftSpeed_rpm", "left speed", "speed_left_rad_s"),
            Some(TAU / 60.0)
        );
        assert_eq!(unit("a_x [m s^-2]", "x a", "ax_m_s2"), Some(1.0));
        assert_eq!(unit("x", "x", "x_m"), Some(1.0));
        // A wheel's speed along the floor is no turn rate.
        assert_eq!(
            unit("left speed m/s", "left speed", "speed_left_rad_s"),
            None
        );
        assert_eq!(unit("x_mm", "y", "x_m"), None);
    }
}
