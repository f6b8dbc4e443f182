//! Watchdog of a follower: without a fresh position in time, the desired speed ramps down to zero.

use slipstream_bus::experiment::{Control, Experiment};
use slipstream_bus::time::ns_from_s;

use crate::controller::DesiredTwist;

/// The watchdog of one robot.
#[derive(Debug, Clone)]
pub(super) struct Watchdog {
    /// Longest time without a fresh position (ns).
    timeout_ns: i64,
    /// Begin of the coordination (ns); no position is expected before.
    start_ns: i64,
    /// Outer tick at which the last fresh position arrived (ns).
    fresh_ns: i64,
    fired: bool,
}

impl Watchdog {
    /// The watchdog of an experiment. It fires when a position is overdue by `control.watchdog_s`
    /// beyond the expected duration of a token round.
    pub(super) fn new(experiment: &Experiment) -> Self {
        let settings = &experiment.settings;
        let expected_ns = settings.expected_token_round_ns(experiment.longest_trace_ns());
        Self {
            timeout_ns: expected_ns + ns_from_s(settings.control.watchdog_s),
            start_ns: ns_from_s(settings.formation.start_s),
            fresh_ns: 0,
            fired: false,
        }
    }

    /// Restarts the timeout: a fresh position arrived at `now_ns`.
    pub(super) fn reset(&mut self, now_ns: i64) {
        self.fresh_ns = now_ns;
    }

    /// Whether the watchdog has fired.
    pub(super) fn fired(&self) -> bool {
        self.fired
    }

    /// Checks the timeout of a follower. While it is exceeded, replaces the desired velocities: the
    /// last desired speed, `last_v` (m/s), decelerates, and the yaw rate is 0.
    pub(super) fn check(
        &mut self,
        now_ns: i64,
        follows: bool,
        last_v: f64,
        control: &Control,
        desired: &mut DesiredTwist,
    ) {
        let since_ns = self.fresh_ns.max(self.start_ns);
        self.fired = follows && now_ns - since_ns > self.timeout_ns;
        if self.fired {
            let decrease = control.watchdog_deceleration_m_s2 * control.outer_period_s;
            desired.v = last_v.signum() * (last_v.abs() - decrease).max(0.0);
            desired.w = 0.0;
        }
    }
}
