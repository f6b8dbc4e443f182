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
    let lengths = {
        let [left, right] = [left, right].map(|own| own.map(|scale| scale * radius_m).text());
        format!("use wheel radii of {left} m (left) and {right} m (right)")
    };
    let multipliers = format!(
        "set left_wheel_radius_multiplier to {} and right_wheel_radius_multiplier to {} in \
         diff_drive_controller",
        left.text(),
        right.text()
    );
    let places = [
        "in odometry and simulator",
        "where speeds of the body become wheel speeds",
    ];
    Some(where_used(setup, multipliers, &lengths, places))
}

pub(super) fn track_width(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let scale = Quantity::of(finding, "scale")?;
    let track_m = scale.map(|scale| 2.0 * scale * setup.model.robot.half_track_m);
    let multiplier = format!(
        "set wheel_separation_multiplier to {} in diff_drive_controller",
        scale.text()
    );
    let length = format!("use {} m between the wheels", track_m.text());
    let places = [
        "in odometry and simulator; masses and inertias stay",
        "where turn rates become wheel speeds",
    ];
    Some(where_used(setup, multiplier, &length, places))
}

/// What to do about a length: the parameter of a controller of ROS, and the length itself where others use it, with
/// forces and with speeds.
fn where_used(
    setup: &Setup<'_>,
    parameter: String,
    length: &str,
    [of_forces, of_speeds]: [&str; 2],
) -> Vec<String> {
    let itself = match setup.told {
        Told::Torque | Told::Voltage => format!("{length} {of_forces}"),
        _ => format!("{length} {of_speeds}"),
    };
    match setup.told {
        _ if !setup.has_ros => vec![itself],
        Told::Twist | Told::Nothing => vec![parameter],
        // its commands pass diff_drive_controller by
        Told::WheelSpeed => vec![parameter, itself],
        Told::Torque | Told::Voltage => vec![itself, parameter],
    }
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
        "keep the wheel radii: the floor takes this, not the wheels".to_owned(),
        format!("multiply the measured travel of the wheels by {travel} on this floor"),
    ])
}

pub(super) fn encoder_scale(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let [left, right] = sides(finding, ["left_scale", "right_scale"])?;
    let place = setup.driver();
    let first = match setup.counts_per_turn {
        Some(counts) => {
            let [left, right] = [left, right].map(|own| own.map(|scale| scale * counts).text());
            format!("set counts per turn to {left} (left) and {right} (right) {place}")
        }
        None => format!(
            "divide the measured wheel angles by {} (left) and {} (right) {place}",
            left.text(),
            right.text()
        ),
    };
    let cause = cause(finding).map(|cause| format!("look for the mistake: {cause}"));
    let last = "keep the wheel radii: other ones would change the commands too";
    Some(cause.into_iter().chain([first, last.to_owned()]).collect())
}

pub(super) fn pose_offset(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let ahead_m = setup.declared_ahead_m;
    let of = |name: &str| Quantity::of(finding, name).filter(|own| own.differs());
    let parts = [
        of("x_m").map(|x| format!("x to {} m", x.map(|x| x + ahead_m).text())),
        of("y_m").map(|y| format!("y to {} m", y.text())),
        of("yaw_rad").map(|yaw| format!("yaw to {} rad", yaw.text())),
    ];
    let is_placed = parts[..2].iter().any(Option::is_some);
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    let (last, before) = parts.split_last()?;
    let what = match before {
        [] => last.clone(),
        before => format!("{} and {last}", before.join(", ")),
    };
    let from = if is_placed {
        ", from the middle of the axle"
    } else {
        ""
    };
    Some(vec![format!(
        "set {what} in the transform of the camera or laser{from}; keep its other numbers"
    )])
}

/// The numbers of both wheels.
fn sides(finding: &Finding, names: [&str; 2]) -> Option<[Quantity; 2]> {
    let [left, right] = names.map(|name| Quantity::of(finding, name));
    Some([left?, right?])
}
