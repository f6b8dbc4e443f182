//! What the names of parameters and constants mean: `wheel_separation`, `kTrackwidthMeters`, `wheels.radius`.

use crate::sides::words_of;

/// A quantity of a drive that a name tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Distance of the wheels across the robot.
    Separation,
    /// The same, by a word that mostly means the distance along the robot.
    Wheelbase,
    Radius,
    Diameter,
    /// Encoder counts per turn of a wheel.
    CountsPerTurn,
}

/// Names of each quantity, without what separates their words.
const NAMES: [(Quantity, &[&str]); 5] = [
    (
        Quantity::Separation,
        &[
            "wheelseparation",
            "wheelsseparation",
            "trackwidth",
            "track",
            "wheeltrack",
            "wheeltrackwidth",
            "axletrack",
            "axlelength",
            "basewidth",
            "baseline",
            "wheeldistance",
            "wheelsdistance",
            "wheelspacing",
            "distancebetweenwheels",
            "distancewheels",
            "trackseparation",
            "tracksseparation",
        ],
    ),
    (Quantity::Wheelbase, &["wheelbase"]),
    (
        Quantity::Radius,
        &["wheelradius", "wheelsradius", "radiuswheel", "wheelrad"],
    ),
    (
        Quantity::Diameter,
        &[
            "wheeldiameter",
            "wheelsdiameter",
            "wheeldiam",
            "diamwheel",
            "diameterwheel",
        ],
    ),
    (
        Quantity::CountsPerTurn,
        &[
            "countsperrev",
            "countsperrevolution",
            "countsperturn",
            "enccountsperrev",
            "encodercountsperrev",
            "encodercountsperrevolution",
            "ticksperrev",
            "ticksperrevolution",
            "ticksperrotation",
            "encoderticksperrev",
            "encoderticksperrevolution",
            "encoderticksperrotation",
            "ticksperturn",
        ],
    ),
];

/// Words that may stand before a name.
const BEFORE: [&str; 11] = [
    "k",
    "robot",
    "drive",
    "drivetrain",
    "drivebase",
    "chassis",
    "base",
    "kinematics",
    "lr",
    "dd",
    "m",
];

/// Units that may end a name as words of their own (m).
const UNITS: [(&str, f64); 9] = [
    ("m", 1.0),
    ("meters", 1.0),
    ("metres", 1.0),
    ("mm", 1e-3),
    ("millimeters", 1e-3),
    ("cm", 1e-2),
    ("centimeters", 1e-2),
    ("inches", INCH_M),
    ("in", INCH_M),
];

/// An inch (m).
pub(super) const INCH_M: f64 = 0.0254;

/// The quantity that a name tells, and the unit in which it ends (m).
pub(super) fn quantity_of(name: &str) -> Option<(Quantity, Option<f64>)> {
    let words = words_of(name);
    let mut words = words.as_slice();
    let mut unit_m = None;
    if let Some((last, before)) = words.split_last()
        && let Some((_, own)) = UNITS.iter().find(|(word, _)| word == last)
    {
        (words, unit_m) = (before, Some(*own));
    }
    loop {
        let joined = words.concat();
        for (ending, own) in UNITS.iter().filter(|(word, _)| word.len() > 2) {
            if let Some(quantity) = joined.strip_suffix(ending).and_then(exactly) {
                return Some((quantity, Some(*own)));
            }
        }
        if let Some(quantity) = exactly(&joined) {
            return Some((quantity, unit_m));
        }
        match words {
            [first, rest @ ..] if BEFORE.contains(&first.as_str()) => words = rest,
            _ => return None,
        }
    }
}

fn exactly(joined: &str) -> Option<Quantity> {
    let own = NAMES.iter().find(|(_, names)| names.contains(&joined));
    own.map(|(quantity, _)| *quantity)
}

/// Whether a name may be that of the wheel joints of a side: `left_wheel_names`, `wheel_left_joint_name`, `leftJoint`.
pub(super) fn names_joints(name: &str) -> bool {
    const ALLOWED: [&str; 16] = [
        "left", "right", "wheel", "wheels", "joint", "joints", "name", "names", "front", "rear",
        "middle", "mid", "back", "frame", "command", "drive",
    ];
    let words = words_of(name);
    let has = |some: &[&str]| words.iter().any(|word| some.contains(&word.as_str()));
    let sides = ["left", "right"].map(|side| has(&[side]));
    sides[0] != sides[1]
        && has(&["wheel", "wheels", "joint", "joints", "frame"])
        && words.iter().all(|word| ALLOWED.contains(&word.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_quantities_and_units() {
        let cases = [
            ("wheel_separation", Some((Quantity::Separation, None))),
            ("wheels.separation", Some((Quantity::Separation, None))),
            ("wheelSeparation", Some((Quantity::Separation, None))),
            ("kTrackwidthMeters", Some((Quantity::Separation, Some(1.0)))),
            ("TRACKWIDTHMETERS", Some((Quantity::Separation, Some(1.0)))),
            ("TRACK_WIDTH", Some((Quantity::Separation, None))),
            ("robotTrackwidth", Some((Quantity::Separation, None))),
            ("baseline_m", Some((Quantity::Separation, Some(1.0)))),
            ("base_width", Some((Quantity::Separation, None))),
            ("LR_WHEELS_DISTANCE", Some((Quantity::Separation, None))),
            ("wheel_base", Some((Quantity::Wheelbase, None))),
            ("driveWheelRadius", Some((Quantity::Radius, None))),
            ("kWheelRadiusInches", Some((Quantity::Radius, Some(INCH_M)))),
            ("wheel_radius_mm", Some((Quantity::Radius, Some(1e-3)))),
            ("WHEEL_DIAMETER", Some((Quantity::Diameter, None))),
            ("kinematics.wheels_radius", Some((Quantity::Radius, None))),
            ("enc_counts_per_rev", Some((Quantity::CountsPerTurn, None))),
            ("wheel_separation_multiplier", None),
            ("robot_radius", None),
            ("wheel_radius_multiplier", None),
        ];
        for (name, expected) in cases {
            assert_eq!(quantity_of(name), expected, "{name}");
        }
    }

    #[test]
    fn names_of_joints_have_a_side() {
        let yes = [
            "left_wheel_names",
            "right_wheel",
            "wheel_left_joint_name",
            "leftJoint",
            "left_joint",
            "leftFrontJoint",
        ];
        let no = [
            "left_wheel_radius_multiplier",
            "left_wheel_topic",
            "wheel_names",
            "left_right_wheel",
            "left",
        ];
        assert!(yes.iter().all(|name| names_joints(name)));
        assert!(!no.iter().any(|name| names_joints(name)));
    }
}
