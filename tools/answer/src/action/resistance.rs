//! Friction, drag, load and slope: what acts on the body and under the wheels.

use slipstream_sim::breakaway_nm;

use super::quantity::{Quantity, into_model};
use crate::Finding;
use crate::setup::{Setup, Told};

pub(super) fn wheel_slip(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    let friction = Quantity::of(finding, "friction_static");
    let most = friction.and_then(|own| {
        let torque = |friction: f64| breakaway_nm(setup.model, friction);
        torque(own.value)?;
        Some(own.map(|friction| torque(friction).unwrap_or(f64::NAN)))
    });
    let mut actions = vec!["clean the wheels and the floor".to_owned()];
    if let Some(most) = most {
        let how = match setup.told {
            Told::Torque => "command each wheel less than",
            _ => "keep accelerations so low that each wheel needs less than",
        };
        actions.push(format!("{how} {} N m", most.text()));
    }
    actions.push(into_model(finding)?);
    Some(actions)
}

pub(super) fn friction_patch(finding: &Finding) -> Option<Vec<String>> {
    let [x, y, radius] = ["x_m", "y_m", "radius_m"].map(|name| Quantity::of(finding, name));
    Some(vec![
        format!(
            "clean the floor within {} m of ({}, {}) m, or keep the wheels off it",
            radius?.now(),
            x?.now(),
            y?.now()
        ),
        into_model(finding)?,
    ])
}

pub(super) fn rolling_resistance(finding: &Finding) -> Option<Vec<String>> {
    with_model(
        finding,
        "check tyres, bearings and floor, which take this force",
    )
}

pub(super) fn drag(finding: &Finding) -> Option<Vec<String>> {
    with_model(finding, "look for what drags: a cable, a brush, a belt")
}

pub(super) fn caster_drag(finding: &Finding) -> Option<Vec<String>> {
    with_model(finding, "clean the caster until it turns and rolls freely")
}

pub(super) fn yaw_scrub(finding: &Finding) -> Option<Vec<String>> {
    with_model(
        finding,
        "look for what scrubs in turns: wide tyres, a stiff caster",
    )
}

pub(super) fn floor_slope(finding: &Finding) -> Option<Vec<String>> {
    let [grade, downhill] = ["grade", "downhill_rad"].map(|name| Quantity::of(finding, name));
    let (angle, downhill) = (grade?.map(f64::atan), downhill?);
    Some(vec![
        format!(
            "tilt the floor of the simulator by {} rad, downhill towards {} rad from the x axis",
            angle.text(),
            downhill.text()
        ),
        into_model(finding)?,
    ])
}

pub(super) fn load_transfer(finding: &Finding) -> Option<Vec<String>> {
    let height = Quantity::of(finding, "com_height_m")?;
    Some(vec![
        format!(
            "put the centre of mass {} m above the floor in the model",
            height.text()
        ),
        into_model(finding)?,
    ])
}

pub(super) fn payload(finding: &Finding) -> Option<Vec<String>> {
    let [mass, x, y] = ["mass_kg", "x_m", "y_m"].map(|name| Quantity::of(finding, name));
    Some(vec![
        format!(
            "add a point mass of {} kg to the model at x = {} m, y = {} m from the centre of mass",
            mass?.text(),
            x?.text(),
            y?.text()
        ),
        into_model(finding)?,
    ])
}

/// The line of the model, and what to do on the machine.
fn with_model(finding: &Finding, machine: &str) -> Option<Vec<String>> {
    Some(vec![into_model(finding)?, machine.to_owned()])
}
