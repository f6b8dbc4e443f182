//! A process's presence in a run: it shows that it lives, and waits only while the run goes on and
//! its launcher lives.

use std::rc::Rc;
use std::time::Duration;

use slipstream_bus::transport::BusError;

use super::parent::Parent;
use crate::clock::WallClock;
use crate::wake_page::{DEADLINE_WORDS, Member, Stage, WakePage};

/// Interval at which a waiting process shows that it lives and checks whether the others do.
pub(crate) const POLL_INTERVAL: Duration = Duration::from_millis(50);

const POLL_INTERVAL_NS: i64 = POLL_INTERVAL.as_nanos() as i64;

/// The presence of this process in a run.
#[derive(Debug, Clone)]
pub struct Presence {
    wake_page: Rc<WakePage>,
    member: Member,
    parent: Parent,
}

impl Presence {
    /// The presence of this process as `member`.
    pub fn new(wake_page: Rc<WakePage>, member: Member, parent: Parent) -> Self {
        let presence = Self {
            wake_page,
            member,
            parent,
        };
        presence.show();
        presence
    }

    /// The wake-up page of the run.
    pub fn wake_page(&self) -> &WakePage {
        &self.wake_page
    }

    /// Shows that the process lives. To be called more often than every `watchdog_s` of wall time.
    pub fn show(&self) {
        self.wake_page.beat(self.member);
    }

    /// Shows how this process keeps the deadlines of its loops, one row each.
    pub fn publish_deadlines(&self, loops: &[[i64; DEADLINE_WORDS]]) {
        self.wake_page.publish_deadlines(self.member, loops);
    }

    /// The deadlines that a process in the place of this one left; zeros if there was none.
    pub fn earlier_deadlines(&self) -> Vec<[i64; DEADLINE_WORDS]> {
        self.wake_page.deadlines(self.member)
    }

    /// Shows that the process lives, and checks that the run goes on.
    ///
    /// # Errors
    /// [`BusError::Stopped`] if the run was asked to stop or the launcher is gone.
    pub fn check(&self) -> Result<(), BusError> {
        self.show();
        if self.wake_page.stopping() {
            return Err(BusError::Stopped);
        }
        self.check_launcher()
    }

    /// Checks that the launcher lives.
    ///
    /// # Errors
    /// [`BusError::Stopped`] if it is gone.
    pub fn check_launcher(&self) -> Result<(), BusError> {
        if self.parent.is_gone() {
            return Err(BusError::Stopped);
        }
        Ok(())
    }

    /// Sleeps until the time of the run is `deadline_ns`.
    pub fn sleep_until(&self, clock: WallClock, deadline_ns: i64) {
        while clock.now_ns() < deadline_ns - POLL_INTERVAL_NS {
            clock.sleep_until(clock.now_ns() + POLL_INTERVAL_NS);
            self.show();
        }
        clock.sleep_until(deadline_ns);
    }

    /// Waits until the run has reached `stage`.
    ///
    /// # Errors
    /// [`BusError::Stopped`] if the run is stopped first or the launcher is gone.
    pub fn await_stage(&self, stage: Stage) -> Result<(), BusError> {
        while !self.wake_page.wait_stage(stage, POLL_INTERVAL) {
            self.check()?;
        }
        Ok(())
    }
}
