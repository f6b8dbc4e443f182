//! Experiments that show an effect.

use slipstream_sim::effects::find;

/// The manoeuvre whose recording shows an effect, or tells several apart.
pub fn manoeuvre(effects: &[&str]) -> String {
    if effects.len() > 1 && effects.iter().all(|own| own.ends_with("_latency")) {
        // no motion tells which of two streams is late
        let third = if effects.contains(&"imu_latency") {
            "pose"
        } else {
            "gyro"
        };
        return format!("a command or a {third} in the recording");
    }
    let mut all: Vec<&str> = effects.iter().map(|effect| of(effect)).collect();
    all.dedup();
    all.join("; ")
}

fn of(effect: &str) -> &'static str {
    find(effect).map_or(
        "stop-and-go, spin in place and coast-down in one recording",
        |info| info.manoeuvre.words(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

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
