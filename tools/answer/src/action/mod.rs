//! What to do about a finding: what to type or turn, in short imperative texts.

mod drive;
mod geometry;
mod outside;
mod quantity;
mod resistance;
mod stamps;

use slipstream_bus::RobotModel;
use slipstream_recording::Recording;

use super::setup::Setup;
use super::{Answer, Finding, manoeuvre};

/// Says for every finding what to do about it.
pub fn advise(answer: &mut Answer, improved: &[(String, RobotModel)], recordings: &[Recording]) {
    for finding in &mut answer.findings {
        let own = improved.iter().find(|(name, _)| *name == finding.robot);
        let setup = own.and_then(|(name, model)| Setup::of(name, model, recordings));
        if let Some(setup) = setup {
            finding.actions = actions(finding, &setup);
        }
    }
}

/// What to do about a finding, the most useful first.
fn actions(finding: &Finding, setup: &Setup<'_>) -> Vec<String> {
    let mut actions = of_effect(finding, setup).unwrap_or_else(|| outside::table(finding));
    if let Some(runs) = &finding.runs {
        let runs = runs.join(", ");
        for action in &mut actions {
            *action = format!("for {runs}: {action}");
        }
    }
    if !finding.confused_with.is_empty() {
        let others = finding.confused_with.join(" or ");
        let mut all = vec![finding.effect.as_str()];
        all.extend(finding.confused_with.iter().map(String::as_str));
        let which = manoeuvre(&all);
        actions.push(format!("record this to tell it from {others}: {which}"));
    }
    actions
}

/// What to do about an effect; `None` where a number is missing or nobody knows the effect.
fn of_effect(finding: &Finding, setup: &Setup<'_>) -> Option<Vec<String>> {
    match finding.effect.as_str() {
        "wheel_radius" => geometry::wheel_radius(finding, setup),
        "track_width" => geometry::track_width(finding, setup),
        "slip_ratio" => geometry::slip_ratio(finding),
        "encoder_scale" => geometry::encoder_scale(finding, setup),
        "pose_offset" => geometry::pose_offset(finding, setup),
        "pose_latency" => stamps::latency(finding, "poses"),
        "wheels_latency" => stamps::latency(finding, "wheel readings"),
        "imu_latency" => stamps::latency(finding, "IMU readings"),
        "clock_drift" => stamps::clock_drift(finding),
        "link_delay" => stamps::link_delay(finding),
        "actuator_delay" => drive::delay(finding),
        "actuator_lag" => drive::lag(finding),
        "motor_gain" => drive::gain(finding, setup),
        "supply_sag" => drive::supply_sag(finding),
        "command_dead_band" => drive::dead_band(finding),
        "command_dead_zone" => drive::dead_zone(finding),
        "command_saturation" => drive::saturation(finding, setup),
        "torque_speed_droop" => drive::droop(finding, setup),
        "axle_friction" => drive::axle_friction(finding, setup),
        "backlash" => drive::backlash(finding),
        "wheel_slip" => resistance::wheel_slip(finding, setup),
        "friction_patch" => resistance::friction_patch(finding),
        "rolling_resistance" => resistance::rolling_resistance(finding),
        "viscous_drag" | "quadratic_drag" => resistance::drag(finding),
        "caster_drag" => resistance::caster_drag(finding),
        "yaw_scrub" => resistance::yaw_scrub(finding),
        "floor_slope" => resistance::floor_slope(finding),
        "load_transfer" => resistance::load_transfer(finding),
        "payload" => resistance::payload(finding),
        "push" => outside::push(finding),
        "force_law" | "motion_law" => Some(outside::table(finding)),
        "unknown" => Some(outside::unknown(finding, setup)),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
