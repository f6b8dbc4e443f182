//! When frames are sent again, and for how long a host may be silent.

use std::time::{Duration, Instant};

/// Longest wait for the network at once, between two checks whether the run goes on.
pub(crate) const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Time after which a frame without an answer is sent again.
pub(crate) const RESEND: Duration = Duration::from_millis(200);
/// On the wall clock: longest time that something new waits at either end.
pub(crate) const NEWS_INTERVAL: Duration = Duration::from_micros(250);
/// Interval at which a host asks for the time once its clock is known.
pub(crate) const TIME_INTERVAL: Duration = Duration::from_millis(20);
/// Real-time priority of the two ends on the wall clock: between agents and plant.
pub(crate) const PRIORITY: u8 = 25;
/// Time without any other frame after which a host shows that it lives.
const BEAT_INTERVAL: Duration = Duration::from_millis(250);

/// When the other side was last heard, and when it was last sent a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact {
    heard: Instant,
    sent: Instant,
}

impl Contact {
    /// The other side was heard just now.
    pub(crate) fn now() -> Self {
        let now = Instant::now();
        Self {
            heard: now,
            sent: now,
        }
    }

    /// A frame came.
    pub(crate) fn heard(&mut self) {
        self.heard = Instant::now();
    }

    /// A frame was sent.
    pub(crate) fn sent(&mut self) {
        self.sent = Instant::now();
    }

    /// How long the other side has been silent.
    pub(crate) fn silence(&self) -> Duration {
        self.heard.elapsed()
    }

    /// What is wrong if the other side has been silent for longer than `timeout` (`host_timeout_s`).
    pub(crate) fn too_silent(&self, timeout: Duration) -> Option<String> {
        let silence = self.silence();
        (silence > timeout).then(|| {
            format!(
                "it has been silent for {:.1} s: the network, its computer or its process stands still \
                 (host_timeout_s = {})",
                silence.as_secs_f64(),
                timeout.as_secs_f64()
            )
        })
    }

    /// Whether it is time to show that this side lives.
    pub(crate) fn beat_is_due(&self) -> bool {
        self.sent.elapsed() >= BEAT_INTERVAL
    }

    /// Whether it is time to send the last frame again.
    pub(crate) fn resend_is_due(&self) -> bool {
        self.sent.elapsed() >= RESEND
    }
}
