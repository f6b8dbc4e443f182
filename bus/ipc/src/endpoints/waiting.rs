//! Bounded waiting: a wait ends when the run is stopped or the launcher is gone.

use std::time::Duration;

use rustix::process::{Pid, getppid};
use slipstream_bus::transport::BusError;

use crate::wake_page::{Stage, WakePage};

/// Interval at which a waiting process checks whether the others are alive.
pub(super) const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The parent process, that is the launcher.
#[derive(Debug, Clone, Copy)]
pub struct Parent(Option<Pid>);

impl Parent {
    /// The current parent. To be called at the start of the process, before the launcher can end.
    pub fn now() -> Self {
        Self(getppid())
    }

    /// Whether the launcher is gone, so that the process has another parent.
    pub fn is_gone(self) -> bool {
        getppid() != self.0
    }
}

/// Waits until the run has reached `stage`.
///
/// # Errors
/// [`BusError::Stopped`] if the run is stopped first or the launcher is gone.
pub fn await_stage(wake_page: &WakePage, stage: Stage, parent: Parent) -> Result<(), BusError> {
    while !wake_page.wait_stage(stage, POLL_INTERVAL) {
        check_running(wake_page, parent)?;
    }
    Ok(())
}

/// [`BusError::Stopped`] if the run was asked to stop or the launcher is gone.
pub(super) fn check_running(wake_page: &WakePage, parent: Parent) -> Result<(), BusError> {
    if wake_page.stopping() || parent.is_gone() {
        return Err(BusError::Stopped);
    }
    Ok(())
}
