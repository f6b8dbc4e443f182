//! What to do about a finding.

use slipstream_bus::RobotModel;
use slipstream_diagnose::Finding;

use crate::parts::{digits_of, fixed};

/// What to do about a finding, as an imperative.
pub fn action(finding: &Finding, model: Option<&RobotModel>) -> String {
    let get = |name: &str| {
        let own = finding.parameters.iter().find(|p| p.name == name);
        own.and_then(|own| own.estimate)
    };
    let digits = |name: &str| {
        let own = finding.parameters.iter().find(|p| p.name == name);
        own.and_then(|own| own.ci95).map_or(3, digits_of)
    };
    let number = |name: &str| {
        let own = get(name).map(|value| format!("{value:.*}", digits(name)));
        own.unwrap_or_default()
    };
    let shift = |what: &str, name: &str| {
        let late_s = get(name).unwrap_or(0.0);
        let side = if late_s > 0.0 { "earlier" } else { "later" };
        format!("Stamp the {what} {:.3} s {side}", late_s.abs())
    };
    match finding.effect.as_str() {
        "pose_offset" => {
            let yaw = get("yaw_rad").map(|_| format!(" rpy=\"0 0 {}\"", number("yaw_rad")));
            format!(
                "Set its joint to xyz=\"{} {} 0\"{}",
                number("x_m"),
                number("y_m"),
                yaw.unwrap_or_default()
            )
        }
        "wheel_radius" => format!(
            "Set right_wheel_radius_\u{200b}multiplier to {}, left to {}",
            number("right_scale"),
            number("left_scale")
        ),
        "track_width" => format!(
            "Set wheel_separation_\u{200b}multiplier to {}",
            number("scale")
        ),
        "encoder_scale" => match model.and_then(|own| own.encoder.as_ref()) {
            Some(encoder) => {
                let counts = |name: &str| {
                    get(name).map_or_else(String::new, |factor| {
                        fixed(f64::from(encoder.counts_per_rev) * factor, 1)
                    })
                };
                format!(
                    "Set the counts per turn to {} (right) and {} (left)",
                    counts("right_scale"),
                    counts("left_scale")
                )
            }
            None => "Correct the counts per turn by these factors".to_owned(),
        },
        "pose_latency" => shift("poses", "latency_s"),
        "wheels_latency" => shift("wheels", "latency_s"),
        "imu_latency" => shift("IMU", "latency_s"),
        "clock_drift" => "Let both computers follow one clock (chrony, PTP)".to_owned(),
        "actuator_delay" => format!(
            "Let the simulator apply commands {} s late",
            number("delay_s")
        ),
        "motor_gain" => "Divide each wheel's command by its factor".to_owned(),
        "command_dead_zone" => "Add this size to each command, with its sign".to_owned(),
        "slip_ratio" => "Count it to the floor: keep the radii".to_owned(),
        "push" => "Leave this moment out (--exclude-time)".to_owned(),
        "unknown" => "Use the law of --improved, or look for what acts there".to_owned(),
        _ => "Put the line below into robot.toml".to_owned(),
    }
}
