//! Experiments that show an effect.

/// The manoeuvre whose recording shows an effect, or tells several apart.
pub fn manoeuvre(effects: &[&str]) -> String {
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
    fn every_effect_has_a_manoeuvre() {
        for info in slipstream_sim::effects::CATALOGUE {
            assert_ne!(of(info.id), of("none"), "{}", info.id);
        }
    }

    #[test]
    fn one_manoeuvre_for_two_is_told_once() {
        let both = manoeuvre(&["viscous_drag", "rolling_resistance"]);
        assert_eq!(both, manoeuvre(&["viscous_drag"]));
        assert_eq!(
            manoeuvre(&["push", "viscous_drag"]),
            format!("{}; {both}", of("push"))
        );
    }
}
