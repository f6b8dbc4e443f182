//! Streams and messages whose stamps are wrong.

use super::quantity::Quantity;
use crate::Finding;

/// `what` is the stream's readings.
pub(super) fn latency(finding: &Finding, what: &str) -> Option<Vec<String>> {
    let late = Quantity::of(finding, "latency_s")?;
    let shift = |late_s: f64| {
        let side = if late_s < 0.0 { "later" } else { "earlier" };
        format!("{} s {side}", late.write(late_s.abs()))
    };
    let now = shift(late.value);
    let was = late.was.map(shift).filter(|was| *was != now);
    let was = was.map_or_else(String::new, |was| format!(" (was {was})"));
    Some(vec![format!("stamp the {what} {now}{was}")])
}

pub(super) fn clock_drift(finding: &Finding) -> Option<Vec<String>> {
    let rate = Quantity::of(finding, "rate")?;
    let words = finding.parameters.iter();
    let stream = words.filter_map(|own| own.text.as_deref()).next();
    let stream = stream.unwrap_or("pose");
    Some(vec![
        format!(
            "let the computer that stamps the {stream} stream follow the robot's clock (chrony, PTP)"
        ),
        format!(
            "divide the stamps of the {stream} stream by {} in recordings made so far",
            rate.map(|rate| 1.0 + rate).text()
        ),
    ])
}

pub(super) fn link_delay(finding: &Finding) -> Option<Vec<String>> {
    let delay = Quantity::of(finding, "delay_s")?;
    Some(vec![
        "stamp each message with the time at which its position was measured".to_owned(),
        format!(
            "move each received position {} s ahead along its velocity",
            delay.text()
        ),
    ])
}
