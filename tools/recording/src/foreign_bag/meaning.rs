//! What the names of numbers tell: whether a wheel's, and which quantity.

use crate::sides::{side_of, words_of};

/// What a name tells of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// What a wheel or motor was told.
    Command,
    /// A count of an encoder.
    Ticks,
    /// An angle of a wheel.
    Angle,
    /// A speed of a wheel.
    Speed,
    /// Something of a wheel or a motor.
    Wheel,
    /// Something on one side of the robot.
    Side,
    /// Nothing that a wheel has.
    Nothing,
}

const COMMAND: [&str; 10] = [
    "cmd", "command", "target", "desired", "setpoint", "set", "goal", "ref", "pwm", "duty",
];
/// What motors and drivers tell besides the motion of a wheel.
const OTHERS: [&str; 16] = [
    "current", "effort", "torque", "temp", "volt", "batter", "power", "drop", "pressure", "error",
    "status", "bump", "cliff", "fault", "button", "gain",
];
const TICKS: [&str; 6] = ["tick", "encoder", "enc", "count", "counter", "pulse"];
const SPEED: [&str; 4] = ["vel", "speed", "rpm", "rate"];
const ANGLE: [&str; 5] = ["pos", "angle", "rad", "theta", "position"];

/// What the names of a topic, its type and a field tell together.
pub(super) fn meaning(topic: &str, schema: &str, field: &str) -> Meaning {
    // The types of `std_msgs` say nothing; of others, the package is no part of the name.
    let own_type = schema
        .rsplit_once('/')
        .filter(|_| !schema.starts_with("std_msgs/"));
    let own_type = own_type.map_or("", |(_, name)| name);
    let parts = [field, topic, own_type].map(words_of);
    let has = |known: &[&str]| parts.iter().any(|words| has_word(words, known));
    let mut words = parts.iter().flatten();
    let has_wheel = words.any(|word| word.contains("wheel")) || has(&["motor"]);
    let has_side = side_of(&format!("{topic}/{field}")).is_some();
    let last = topic.rsplit('/').next().unwrap_or_default();
    let own = words_of(if own_type.is_empty() { last } else { field });
    if has_word(&own, &OTHERS) {
        return Meaning::Nothing;
    }
    if has(&COMMAND) {
        return match has_side || has_wheel {
            true => Meaning::Command,
            false => Meaning::Nothing,
        };
    }
    if !has_wheel && !has_side && !has(&TICKS) {
        return Meaning::Nothing;
    }
    // The field itself tells more than its topic, and this more than the type.
    let quantity = parts.iter().find_map(|words| quantity(words));
    let other = if has_wheel {
        Meaning::Wheel
    } else {
        Meaning::Side
    };
    quantity.unwrap_or(other)
}

/// The quantity that words tell.
fn quantity(words: &[String]) -> Option<Meaning> {
    match () {
        () if has_word(words, &SPEED) || has_pair(words, "rad", "s") => Some(Meaning::Speed),
        () if has_word(words, &TICKS) => Some(Meaning::Ticks),
        () if has_word(words, &ANGLE) => Some(Meaning::Angle),
        () => None,
    }
}

/// Whether a word is one of these, or begins or ends with one of those that are long enough.
fn has_word(words: &[String], known: &[&str]) -> bool {
    let is_it = |word: &str, known: &str| {
        let is_long = known.len() > 3 || known == "vel";
        word == known || is_long && (word.starts_with(known) || word.ends_with(known))
    };
    let mut words = words.iter();
    words.any(|word| known.iter().any(|known| is_it(word, known)))
}

/// Whether two words follow each other, as in `rad_s`.
fn has_pair(words: &[String], first: &str, second: &str) -> bool {
    words
        .windows(2)
        .any(|pair| matches!(pair, [a, b] if a == first && b == second))
}

/// Whether a name tells a unit other than that of the quantity, or a difference since the last message.
pub(super) fn has_other_unit(name: &str) -> bool {
    const UNITS: [&str; 10] = [
        "rpm", "mps", "ms", "mm", "cm", "deg", "degrees", "delta", "diff", "dt",
    ];
    let words = words_of(name);
    words.iter().any(|word| UNITS.contains(&word.as_str())) || has_pair(&words, "m", "s")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_what_numbers_are() {
        let cases = [
            ("/left_ticks", "std_msgs/msg/Int32", "data", Meaning::Ticks),
            ("/lwheel", "std_msgs/msg/Int16", "data", Meaning::Wheel),
            (
                "/encoder/left",
                "std_msgs/msg/Int64",
                "data",
                Meaning::Ticks,
            ),
            (
                "/wheel_vels",
                "irobot_create_msgs/msg/WheelVels",
                "velocity_left",
                Meaning::Speed,
            ),
            (
                "/sensor_state",
                "turtlebot3_msgs/msg/SensorState",
                "left_encoder",
                Meaning::Ticks,
            ),
            (
                "/sensor_state",
                "turtlebot3_msgs/msg/SensorState",
                "battery",
                Meaning::Nothing,
            ),
            (
                "/left_wheel_cmd",
                "std_msgs/msg/Float32",
                "data",
                Meaning::Command,
            ),
            ("/motor", "a/msg/State", "current_left", Meaning::Nothing),
            ("/base", "a/msg/WheelStatus", "left_rad_s", Meaning::Speed),
            (
                "/wheel_speeds",
                "a/msg/WheelSpeeds",
                "left_wheel_position",
                Meaning::Angle,
            ),
            (
                "/lwheel_vtarget",
                "std_msgs/msg/Float32",
                "data",
                Meaning::Command,
            ),
            ("/left", "std_msgs/msg/Float32", "data", Meaning::Side),
            (
                "/temperature",
                "std_msgs/msg/Float32",
                "data",
                Meaning::Nothing,
            ),
        ];
        for (topic, schema, field, expected) in cases {
            assert_eq!(meaning(topic, schema, field), expected, "{topic} {field}");
        }
    }
}
