//! Range checks of single values: finite, not negative, positive, inside an interval.

use crate::error::InputError;

/// Accepts every finite value.
pub(crate) fn finite(key: &str, value: f64) -> Result<(), InputError> {
    if value.is_finite() {
        return Ok(());
    }
    invalid(key, format!("is {value}"), "give a finite number")
}

/// Accepts finite values of 0 or more.
pub(crate) fn not_negative(key: &str, value: f64) -> Result<(), InputError> {
    finite(key, value)?;
    if value >= 0.0 {
        return Ok(());
    }
    invalid(key, format!("is {value}"), "give 0 or more")
}

/// Accepts finite values above 0.
pub(crate) fn positive(key: &str, value: f64) -> Result<(), InputError> {
    not_negative(key, value)?;
    if value > 0.0 {
        return Ok(());
    }
    invalid(key, "is 0", "give a number above 0")
}

/// Accepts values from `low` to `high`, both included.
pub(crate) fn within(key: &str, value: f64, [low, high]: [f64; 2]) -> Result<(), InputError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let remedy = format!("give a number from {low} to {high}");
    invalid(key, format!("is {value}"), remedy)
}

/// The error of a key as a result, for `return invalid(…)`.
pub(crate) fn invalid<T>(
    key: &str,
    problem: impl Into<String>,
    remedy: impl Into<String>,
) -> Result<T, InputError> {
    Err(InputError::new(key, problem, remedy))
}
