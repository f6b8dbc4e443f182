//! Numbers that no robot has. They are refused where they are read, before a sum or a square of them
//! makes everything else meaningless.

/// Largest time (s), of either sign: what fits into 64 bits of nanoseconds.
const MAX_TIME_S: f64 = i64::MAX as f64 / 1e9;
/// Largest number of any other column in its unit, of either sign: a million kilometres, 300 years at a
/// turn per minute. Small numbers have no limit: 1e-300 is as harmless as 0. Nor have counts.
const MAX_NUMBER: f64 = 1e9;

/// Whether a time (s) can be represented.
pub(crate) fn is_time(t_s: f64) -> bool {
    t_s.abs() <= MAX_TIME_S
}

/// Why a finite number cannot be in this column, as a remedy; `None` if it can.
pub(crate) fn out_of_range(column: &str, number: f64) -> Option<&'static str> {
    if column.starts_with("t_") {
        (!is_time(number)).then_some("give seconds, at most 9.2e9")
    } else {
        let is_small = number.abs() <= MAX_NUMBER;
        (!is_small).then_some("give at most 1e9, in the unit of the column's name")
    }
}

/// The numbers of a stream in a bag that are read as empty cells because they are out of range.
#[derive(Debug, Default)]
pub(crate) struct OutOfRange(u64);

impl OutOfRange {
    /// The cell for a number of a message. NaN and infinite numbers are empty cells, too, as ROS messages
    /// mark what was not measured.
    pub(crate) fn cell(&mut self, column: &str, number: f64) -> f64 {
        if !number.is_finite() {
            return f64::NAN;
        }
        if out_of_range(column, number).is_some() {
            self.0 += 1;
            return f64::NAN;
        }
        number
    }

    /// A warning that names the stream, if there were any.
    pub(crate) fn warn(&self, stream: &str, warnings: &mut Vec<String>) {
        if self.0 > 0 {
            let count = self.0;
            warnings.push(format!(
                "{stream}: {count} numbers are larger than 1e9, which no robot has; read as empty cells"
            ));
        }
    }
}
