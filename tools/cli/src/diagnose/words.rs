//! Words of a diagnosis.

use slipstream_diagnose::{Verdict, Warning};

/// The verdict as a sentence.
pub(super) fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Match => "The model matches the recording: nothing beyond the noise",
        Verdict::Explained => "What the model leaves out explains the recording",
        Verdict::Unexplained => "Something remains that the catalogue does not explain",
    }
}

/// What about a recording makes the answer poorer, in one line.
pub(super) fn warning(warning: &Warning) -> String {
    let robot = warning.robot.as_deref().unwrap_or("all robots");
    let (name, what, remedy) = (&warning.recording, &warning.statement, &warning.remedy);
    format!("{name}, {robot}: {what}; {remedy}")
}

/// A number with four digits that count.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    let before = if size >= 1.0 {
        size.log10().floor() as usize + 1
    } else {
        0
    };
    let after = if before > 0 {
        4_usize.saturating_sub(before)
    } else {
        leading(size) + 4
    };
    let text = format!("{value:.after$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Zeros behind the point before the first digit that counts.
fn leading(size: f64) -> usize {
    if size == 0.0 {
        0
    } else {
        (-size.log10()).floor().max(0.0) as usize
    }
}

/// The manoeuvre whose recording shows an effect, or tells several apart.
pub(super) fn manoeuvre(effects: &[&str]) -> String {
    let mut all: Vec<&str> = effects.iter().map(|effect| of(effect)).collect();
    all.dedup();
    all.join("; ")
}

fn of(effect: &str) -> &'static str {
    match effect {
        "viscous_drag" | "quadratic_drag" | "rolling_resistance" => {
            "coast-down: drive straight at the highest speed, then command nothing until it stands"
        }
        "axle_friction" | "torque_speed_droop" => {
            "lifted wheels: the same commands with the wheels off the floor show what sits in the drive train"
        }
        "motor_gain" | "payload" | "load_transfer" => {
            "known added mass: the same commands with a weighed mass at a measured place"
        }
        "supply_sag" => "stop-and-go over several minutes with the same commands again and again",
        "actuator_delay" | "actuator_lag" | "command_dead_band" | "command_saturation"
        | "backlash" => {
            "stop-and-go: steps of the command from the smallest to the largest, in both directions"
        }
        "yaw_scrub" | "track_width" | "caster_drag" | "pose_offset" => {
            "spin in place: several turns left and several right"
        }
        "floor_slope" => "known ramp, or the same line driven in four directions",
        "wheel_radius" | "encoder_scale" => {
            "ten hand-turned revolutions of each wheel with the encoders read (scale of the counts), then a measured straight line (radius)"
        }
        "wheel_slip" | "friction_patch" => {
            "stop-and-go with commands that rise until the wheels slip, at several places of the floor"
        }
        "pose_latency" | "wheels_latency" | "imu_latency" | "clock_drift" => {
            "stop-and-go with encoders, camera and commands recorded: sharp starts mark every clock, over minutes its drift"
        }
        "link_delay" => "stop-and-go of the robot in front, with both robots in the camera's view",
        "push" => "the same commands again, with nobody near",
        _ => "stop-and-go, spin in place and coast-down in one recording",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.236_14, "0.2361"),
            (0.001_234_56, "0.001235"),
            (-9.1, "-9.1"),
            (1234.56, "1235"),
            (1.02, "1.02"),
            (3e-7, "3.00e-7"),
            (120.0, "120"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn every_effect_has_a_manoeuvre() {
        for info in slipstream_sim::effects::CATALOGUE {
            assert_ne!(of(info.id), of("none"), "{}", info.id);
        }
    }
}
