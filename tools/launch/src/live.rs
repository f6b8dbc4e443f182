//! What a person sees while a run runs: one line, and nothing where nobody looks.

use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slipstream_bus::Settings;
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_ipc::wake_page::WakePage;

/// The live line.
pub(crate) struct Live {
    bar: ProgressBar,
    begin: Instant,
}

impl Live {
    /// A line, drawn only when `wanted`.
    pub(crate) fn new(wanted: bool, settings: &Settings) -> Self {
        let length = u64::try_from(ns_from_s(settings.duration_s)).unwrap_or(0);
        let target = if wanted {
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

    /// Draws what the plant told last.
    pub(crate) fn draw(&self, wake_page: &WakePage) {
        let (now_ns, speed_m_s, spacing_error_m) = wake_page.progress();
        let now_s = s_from_ns(now_ns);
        let pace = now_s / self.begin.elapsed().as_secs_f64();
        self.bar.set_position(u64::try_from(now_ns).unwrap_or(0));
        // Fits a terminal of 80 columns.
        self.bar.set_message(format!(
            "{now_s:6.2} s  {pace:5.1}x  r1 {speed_m_s:5.2} m/s  spacing off by {:4.1} cm",
            spacing_error_m * 100.0
        ));
    }

    /// Leaves no trace of the line.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}
