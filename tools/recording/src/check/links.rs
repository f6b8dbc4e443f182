//! Position messages between robots: clocks, latency, loss and unknown senders.

use std::collections::BTreeMap;

use super::report::{Finding, Severity};
use crate::rows::{AllRows, Rows, Selection};

/// Number of pairs whose medians are searched for at once.
const PAIRS_AT_ONCE: usize = 256;

/// The messages of each pair, by sender, then by receiver.
type Pairs = BTreeMap<String, BTreeMap<String, Messages>>;

/// The messages of a pair.
#[derive(Default)]
struct Messages {
    count: u64,
    received: u64,
    /// Received before they were sent.
    early: u64,
    /// The search for the median latency, while it lasts.
    search: Option<Selection>,
    /// The median latency, once it is known; NaN if nothing arrived.
    median_s: Option<f64>,
}

/// Adds findings about the messages of each pair of sender and receiver.
pub(super) fn check(rows: &AllRows<'_>, findings: &mut Vec<Finding>) {
    let Some(links) = &rows.links else {
        return;
    };
    let mut pairs = count(&links.rows);
    add_medians(&links.rows, &mut pairs);
    let pairs = pairs
        .iter()
        .flat_map(|(from, to)| to.iter().map(move |(to, m)| (from, to, m)));
    for (from, to, messages) in pairs {
        let Messages {
            count,
            received,
            early,
            median_s,
            ..
        } = messages;
        if *early > 0 {
            let statement =
                format!("{early} of {count} messages from {from} arrive before they were sent");
            let remedy = "put both robots on one clock";
            findings.push(Finding::new(
                Severity::Error,
                to,
                "negative_latency",
                statement,
                remedy,
            ));
        }
        let (lost, median_s) = (count - received, median_s.unwrap_or(f64::NAN));
        let statement =
            format!("{count} messages from {from}: median latency {median_s:.4} s, {lost} lost");
        findings.push(Finding::new(
            Severity::Note,
            to,
            "link",
            statement,
            "nothing to do",
        ));
        if rows.recording.robot(from).is_none() {
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

/// The pairs with their numbers of messages.
fn count(rows: &Rows<'_>) -> Pairs {
    let mut pairs = Pairs::new();
    visit(rows, &mut |from, to, delay_s| {
        if find(&mut pairs, from, to).is_none() {
            let of_sender = pairs.entry(from.to_owned()).or_default();
            of_sender.insert(to.to_owned(), Messages::default());
        }
        if let Some(messages) = find(&mut pairs, from, to) {
            messages.count += 1;
            messages.received += u64::from(delay_s.is_some());
            messages.early += u64::from(delay_s.is_some_and(|delay_s| delay_s < 0.0));
        }
    });
    pairs
}

fn find<'a>(pairs: &'a mut Pairs, from: &str, to: &str) -> Option<&'a mut Messages> {
    pairs.get_mut(from)?.get_mut(to)
}

/// Computes the median latency of each pair.
fn add_medians(rows: &Rows<'_>, pairs: &mut Pairs) {
    while begin_searches(pairs) {
        let mut searching = true;
        while searching {
            visit(rows, &mut |from, to, delay_s| {
                let search = find(pairs, from, to).and_then(|m| m.search.as_mut());
                if let (Some(search), Some(delay_s)) = (search, delay_s) {
                    search.add(delay_s);
                }
            });
            searching = false;
            for messages in pairs.values_mut().flat_map(BTreeMap::values_mut) {
                if let Some(median_s) = messages.search.as_mut().and_then(Selection::end_visit) {
                    (messages.search, messages.median_s) = (None, Some(median_s));
                }
                searching |= messages.search.is_some();
            }
        }
    }
}

/// Begins the search for the medians that are not known yet, of a limited number of pairs. Returns
/// whether there are any.
fn begin_searches(pairs: &mut Pairs) -> bool {
    let messages = pairs.values_mut().flat_map(BTreeMap::values_mut);
    let unknown = messages.filter(|messages| messages.median_s.is_none());
    let mut any = false;
    for messages in unknown.take(PAIRS_AT_ONCE) {
        messages.search = Some(Selection::new(messages.received / 2));
        any = true;
    }
    any
}

/// Calls `visit` with sender, receiver and latency (s) of each message; `None` if it was lost.
fn visit(rows: &Rows<'_>, visit: &mut dyn FnMut(&str, &str, Option<f64>)) {
    let mut cursor = rows.clone().cursor();
    while let Some(block) = cursor.next_block() {
        let received = block.numbers_of("t_received_s");
        let [from, to] = ["from", "to"].map(|name| block.texts_of(name));
        for (row, sent_s) in block.t_s.iter().enumerate() {
            let delay_s = received.get(row).map(|t_s| t_s - sent_s);
            let delay_s = delay_s.filter(|delay_s| !delay_s.is_nan());
            if let (Some(from), Some(to)) = (from.get(row), to.get(row)) {
                visit(from, to, delay_s);
            }
        }
    }
}
