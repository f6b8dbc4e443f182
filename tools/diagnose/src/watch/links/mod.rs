//! Messages between robots: links that become slower, and links that fall silent.

mod delays;
mod silence;
#[cfg(test)]
mod tests;
mod usual;

use std::collections::BTreeMap;
use std::sync::Arc;

use slipstream_recording::Recording;
use slipstream_recording::recording::LinkMessage;

use self::delays::{Delays, Said};
use self::silence::Silence;
use self::usual::Usual;
use super::event::{Change, Event};
use super::robot::FALSE_ALARM_S;
use crate::answer::{Evidence, Finding, Warning};
use crate::explain::finding::{Named, Number};

/// The effect that a change of a link is.
const EFFECT: &str = "link_delay";
/// Time that goes back by more (s) begins anew.
const BREAK_S: f64 = 1.0;

/// A link, by sender and receiver.
type Name = (Arc<str>, Arc<str>);

/// A link that is watched.
#[derive(Debug, Clone)]
struct Link {
    /// Without enough messages in the baseline, its delays are unknown.
    delays: Option<Delays>,
    silence: Silence,
}

/// All links of a baseline.
#[derive(Debug, Clone)]
pub(super) struct Links {
    links: BTreeMap<Name, Link>,
    is_excluded: bool,
    /// When each robot was last heard, and the last of these times (s).
    heard_s: BTreeMap<Arc<str>, f64>,
    now_s: f64,
}

impl Links {
    /// The links of a baseline. Over everything that is watched, `shares` like this one have one false alarm in ten hours.
    pub(super) fn new(baseline: &[Recording], excluded: &[String], shares: f64) -> Self {
        let mut runs: BTreeMap<Name, Vec<Run>> = BTreeMap::new();
        for recording in baseline {
            for (name, run) in runs_of(recording) {
                runs.entry(name).or_default().push(run);
            }
        }
        let shares = shares * runs.len() as f64;
        let links = runs.into_iter();
        Self {
            links: links
                .map(|(name, runs)| (name, link(&runs, shares)))
                .collect(),
            is_excluded: excluded.iter().any(|own| own == EFFECT),
            heard_s: BTreeMap::new(),
            now_s: f64::NEG_INFINITY,
        }
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// Nothing was heard.
    pub(super) fn again(&mut self) {
        self.heard_s.clear();
        self.now_s = f64::NEG_INFINITY;
        for own in self.links.values_mut() {
            own.silence.again();
            own.delays.iter_mut().for_each(Delays::again);
        }
    }

    /// Hears a piece; what is said of it.
    pub(super) fn hear(&mut self, piece: &Recording) -> Vec<Event> {
        if self.links.is_empty() {
            return Vec::new();
        }
        self.sent(piece);
        let mut events = Vec::new();
        let messages = piece.links.iter().flat_map(|own| &own.messages);
        for message in messages.filter(|own| own.t_sent_s.is_finite()) {
            let name = (Arc::clone(&message.from), Arc::clone(&message.to));
            let Some(own) = self.links.get_mut(&name) else {
                continue;
            };
            let Some(arrived_s) = arrival_s(message) else {
                continue;
            };
            own.silence.arrived(arrived_s);
            let Some(delays) = own.delays.as_mut().filter(|_| !self.is_excluded) else {
                continue;
            };
            if let Some(said) = delays.hear(message.t_sent_s, arrived_s - message.t_sent_s) {
                events.push(changed(&name, &said, arrived_s));
            }
        }
        self.silent(&piece.name, &mut events);
        events
    }

    /// Notes who was heard, and until when.
    fn sent(&mut self, piece: &Recording) {
        let messages = piece.links.iter().flat_map(|own| &own.messages);
        let sent = messages.map(|own| (Arc::clone(&own.from), own.t_sent_s));
        let robots = piece.robots.iter();
        let rows = robots.filter_map(|own| Some((Arc::from(own.name.as_str()), own.last_s()?)));
        let heard: Vec<(Arc<str>, f64)> = sent.chain(rows).collect();
        let finite = || heard.iter().filter(|(_, t_s)| t_s.is_finite());
        let last_s = finite().map(|own| own.1).fold(f64::NEG_INFINITY, f64::max);
        if last_s < self.now_s - BREAK_S && last_s.is_finite() {
            self.again();
        }
        self.now_s = self.now_s.max(last_s);
        for (name, t_s) in finite() {
            let own = self.heard_s.entry(Arc::clone(name)).or_insert(*t_s);
            *own = own.max(*t_s);
        }
    }

    /// Says which links fell silent or came back.
    fn silent(&mut self, recording: &str, events: &mut Vec<Event>) {
        let now_s = self.now_s;
        for (name, own) in &mut self.links {
            let (from, to) = name;
            let Some(sender_s) = self.heard_s.get(from) else {
                continue;
            };
            let said = own.silence.look(&called(name), now_s, *sender_s);
            events.extend(said.map(|(id, statement, remedy)| {
                let warning = Warning {
                    recording: recording.to_owned(),
                    robot: Some(to.to_string()),
                    id: id.to_owned(),
                    statement,
                    remedy: remedy.to_owned(),
                };
                Event::Fault(now_s, warning)
            }));
        }
    }
}

/// The messages of a link in one recording that arrived: time of arrival and delay (s), and the recording's first row (s).
struct Run {
    arrivals_s: Vec<f64>,
    delays_s: Vec<f64>,
    begin_s: f64,
}

fn runs_of(recording: &Recording) -> BTreeMap<Name, Run> {
    let firsts = recording.robots.iter().filter_map(|own| {
        let firsts = own.stamps().filter_map(|stamps| stamps.first().copied());
        firsts.reduce(f64::min)
    });
    let begin_s = firsts.reduce(f64::min);
    let mut runs: BTreeMap<Name, Run> = BTreeMap::new();
    for message in recording.links.iter().flat_map(|own| &own.messages) {
        let Some(arrived_s) = arrival_s(message) else {
            continue;
        };
        let name = (Arc::clone(&message.from), Arc::clone(&message.to));
        let run = runs.entry(name).or_insert_with(|| Run {
            arrivals_s: Vec::new(),
            delays_s: Vec::new(),
            begin_s: begin_s.unwrap_or(arrived_s),
        });
        run.arrivals_s.push(arrived_s);
        run.delays_s.push(arrived_s - message.t_sent_s);
    }
    for run in runs.values_mut() {
        run.arrivals_s.sort_by(f64::total_cmp);
    }
    runs
}

/// A link as its runs in the baseline say.
fn link(runs: &[Run], shares: f64) -> Link {
    let delays: Vec<Vec<f64>> = runs.iter().map(|run| run.delays_s.clone()).collect();
    let spans = runs
        .iter()
        .filter_map(|run| Some(run.arrivals_s.last()? - run.arrivals_s.first()?));
    let messages: usize = delays.iter().map(Vec::len).sum();
    let rate_hz = messages as f64 / spans.sum::<f64>().max(1.0);
    // every message may be the onset of a change
    let least = (shares * FALSE_ALARM_S * rate_hz).max(1.0).ln();
    let silence: Vec<(Vec<f64>, f64)> = runs
        .iter()
        .map(|run| (run.arrivals_s.clone(), run.begin_s))
        .collect();
    Link {
        delays: Usual::of(&delays).map(|usual| Delays::new(usual, least)),
        silence: Silence::new(&silence),
    }
}

/// When a message arrived (s); `None` if it was lost, or nobody knows.
fn arrival_s(message: &LinkMessage) -> Option<f64> {
    message
        .t_received_s
        .filter(|own| (own - message.t_sent_s).is_finite())
}

/// A link as a person calls it.
fn called((from, to): &Name) -> String {
    format!("{from} to {to}")
}

/// A change of a link as an event at a time (s).
fn changed(name: &Name, said: &Said, t_s: f64) -> Event {
    let change = Change {
        t_s,
        onset_s: said.onset_s,
        robot: name.1.to_string(),
        finding: finding(name, said, t_s),
        state: said.state,
    };
    Event::Change(Box::new(change))
}

fn finding(name: &Name, said: &Said, t_s: f64) -> Finding {
    let (at_s, half_s) = (said.now.at_s, said.now.half_s);
    let link = called(name);
    let span_s = [said.onset_s, t_s];
    let named = Named {
        robot: &name.1,
        effect: EFFECT,
        numbers: vec![Number {
            name: "delay_s",
            nominal: Some(said.was_s),
            estimate: at_s,
            ci95: [at_s - half_s, at_s + half_s],
        }],
        word: None,
        intervals_s: vec![span_s],
        condition: Some(format!("link {link}")),
        runs: None,
        confused: &[],
        evidence: Evidence {
            log_likelihood_gain: said.nats,
            p_value: (-said.nats).exp().min(1.0),
        },
        known: true,
    };
    let [now, was, low, high] = [at_s, said.was_s, at_s - half_s, at_s + half_s].map(|s| 1e3 * s);
    let mut finding = named.finding(span_s);
    finding.statement = format!(
        "Robot {}, link {link}: messages take {now:.1} ms (95 % between {low:.1} and {high:.1} ms), was {was:.1} ms.",
        name.1
    );
    for parameter in &mut finding.parameters {
        parameter.nominal_ci95 = Some(said.was_ci95_s);
    }
    finding.actions = vec![format!(
        "look at the network between {} and {}, and at what else sends there",
        name.0, name.1
    )];
    finding
}
