//! Points of lines and ways.

/// Points of a line: horizontal and vertical value.
pub type Points = Vec<(f64, f64)>;
/// A way on the floor: time (s), x and y (m).
pub type Way = Vec<(f64, f64, f64)>;
