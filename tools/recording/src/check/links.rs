//! Position messages between robots: clocks, latency, loss and unknown senders.

use super::rates::median;
use super::report::{Finding, Severity};
use crate::recording::{LinkMessage, Recording};

/// Adds findings about the messages of each pair of sender and receiver.
pub(super) fn check(recording: &Recording, findings: &mut Vec<Finding>) {
    let Some(links) = &recording.links else {
        return;
    };
    let mut pairs: Vec<(&str, &str)> = links
        .messages
        .iter()
        .map(|message| (&*message.from, &*message.to))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    for (from, to) in pairs {
        let of_pair = |m: &&LinkMessage| (&*m.from, &*m.to) == (from, to);
        let messages: Vec<_> = links.messages.iter().filter(of_pair).collect();
        let delays: Vec<f64> = messages
            .iter()
            .filter_map(|m| m.t_received_s.map(|t_s| t_s - m.t_sent_s))
            .collect();
        let early = delays.iter().filter(|delay| **delay < 0.0).count();
        let lost = messages.len() - delays.len();
        if early > 0 {
            let statement = format!(
                "{early} of {} messages from {from} arrive before they were sent",
                messages.len()
            );
            let remedy = "put both robots on one clock";
            findings.push(Finding::new(
                Severity::Error,
                to,
                "negative_latency",
                statement,
                remedy,
            ));
        }
        let median_s = median(delays).unwrap_or(f64::NAN);
        let statement = format!(
            "{} messages from {from}: median latency {median_s:.4} s, {lost} lost",
            messages.len()
        );
        findings.push(Finding::new(
            Severity::Note,
            to,
            "link",
            statement,
            "nothing to do",
        ));
        if recording.robots.iter().all(|robot| robot.name != from) {
            let statement = format!("messages come from {from}, which has no folder");
            let remedy = "spell names in links.csv as the folders";
            findings.push(Finding::new(
                Severity::Warning,
                to,
                "unknown_sender",
                statement,
                remedy,
            ));
        }
    }
}
