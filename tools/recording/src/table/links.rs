//! Columns of the two tables that belong to no robot.

/// Columns of `links.csv`.
pub(crate) const LINK_COLUMNS: [&str; 9] = [
    "t_sent_s",
    "t_received_s",
    "from",
    "to",
    "x_m",
    "y_m",
    "yaw_rad",
    "v_m_s",
    "w_rad_s",
];

/// The first so many of [`LINK_COLUMNS`] are required; the velocities after them are optional.
pub(crate) const LINK_POSE_COLUMNS: usize = 7;

/// Columns of `rtt.csv`.
pub(crate) const ROUND_TRIP_COLUMNS: [&str; 2] = ["seq", "rtt_ms"];

/// Number of columns of `links.csv` with or without velocities.
pub(crate) fn link_columns(with_velocity: bool) -> usize {
    if with_velocity {
        LINK_COLUMNS.len()
    } else {
        LINK_POSE_COLUMNS
    }
}
