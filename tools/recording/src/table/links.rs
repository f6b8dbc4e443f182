//! Columns of the two tables that belong to no robot.

use crate::field::{Field, names};

/// Columns of `links.csv`: position messages between robots.
pub const LINKS: [Field; 9] = [
    Field::new("t_sent_s", "s", "Time of sending."),
    Field::new(
        "t_received_s",
        "s",
        "Time of arrival; empty for a message that was lost.",
    ),
    Field::new("from", "", "Robot that sent the message."),
    Field::new("to", "", "Robot that it was sent to."),
    Field::new(
        "x_m",
        "m",
        "Position in the message, first axis of the world.",
    ),
    Field::new(
        "y_m",
        "m",
        "Position in the message, second axis of the world.",
    ),
    Field::new("yaw_rad", "rad", "Heading in the message."),
    Field::new(
        "v_m_s",
        "m/s",
        "Reference speed in the message, where one was sent.",
    ),
    Field::new(
        "w_rad_s",
        "rad/s",
        "Reference turn rate in the message, where one was sent.",
    ),
];

/// Columns of `rtt.csv`: measured round trips of a network, replayed as delay of the links.
pub const ROUND_TRIPS: [Field; 2] = [
    Field::new("seq", "counts", "Number of the message."),
    Field::new(
        "rtt_ms",
        "ms",
        "Time from sending until the answer came; empty for a message without answer.",
    ),
];

/// Names of [`LINKS`].
pub(crate) const LINK_COLUMNS: [&str; 9] = names(&LINKS);

/// The first so many of [`LINK_COLUMNS`] are required; the velocities after them are optional.
pub(crate) const LINK_POSE_COLUMNS: usize = 7;

/// Names of [`ROUND_TRIPS`].
pub(crate) const ROUND_TRIP_COLUMNS: [&str; 2] = names(&ROUND_TRIPS);

/// Number of columns of `links.csv` with or without velocities.
pub(crate) fn link_columns(with_velocity: bool) -> usize {
    if with_velocity {
        LINK_COLUMNS.len()
    } else {
        LINK_POSE_COLUMNS
    }
}
