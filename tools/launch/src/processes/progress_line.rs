//! Progress line of a run on a terminal.

use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slipstream_bus::Settings;
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_ipc::wake_page::WakePage;

/// The progress line.
pub(super) struct ProgressLine {
    bar: ProgressBar,
    begin: Instant,
}

impl ProgressLine {
    /// A line on standard error; hidden unless `visible`.
    pub(super) fn new(visible: bool, settings: &Settings) -> Self {
        let length = u64::try_from(ns_from_s(settings.duration_s)).unwrap_or(0);
        let target = if visible {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(Some(length), target);
        if let Ok(style) = ProgressStyle::with_template("{bar:14} {msg}") {
            bar.set_style(style);
        }
        Self {
            bar,
            begin: Instant::now(),
        }
    }

    /// Draws the progress that the plant published last.
    pub(super) fn draw(&self, wake_page: &WakePage) {
        let (now_ns, speed_m_s, spacing_error_m) = wake_page.progress();
        let now_s = s_from_ns(now_ns);
        let real_time_factor = now_s / self.begin.elapsed().as_secs_f64();
        self.bar.set_position(u64::try_from(now_ns).unwrap_or(0));
        // Fits a terminal of 80 columns.
        self.bar.set_message(format!(
            "{now_s:6.2} s  {real_time_factor:5.1}x  r1 {speed_m_s:5.2} m/s  spacing error {:4.1} cm",
            spacing_error_m * 100.0
        ));
    }

    /// Prints something above the line.
    pub(super) fn suspend(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    /// Removes the line.
    pub(super) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}
