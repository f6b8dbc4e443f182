//! Names and colours of the stages of a position's latency.

use crate::parts::short;

/// What a stage is called.
pub(crate) fn stage_name(stage: &str) -> &'static str {
    match stage {
        "sample_wait" => "Wait for the sender's tick",
        "compute" => "Compute",
        "transport" => "Transport",
        "injected_delay" => "Link delay, set",
        "outer_wait" => "Wait for the follower's outer tick",
        "inner_wait" => "Wait for its inner tick",
        "end_to_end" => "Encoder to torque",
        _ => "Wait for the plant step",
    }
}

/// Class of a stage's colour: a delay that was set, waiting, or work.
pub(crate) fn stage_class(stage: &str) -> &'static str {
    match stage {
        "injected_delay" => "sn",
        "compute" | "transport" => "sw-i",
        _ => "sw-w",
    }
}

/// Milliseconds with two digits that count.
pub(crate) fn ms(seconds: f64) -> String {
    let ms = 1000.0 * seconds;
    if ms.abs() < 1e-4 {
        "0".to_owned()
    } else {
        short(ms)
    }
}
