//! Real-time scheduling: SCHED_FIFO priority, locked memory, smallest timer slack.

use serde::{Deserialize, Serialize};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Which real-time measures the system granted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct RealTime {
    /// SCHED_FIFO: ordinary threads do not delay the loop.
    pub fifo: bool,
    /// The memory is locked: the loop does not wait for page faults.
    pub locked: bool,
}

impl RealTime {
    /// The measures granted to both.
    #[must_use]
    pub fn both(self, other: Self) -> Self {
        Self {
            fifo: self.fifo && other.fifo,
            locked: self.locked && other.locked,
        }
    }

    /// Requests all measures for this thread, with the given priority, and returns what was
    /// granted.
    pub fn request(priority: u8) -> Self {
        let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
        let fifo = ThreadPriority::Crossplatform(match priority.try_into() {
            Ok(priority) => priority,
            Err(_) => return Self::default(),
        });
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        Self {
            fifo: set_thread_priority_and_policy(thread_native_id(), fifo, policy).is_ok(),
            locked: rustix::mm::mlockall(rustix::mm::MlockAllFlags::CURRENT).is_ok(),
        }
    }
}
