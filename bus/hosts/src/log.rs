//! What the two ends of a run across hosts leave in the trace, on the wall clock.

use slipstream_bus::message::Position;
use slipstream_bus::topology::Topology;

use crate::clock::ClockReport;
use crate::hello::RemoteHost;

/// A position has come from another host.
pub(crate) fn crossed(position: &Position, topology: Topology) {
    let (from, seq) = (position.from, position.seq);
    if let Some(to) = topology.successor(from) {
        tracing::debug!(name: "crossed", from, to, seq);
    }
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
