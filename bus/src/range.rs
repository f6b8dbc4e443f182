//! Physical ranges of all numbers that people give, and their checks.
//!
//! The bounds are generous: outside of them no robot on a floor lies, and the plant's arithmetic
//! could leave the finite numbers. Each stands here once, with its reason.

use crate::error::InputError;

/// A range of numbers, both ends included.
pub type Range = [f64; 2];

/// Lengths above 0 (m): from a tenth of a millimetre, less than any wheel, to a kilometre.
pub const LENGTH_M: Range = [1e-4, 1e3];
/// Positions along the robot (m), of either sign.
pub const OFFSET_M: Range = [-1e3, 1e3];
/// Heights (m): from the floor to a kilometre.
pub const HEIGHT_M: Range = [0.0, 1e3];
/// Masses of a body (kg): from a tenth of a gram to a thousand tonnes.
pub const MASS_KG: Range = [1e-4, 1e6];
/// Masses of parts that a model may neglect (kg).
pub const PART_MASS_KG: Range = [0.0, 1e6];
/// Inertias (kg m²): the smallest mass at 0.1 mm, up to the largest mass at a kilometre.
pub const INERTIA_KG_M2: Range = [1e-12, 1e12];
/// Inertias of parts that a model may neglect (kg m²).
pub const PART_INERTIA_KG_M2: Range = [0.0, 1e12];
/// Voltages of a motor (V): from a millivolt to those of a railway.
pub const VOLTAGE_V: Range = [1e-3, 1e5];
/// Speeds of a motor (rad/s): from three turns an hour to beyond any turbine.
pub const MOTOR_SPEED_RAD_S: Range = [1e-3, 1e6];
/// Torques of a motor (N m): from below a watch's to above a ship's.
pub const MOTOR_TORQUE_NM: Range = [1e-9, 1e6];
/// Commanded torques (N m).
pub const TORQUE_NM: Range = [-1e6, 1e6];
/// Commanded speeds (m/s): three times that of sound.
pub const SPEED_M_S: Range = [-1e3, 1e3];
/// Commanded yaw rates (rad/s): 1600 turns a second.
pub const YAW_RATE_RAD_S: Range = [-1e4, 1e4];
/// Accelerations (m/s²): from imperceptible to a hundred times gravity.
pub const ACCELERATION_M_S2: Range = [1e-6, 1e3];
/// Yaw accelerations (rad/s²): as accelerations, at 10 cm from the middle.
pub const YAW_ACCELERATION_RAD_S2: Range = [1e-5, 1e4];
/// Friction coefficients (1): from below ice to above drag-racing tyres.
pub const FRICTION: Range = [1e-3, 10.0];
/// Gains that may be 0 (SI): a loop of 10 µs cannot use more.
pub const GAIN_OR_NONE: Range = [0.0, 1e6];
/// Gains (SI).
pub const GAIN: Range = [1e-9, 1e6];
/// Times on the axis of a run (s): from its start to four months.
pub const TIME_S: Range = [0.0, 1e7];
/// Durations of a run (s): from its shortest step to 11 days.
pub const DURATION_S: Range = [1e-5, 1e6];
/// Periods of loops (s): from 10 µs, the limit of a real-time system, to 10 s.
pub const PERIOD_S: Range = [1e-5, 10.0];
/// Timeouts (s): from a microsecond to four months.
pub const TIMEOUT_S: Range = [1e-6, 1e7];
/// Times after which a silent process counts as hung (s): a busy machine may hold one up for less
/// than half a second.
pub const WATCHDOG_S: Range = [0.5, 1e7];
/// Silences after which a host of a run counts as lost (s): frames come four times a second at least.
pub const HOST_TIMEOUT_S: Range = [1.0, 1e7];
/// Delays of messages (s): no network keeps one for three hours.
pub const DELAY_S: Range = [0.0, 1e4];
/// Mean lengths of loss bursts (messages): from single losses to a run's worth.
pub const BURST: Range = [1.0, 1e6];
/// Sampling rates of a sensor (1/s): from one in a quarter of an hour to that of a step of 10 µs.
pub const RATE_HZ: Range = [1e-3, 1e5];
/// Standard deviations of a sensor (m, rad, m/s² or rad/s).
pub const NOISE: Range = [0.0, 1e3];
/// Latencies of a sensor (s).
pub const SENSOR_LATENCY_S: Range = [0.0, 10.0];
/// Fractions, 0 and 1 included.
pub const FRACTION: Range = [0.0, 1.0];

/// Accepts values of a range, and so no NaN.
///
/// # Errors
/// The value is outside of the range.
pub fn within(key: &str, value: f64, [low, high]: Range) -> Result<(), InputError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let remedy = format!("give a number from {} to {}", brief(low), brief(high));
    invalid(key, format!("is {}", brief(value)), remedy)
}

/// The error of a key as a result, for `return invalid(…)`.
pub(crate) fn invalid<T>(
    key: &str,
    problem: impl Into<String>,
    remedy: impl Into<String>,
) -> Result<T, InputError> {
    Err(InputError::new(key, problem, remedy))
}

/// The number in few characters: with an exponent if it is very large or very small.
fn brief(value: f64) -> String {
    let plain = value == 0.0 || (1e-4..1e7).contains(&value.abs());
    if plain || !value.is_finite() {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_key_value_and_bounds_in_few_characters() {
        let error = |value| within("a.b_m", value, LENGTH_M).unwrap_err().to_string();
        let remedy = "give a number from 0.0001 to 1000";
        assert_eq!(error(1e300), format!("a.b_m: is 1e300; {remedy}"));
        assert_eq!(error(-0.5), format!("a.b_m: is -0.5; {remedy}"));
        assert_eq!(error(f64::NAN), format!("a.b_m: is NaN; {remedy}"));
        assert_eq!(within("a.b_m", 1e3, LENGTH_M), Ok(()));
    }
}
