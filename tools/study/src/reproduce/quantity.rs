//! Names of quantities that a person reads.

/// Names by the quantity without its unit.
const NAMES: [(&str, &str); 22] = [
    ("torque_limit_nm", "Torque limit, N m"),
    (
        "torque_limit_with_load_transfer_nm",
        "Torque limit with load transfer, N m",
    ),
    (
        "wheel_acceleration_rad_s2",
        "Wheel acceleration at the limit, rad/s²",
    ),
    (
        "wheel_acceleration_with_load_transfer_rad_s2",
        "Wheel acceleration with load transfer, rad/s²",
    ),
    (
        "wheel_acceleration_with_load_transfer_and_spin_rad_s2",
        "Wheel acceleration with load transfer and spin, rad/s²",
    ),
    (
        "single_gap_without_limit_m",
        "One robot without the limit: encoder minus camera, m",
    ),
    (
        "single_gap_with_limit_m",
        "One robot with the limit: encoder minus camera, m",
    ),
    (
        "single_speed_at_end_over_speed_when_torque_ends",
        "One robot without the limit: speed at the end over speed when the torque ends",
    ),
    (
        "single_slip_after_torque_ends_s",
        "One robot without the limit: slip after the torque has ended, s",
    ),
    (
        "single_fastest_wheel_rad_s",
        "One robot without the limit: fastest wheel, rad/s",
    ),
    (
        "mean_gap_x_without_limit_m",
        "Encoder against truth without the limit, x, m",
    ),
    (
        "mean_gap_y_without_limit_m",
        "Encoder against truth without the limit, y, m",
    ),
    (
        "mean_gap_x_with_limit_m",
        "Encoder against truth with the limit, x, m",
    ),
    (
        "mean_gap_y_with_limit_m",
        "Encoder against truth with the limit, y, m",
    ),
    (
        "final_spacing_error_without_limit_m",
        "Final spacing error without the limit, m",
    ),
    (
        "final_spacing_error_with_limit_m",
        "Final spacing error with the limit, m",
    ),
    (
        "encoder_gap_with_over_without_limit",
        "Encoder against truth: with over without the limit",
    ),
    (
        "final_spacing_error_with_over_without_limit",
        "Final spacing error: with over without the limit",
    ),
    (
        "rms_spacing_error_with_over_without_limit",
        "Spacing error, root mean square: with over without the limit",
    ),
    (
        "max_spacing_error_with_over_without_limit",
        "Largest spacing error: with over without the limit",
    ),
    (
        "roughness_of_x_with_over_without_limit",
        "Roughness of x: with over without the limit",
    ),
    (
        "slip_time_with_over_without_limit",
        "Slip time: with over without the limit",
    ),
];

/// The name of a quantity.
pub(super) fn name(quantity: &str) -> String {
    let known = NAMES.iter().find(|(own, _)| *own == quantity);
    match known {
        Some((_, name)) => (*name).to_owned(),
        None => final_position(quantity).unwrap_or_else(|| quantity.to_owned()),
    }
}

/// The name of a final position, such as `final_x_r1_encoder_without_limit_m`.
fn final_position(quantity: &str) -> Option<String> {
    let rest = quantity.strip_prefix("final_")?.strip_suffix("_limit_m")?;
    let mut parts = rest.split('_');
    let (axis, robot, by, which) = (parts.next()?, parts.next()?, parts.next()?, parts.next()?);
    let by = if by == "true" {
        "in truth"
    } else {
        "by its encoders"
    };
    Some(format!(
        "Final {axis} of {robot} {by}, {which} the limit, m"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn final_positions_have_names() {
        let named = name("final_y_r3_true_with_limit_m");
        assert_eq!(named, "Final y of r3 in truth, with the limit, m");
    }
}
