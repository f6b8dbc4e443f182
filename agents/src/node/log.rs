//! Log of a node: events for the recorder and the trace.

use slipstream_bus::message::{Position, RobotIndex};
use slipstream_bus::record::{EventKind, Fate, InnerTick, OuterTick, Record, Recorder};

/// Logs that a position entered the delay line; `available_ns` as returned by it.
pub(super) fn arrived(
    [from, to]: [RobotIndex; 2],
    position: &Position,
    available_ns: Option<i64>,
    recorder: &mut impl Recorder,
) {
    let (seq, sent_ns) = (position.seq, position.sent_ns);
    tracing::debug!(name: "arrived", from, to, seq, available_ns);
    recorder.record(&Record::Arrived {
        from,
        to,
        seq,
        sent_ns,
        available_ns,
    });
}

/// Logs that a position left the delay line at the outer tick `tick_ns`.
pub(super) fn taken(
    [from, to]: [RobotIndex; 2],
    seq: u32,
    tick_ns: i64,
    fate: Fate,
    recorder: &mut impl Recorder,
) {
    tracing::debug!(name: "taken", from, to, seq, tick_ns, fate = fate.name());
    recorder.record(&Record::Taken {
        from,
        to,
        seq,
        tick_ns,
        fate,
    });
}

/// Logs that a position was sent and ready for a receiver at `queued_ns`.
pub(super) fn sent(
    to: RobotIndex,
    position: Position,
    queued_ns: i64,
    recorder: &mut impl Recorder,
) {
    tracing::debug!(
        name: "sent",
        from = position.from,
        to,
        seq = position.seq,
        sampled_ns = position.sampled_ns,
        tick_ns = position.tick_ns,
        sent_ns = position.sent_ns,
        queued_ns,
    );
    recorder.record(&Record::Sent { to, position });
}

/// Logs that the front robot started a new token round without waiting for the last one.
pub(super) fn ring_restarted(t_ns: i64, recorder: &mut impl Recorder) {
    let kind = EventKind::RingRestarted;
    tracing::warn!(name: "change", robot = 0_u32, what = kind.description());
    recorder.record(&Record::Event {
        t_ns,
        robot: Some(0),
        kind,
    });
}

/// Logs a change of a condition: `kinds[0]` when it begins, `kinds[1]` when it ends. `before` is
/// the condition at the last call and is updated.
pub(super) fn change(
    before: &mut bool,
    now: bool,
    kinds: [EventKind; 2],
    robot: RobotIndex,
    t_ns: i64,
    recorder: &mut impl Recorder,
) {
    if *before != now {
        let [began, ended] = kinds;
        let kind = if now { began } else { ended };
        tracing::warn!(name: "change", t_ns, robot, what = kind.description());
        recorder.record(&Record::Event {
            t_ns,
            robot: Some(robot),
            kind,
        });
    }
    *before = now;
}

/// Logs an outer tick. Its values go to the trace at the finest level.
pub(super) fn outer(tick: &OuterTick, recorder: &mut impl Recorder) {
    recorder.record(&Record::Outer(*tick));
    let [e_x_m, e_y_m, e_theta_rad] = tick.error;
    let [x_r_m, y_r_m, theta_r_rad] = tick.reference;
    let [v_d_m_s, w_d_rad_s] = tick.desired;
    let [right_rad_s, left_rad_s] = tick.set_point_rad_s;
    tracing::trace!(
        name: "reference", robot = tick.robot, x_r_m, y_r_m, theta_r_rad, e_x_m, e_y_m, e_theta_rad,
        v_d_m_s, w_d_rad_s, right_rad_s, left_rad_s
    );
}

/// Logs an inner tick. Its values go to the trace at the finest level.
pub(super) fn inner(tick: &InnerTick, recorder: &mut impl Recorder) {
    recorder.record(&Record::Inner(*tick));
    let [right_rad_s, left_rad_s] = tick.wheel_speed_rad_s;
    let [wanted_right_nm, wanted_left_nm] = tick.wanted_nm;
    let [limit_right_nm, limit_left_nm] = tick.limit_nm;
    let [right_nm, left_nm] = tick.torque_nm;
    let [friction, friction_sd] = tick.friction;
    tracing::trace!(
        name: "torque", robot = tick.robot, right_rad_s, left_rad_s, wanted_right_nm,
        wanted_left_nm, limit_right_nm, limit_left_nm, right_nm, left_nm, friction, friction_sd
    );
}
