//! Why encoders count wrong by a factor, in words.

use std::f64::consts::TAU;

use super::Finding;

/// A factor is a known one within this share: more than encoders and wheels are known to, less than what
/// lies between two of the known ones.
const NEAR: f64 = 0.03;
/// Within this share of 1 it is no mistake of a number but one of sizes.
const SMALL: f64 = 0.25;
/// Degrees per radian.
const DEGREES: f64 = 360.0 / TAU;

/// Known factors of measured over true angles, and what makes them.
const KNOWN: [(f64, &str); 10] = [
    (
        2.0,
        "both edges of the encoder's signal are counted and counts per revolution are those of one (quadrature x2), or a gear of 2 is left out",
    ),
    (
        4.0,
        "all four edges of the encoder's signals are counted and counts per revolution are those of one (quadrature x4), or a gear of 4 is left out",
    ),
    (
        0.5,
        "counts per revolution are those of both edges of the encoder's signal and one is counted (quadrature x2), or a gear of 2 is counted twice",
    ),
    (
        0.25,
        "counts per revolution are those of all four edges of the encoder's signals and one is counted (quadrature x4), or a gear of 4 is counted twice",
    ),
    (
        DEGREES,
        "the wheel angles are in degrees instead of radians",
    ),
    (
        1.0 / DEGREES,
        "the wheel angles were converted from degrees to radians once too often",
    ),
    (
        TAU,
        "the wheel angles were multiplied by 2 pi once too often",
    ),
    (
        1.0 / TAU,
        "the wheel angles are in turns instead of radians",
    ),
    (
        360.0,
        "the wheel angles are in degrees where turns are expected",
    ),
    (
        1.0 / 360.0,
        "the wheel angles are in turns where degrees are expected",
    ),
];

/// What makes encoders count by a factor that is far from 1; `None` for other findings, and for sizes that
/// differ by a few per cent.
pub(crate) fn cause(finding: &Finding) -> Option<String> {
    if finding.effect != "encoder_scale" {
        return None;
    }
    let factor = |name: &str| {
        let own = finding.parameters.iter().find(|own| own.name == name)?;
        Some(own.estimate? / own.nominal.unwrap_or(1.0))
    };
    let [right, left] = [factor("right_scale")?, factor("left_scale")?];
    let far = |scale: f64| scale.ln().abs() > SMALL.ln_1p();
    let words = |scale: f64| words(scale).to_owned();
    match [far(right), far(left)] {
        [true, true] if (right / left).ln().abs() < NEAR => Some(words(right)),
        [true, true] => Some(format!("right: {}; left: {}", words(right), words(left))),
        [true, false] => Some(format!("right: {}", words(right))),
        [false, true] => Some(format!("left: {}", words(left))),
        [false, false] => None,
    }
}

/// What makes a factor.
fn words(scale: f64) -> &'static str {
    let near = |known: f64| (scale / known).ln().abs() < NEAR;
    let found = KNOWN.iter().find(|(known, _)| near(*known));
    found.map_or(
        "counts per revolution or the gear ratio are wrong",
        |(_, words)| words,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_factors_have_a_cause_and_others_a_place_to_look() {
        for (scale, part) in [
            (4.01, "quadrature x4"),
            (57.3, "degrees instead of radians"),
            (0.1592, "turns instead of radians"),
            (30.0, "gear ratio"),
        ] {
            assert!(words(scale).contains(part), "{scale}");
        }
    }
}
