//! Progress on standard error, hidden if that is not a terminal.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::print::prints;

/// Interval at which the line is redrawn.
const TICK: Duration = Duration::from_millis(100);

/// A bar that counts to `count`. `done` says what happened to the counted items, such as "diagnosed".
pub(crate) fn bar(count: usize, done: &str) -> ProgressBar {
    if !prints().progress {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(count as u64);
    let template = format!("{{wide_bar}} {{pos}}/{{len}} {done}, {{eta}} left");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar
}

/// A line that shows the current step, for work of unknown length.
pub(crate) fn line() -> ProgressBar {
    if !prints().progress {
        return ProgressBar::hidden();
    }
    let line = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{elapsed:>4} {wide_msg}") {
        line.set_style(style);
    }
    line.enable_steady_tick(TICK);
    line
}
