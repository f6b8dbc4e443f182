//! From the command to the wheel.

use super::quantity::{Quantity, into_model};
use crate::Finding;
use crate::setup::{Setup, Told};

pub(super) fn delay(finding: &Finding) -> Option<Vec<String>> {
    let delay = Quantity::of(finding, "delay_s")?;
    Some(vec![
        format!("apply commands {} s late in the simulator", delay.text()),
        format!(
            "predict the state {} s ahead in the controller",
            delay.now()
        ),
    ])
}

pub(super) fn lag(finding: &Finding) -> Option<Vec<String>> {
    let lag = Quantity::of(finding, "time_constant_s")?;
    Some(vec![
        format!(
            "pass commands through a first-order lag of {} s in the simulator",
            lag.text()
        ),
        format!(
            "keep the gains of outer loops well below {:.1} 1/s",
            1.0 / lag.value
        ),
    ])
}

pub(super) fn gain(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let [left, right] = ["left", "right"].map(|name| Quantity::of(finding, name));
    let what = setup.told.of_wheel();
    let place = if setup.told.is_speed() {
        format!(" {}", setup.driver())
    } else {
        String::new()
    };
    let mut actions = vec![format!(
        "divide the {what} command of the left wheel by {} and that of the right by {}{place}",
        left?.text(),
        right?.text()
    )];
    if setup.told.is_speed() && setup.has_wheels {
        let keep = "keep the wheel radii: other ones would change odometry, which is right";
        actions.push(keep.to_owned());
    }
    Some(actions)
}

pub(super) fn supply_sag(finding: &Finding) -> Option<Vec<String>> {
    let rate = Quantity::of(finding, "rate_per_s")?;
    Some(vec![
        "charge or replace the battery, or regulate the supply of the motors".to_owned(),
        format!(
            "let the strength of the drive fall by {} of it per second in the simulator",
            rate.text()
        ),
    ])
}

pub(super) fn dead_band(finding: &Finding) -> Option<Vec<String>> {
    let (what, unit, size) = of_command(finding)?;
    Some(vec![
        format!(
            "command each wheel a {what} of 0 or more than {} {unit} in size",
            size.text()
        ),
        into_model(finding)?,
    ])
}

pub(super) fn dead_zone(finding: &Finding) -> Option<Vec<String>> {
    let (what, unit, size) = of_command(finding)?;
    Some(vec![
        format!(
            "add {} {unit} to the {what} command of each wheel, with its sign, before it is divided by a \
             motor gain",
            size.text()
        ),
        into_model(finding)?,
    ])
}

pub(super) fn saturation(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let (what, unit, size) = of_command(finding)?;
    let keep = format!(
        "keep the {what} command of each wheel below {} {unit} in size",
        size.text()
    );
    let mut actions = vec![keep];
    if setup.told == Told::Twist && what == "speed" {
        let body = &setup.model.robot;
        let most = size.map(|speed| speed * body.wheel_radius_m);
        let half_track_m = body.half_track_m;
        actions.push(match setup.has_ros {
            true => format!(
                "set linear.x.max_velocity to {} or less in diff_drive_controller, and plan |v| + {half_track_m} |w| \
                 below that",
                most.now()
            ),
            false => format!("plan |v| + {half_track_m} |w| below {} m/s", most.now()),
        });
    }
    actions.push(into_model(finding)?);
    Some(actions)
}

pub(super) fn droop(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let droop = Quantity::of(finding, "coefficient")?;
    let of_joints = of_joints("damping", &droop.text(), "N m s/rad", setup);
    Some(
        of_joints
            .into_iter()
            .chain([into_model(finding)?])
            .collect(),
    )
}

pub(super) fn axle_friction(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let torque = Quantity::of(finding, "torque_nm")?;
    let of_joints = of_joints("friction", &torque.text(), "N m", setup);
    let clean = "clean and oil the bearings of the wheels".to_owned();
    Some(
        of_joints
            .into_iter()
            .chain([clean, into_model(finding)?])
            .collect(),
    )
}

/// An attribute of the wheel joints in a URDF.
fn of_joints(attribute: &str, value: &str, unit: &str, setup: &Setup<'_>) -> Option<String> {
    setup
        .has_ros
        .then(|| format!("set {attribute}=\"{value}\" in <dynamics> of both wheel joints ({unit})"))
}

pub(super) fn backlash(finding: &Finding) -> Option<Vec<String>> {
    let gap = Quantity::of(finding, "gap_rad")?;
    Some(vec![
        format!(
            "tighten or replace gears and couplings until the play of {} rad is gone",
            gap.text()
        ),
        into_model(finding)?,
    ])
}

/// What is commanded, its unit and its size, whichever of the alternatives a finding has.
fn of_command(finding: &Finding) -> Option<(&'static str, &'static str, Quantity)> {
    let alternatives = [
        ("torque_nm", "torque", "N m"),
        ("voltage_v", "voltage", "V"),
        ("speed_rad_s", "speed", "rad/s"),
    ];
    alternatives
        .into_iter()
        .find_map(|(name, what, unit)| Some((what, unit, Quantity::of(finding, name)?)))
}
