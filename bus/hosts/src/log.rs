//! What the two ends of a run across hosts leave in the trace, on the wall clock.

use slipstream_bus::message::{Position, RobotIndex};

use crate::clock::ClockReport;
use crate::hello::RemoteHost;

/// A position for the robot `to` has come from another host.
pub(crate) fn crossed(position: &Position, to: RobotIndex) {
    tracing::debug!(name: "crossed", from = position.from, to, seq = position.seq);
}

/// The agents of these robots run on another host.
pub(crate) fn host(host: &RemoteHost) {
    let name = host.name.as_str();
    for &robot in &host.robots {
        tracing::info!(name: "host", host = name, robot);
    }
}

/// What is known of the clock of a host. `start_ns`: time 0 of the run on the clock of the plant's host.
pub(crate) fn clock(host: &str, start_ns: i64, report: &ClockReport) {
    let &ClockReport {
        host_ns,
        offset_ns,
        bound_ns,
        drift_ppb,
        round_trip_ns,
        error_ns,
    } = report;
    let plant_ns = host_ns.saturating_sub(offset_ns);
    let t_ns = plant_ns.saturating_sub(start_ns);
    tracing::info!(
        name: "clock", t_ns, host, offset_ns, bound_ns, drift_ppb, round_trip_ns, error_ns
    );
}
