//! Columns of the files about the whole recording.

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
