//! Radii, track, slip, encoders, and the place of the pose sensor.
//!
//! The multipliers of diff_drive_controller act on commands and on odometry alike: it divides the speed that
//! each side is to have by multiplier × `wheel_radius`, and multiplies measured wheel angles by the same; the
//! track is `wheel_separation_multiplier` × `wheel_separation` in both. So a radius or a track belongs there, and
//! neither what a floor takes away, which the wheels do not have on the next floor, nor what encoders miscount.

use super::quantity::Quantity;
use crate::Finding;
use crate::miscount::cause;
use crate::setup::{Setup, Told};

pub(super) fn wheel_radius(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let [left, right] = sides(finding, ["left_scale", "right_scale"])?;
    let radius_m = setup.model.robot.wheel_radius_m;
    let lengths = || {
        let [left, right] = [left, right].map(|own| own.map(|scale| scale * radius_m).text());
        format!("{left} m (left) and {right} m (right)")
    };
    let multipliers = format!(
        "set left_wheel_radius_multiplier to {} and right_wheel_radius_multiplier to {} in \
         diff_drive_controller",
        left.text(),
        right.text()
    );
    Some(match setup.told {
        Told::Twist | Told::Nothing => vec![multipliers],
        // its commands pass diff_drive_controller by
        Told::WheelSpeed => vec![
            multipliers,
            format!(
                "use wheel radii of {} where speeds of the body become wheel speeds",
                lengths()
            ),
        ],
        Told::Torque | Told::Voltage => vec![
            format!("use wheel radii of {} in odometry and simulator", lengths()),
            multipliers,
        ],
    })
}

pub(super) fn track_width(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let scale = Quantity::of(finding, "scale")?;
    let track_m = scale.map(|scale| 2.0 * scale * setup.model.robot.half_track_m);
    let multiplier = format!(
        "set wheel_separation_multiplier to {} in diff_drive_controller",
        scale.text()
    );
    let length = format!("{} m between the wheels", track_m.text());
    Some(match setup.told {
        Told::Twist | Told::Nothing => vec![multiplier],
        Told::WheelSpeed => vec![
            multiplier,
            format!("use {length} where turn rates become wheel speeds"),
        ],
        Told::Torque | Told::Voltage => vec![
            format!("use {length} in odometry and simulator; masses and inertias stay"),
            multiplier,
        ],
    })
}

pub(super) fn slip_ratio(finding: &Finding) -> Option<Vec<String>> {
    let ratio = Quantity::of(finding, "ratio")?;
    let asymmetry = Quantity::of(finding, "asymmetry");
    let half = |sign: f64| Quantity {
        value: ratio.value + sign * asymmetry.map_or(0.0, |own| 0.5 * own.value),
        was: ratio.was.map(|was| {
            let own = asymmetry.and_then(|own| own.was);
            was + sign * 0.5 * own.unwrap_or(0.0)
        }),
        ..ratio
    };
    let kept = |slip: Quantity| slip.map(|slip| 1.0 - slip).text();
    let travel = if asymmetry.is_some() {
        let [left, right] = [half(-1.0), half(1.0)].map(kept);
        format!("{left} (left) and {right} (right)")
    } else {
        kept(ratio)
    };
    Some(vec![
        "keep wheel_radius and its multipliers: the floor takes this, not the wheels".to_owned(),
        format!("multiply the measured travel of the wheels by {travel} on this floor"),
    ])
}

pub(super) fn encoder_scale(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let [left, right] = sides(finding, ["left_scale", "right_scale"])?;
    let first = match setup.counts_per_turn {
        Some(counts) => {
            let [left, right] = [left, right].map(|own| own.map(|scale| scale * counts).text());
            format!(
                "set counts per turn to {left} (left) and {right} (right) in the hardware interface"
            )
        }
        None => format!(
            "divide the measured wheel angles by {} (left) and {} (right) in the hardware interface",
            left.text(),
            right.text()
        ),
    };
    let cause = cause(finding).map(|cause| format!("look for the mistake: {cause}"));
    let last = "keep wheel_radius and its multipliers: they would correct the commands too";
    Some(cause.into_iter().chain([first, last.to_owned()]).collect())
}

pub(super) fn pose_offset(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let place = match (Quantity::of(finding, "x_m"), Quantity::of(finding, "y_m")) {
        (Some(x), Some(y)) => Some([x.map(|x| x + setup.declared_ahead_m), y]),
        _ => None,
    };
    let yaw = Quantity::of(finding, "yaw_rad");
    let joint = |of: &dyn Fn(Quantity) -> Option<f64>| -> Option<String> {
        let word = |own: Quantity| Some(own.write(of(own)?));
        let mut words = Vec::new();
        if let Some([x, y]) = place {
            words.push(format!("xyz=\"{} {} 0\"", word(x)?, word(y)?));
        }
        if let Some(yaw) = yaw {
            words.push(format!("rpy=\"0 0 {}\"", word(yaw)?));
        }
        Some(words.join(" ")).filter(|words| !words.is_empty())
    };
    let now = joint(&|own| Some(own.value))?;
    let was = joint(&|own| own.was).filter(|was| *was != now);
    let was = was.map_or_else(String::new, |was| format!(" (was {was})"));
    let from = if place.is_some() {
        ", from the middle of the axle"
    } else {
        ""
    };
    Some(vec![format!(
        "set the joint of the camera or laser to {now}{was}{from}"
    )])
}

/// The numbers of both wheels.
fn sides(finding: &Finding, names: [&str; 2]) -> Option<[Quantity; 2]> {
    let [left, right] = names.map(|name| Quantity::of(finding, name));
    Some([left?, right?])
}
