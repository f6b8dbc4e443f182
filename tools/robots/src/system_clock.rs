//! Time of the system, which ROS stamps messages with.

use std::time::{SystemTime, UNIX_EPOCH};

/// Time of the system (ns since 1970).
pub(crate) fn system_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| {
        i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
    })
}
