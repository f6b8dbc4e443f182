//! Robots that follow each other: which one leaves the spacing that it had in the baseline, and why.

mod pair;
mod path;
#[cfg(test)]
mod tests;
mod usual;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use slipstream_recording::Recording;
use slipstream_recording::recording::Robot;

use self::pair::{Bin, Pair, Pose};
use self::usual::Usual;
use super::alarm::State;
use super::event::{Change, Event};
use crate::answer::Warning;
use crate::answer::statement::change;
use crate::data::streams;

/// Bins in a row outside of its range after which a spacing has left it, and inside after which it is back.
const OUTSIDE: u32 = 3;
const INSIDE: u32 = 4;
/// A spacing is back within this share of its range.
const BACK: f64 = 0.5;
/// A cause begins no longer before the spacing leaves its range (s), nor so much after.
const BEFORE_S: f64 = 15.0;
const AFTER_S: f64 = 1.0;
/// So long (s) a cause is waited for.
const WAIT_S: f64 = 3.0;
/// Changes that are remembered.
const MOST_CAUSES: usize = 32;

/// A change of a robot or a link that was said.
#[derive(Debug, Clone)]
struct Cause {
    robot: String,
    effect: String,
    onset_s: f64,
    words: String,
}

/// A follower and the one ahead of it.
#[derive(Debug, Clone)]
struct Follower {
    ahead: Arc<str>,
    name: Arc<str>,
    pair: Pair,
    usual: Usual,
    /// Bins in a row that are outside, or inside once it has left.
    count: u32,
    /// When the first of these began (s), and the last difference (m).
    first_s: f64,
    beside_m: f64,
    /// Since when it is outside (s), and whether that was said.
    outside: Option<(f64, bool)>,
}

/// All followers, from the front.
#[derive(Debug, Clone)]
pub(super) struct Formation {
    followers: Vec<Follower>,
    causes: VecDeque<Cause>,
    now_s: f64,
}

impl Formation {
    /// The formation of a baseline; without links or poses nobody follows.
    pub(super) fn new(baseline: &[Recording]) -> Self {
        let mut bins: BTreeMap<(Arc<str>, Arc<str>), Vec<Bin>> = BTreeMap::new();
        for recording in baseline {
            for (from, to) in links(recording) {
                let own = bins.entry((Arc::clone(&from), Arc::clone(&to)));
                own.or_default().extend(heard(recording, &from, &to));
            }
        }
        let usual = bins.into_iter();
        let usual = usual.filter_map(|(name, bins)| Some((name, Usual::of(&bins)?)));
        Self {
            followers: in_order(usual),
            causes: VecDeque::new(),
            now_s: f64::NEG_INFINITY,
        }
    }

    /// Nothing was heard.
    pub(super) fn again(&mut self) {
        self.causes.clear();
        self.now_s = f64::NEG_INFINITY;
        for own in &mut self.followers {
            own.again();
        }
    }

    /// Hears a piece, and what was said of it so far; adds what is to be said of spacings.
    pub(super) fn hear(&mut self, piece: &Recording, events: &mut Vec<Event>) {
        if self.followers.is_empty() {
            return;
        }
        for event in events.iter() {
            if let Event::Change(own) = event {
                self.note(own);
            }
        }
        for place in 0..self.followers.len() {
            let own = &mut self.followers[place];
            let of = |name: &str| piece.robot(name).map(poses).unwrap_or_default();
            let (ahead, behind) = (of(&own.ahead), of(&own.name));
            let last = behind.last().map(|row| row.0);
            self.now_s = self.now_s.max(last.unwrap_or(f64::NEG_INFINITY));
            let mut words = Vec::new();
            for bin in own.pair.hear(&ahead, &behind) {
                words.extend(own.judge(&bin));
            }
            words.extend(self.left(place));
            let robot = self.followers[place].name.to_string();
            events.extend(words.into_iter().map(|(id, statement, remedy)| {
                let warning = Warning {
                    recording: piece.name.clone(),
                    robot: Some(robot.clone()),
                    id: id.to_owned(),
                    statement,
                    remedy,
                };
                Event::Fault(self.now_s, warning)
            }));
        }
    }

    /// Remembers a change that may be a cause.
    fn note(&mut self, own: &Change) {
        let effect = &own.finding.effect;
        self.causes
            .retain(|known| known.robot != own.robot || known.effect != *effect);
        if own.state == State::Withdrawn {
            return;
        }
        let words = change(&own.finding).unwrap_or_else(|| effect.replace('_', " "));
        let is_link = own.finding.place.condition.starts_with("link ");
        self.causes.push_back(Cause {
            robot: own.robot.clone(),
            effect: effect.clone(),
            onset_s: own.onset_s,
            words: if is_link {
                words
            } else {
                format!("{}: {words}", own.robot)
            },
        });
        if self.causes.len() > MOST_CAUSES {
            self.causes.pop_front();
        }
    }

    /// What is to be said of a follower whose spacing has left its range, once there is a cause or none is waited for.
    fn left(&mut self, place: usize) -> Option<Words> {
        let own = &self.followers[place];
        let (since_s, false) = own.outside? else {
            return None;
        };
        let cause = self.cause(place, since_s);
        let has_waited = self.now_s - since_s > WAIT_S + f64::from(OUTSIDE) * 0.5;
        if cause.is_none() && !has_waited {
            return None;
        }
        let (why, remedy) = match cause {
            Some(why) => (why, "look at the cause first"),
            None => (
                "no cause is known".to_owned(),
                "look at its controller, its load and what it is told",
            ),
        };
        let own = &mut self.followers[place];
        own.outside = Some((since_s, true));
        let much = if own.beside_m > 0.0 { "much" } else { "little" };
        let statement = format!(
            "since {since_s:.1} s it keeps {:.2} m too {much} distance from {} (baseline {:.2} ± {:.2} m): {why}",
            own.beside_m.abs(),
            own.ahead,
            own.usual.spacing_m,
            own.usual.deviation_m.max(0.005),
        );
        Some(("spacing", statement, remedy.to_owned()))
    }

    /// Why the spacing of a follower left its range at a time (s), as far as that is known.
    fn cause(&self, place: usize, since_s: f64) -> Option<String> {
        let own = &self.followers[place];
        let mut upstream = vec![&own.name, &own.ahead];
        while let Some(next) = self
            .followers
            .iter()
            .find(|other| Some(&&other.name) == upstream.last())
        {
            if upstream.contains(&&next.ahead) {
                break;
            }
            upstream.push(&next.ahead);
        }
        let window_s = since_s - BEFORE_S..=since_s + AFTER_S;
        let causes = self.causes.iter().filter(|cause| {
            let is_upstream = upstream.iter().any(|name| ***name == *cause.robot);
            is_upstream && window_s.contains(&cause.onset_s)
        });
        let last = causes.max_by(|a, b| a.onset_s.total_cmp(&b.onset_s));
        if let Some(cause) = last {
            return Some(format!("{}, since {:.1} s", cause.words, cause.onset_s));
        }
        let mut ahead = self.followers.iter().filter_map(|other| {
            let outside = other.outside?;
            let is_upstream = upstream.iter().skip(1).any(|name| **name == other.name);
            (is_upstream && outside.0 <= since_s + AFTER_S).then_some((&other.name, outside))
        });
        let (name, (first_s, was_said)) = ahead.next()?;
        was_said.then(|| format!("the spacing of {name} left its range first, at {first_s:.1} s"))
    }
}

/// Identity, statement and remedy.
type Words = (&'static str, String, String);

impl Follower {
    fn again(&mut self) {
        self.pair = Pair::default();
        (self.count, self.outside) = (0, None);
    }

    /// Judges a bin; what is said if the spacing is back.
    fn judge(&mut self, bin: &Bin) -> Option<Words> {
        let beside_m = self.usual.judged_m(bin)?;
        let range_m = self.usual.range_m;
        let (is_next, enough) = match self.outside {
            None => (beside_m.abs() > range_m, OUTSIDE),
            Some(_) => (beside_m.abs() < BACK * range_m, INSIDE),
        };
        if self.outside.is_none() || !is_next {
            self.beside_m = beside_m;
        }
        if !is_next {
            self.count = 0;
            return None;
        }
        if self.count == 0 {
            self.first_s = bin.t_s;
        }
        self.count += 1;
        if self.count < enough {
            return None;
        }
        self.count = 0;
        match self.outside.take() {
            None => {
                self.outside = Some((self.first_s, false));
                None
            }
            Some((_, was_said)) => was_said.then(|| {
                let statement = format!("keeps its distance from {} again", self.ahead);
                ("spacing_back", statement, "nothing to do".to_owned())
            }),
        }
    }
}

/// Who sends to whom.
fn links(recording: &Recording) -> Vec<(Arc<str>, Arc<str>)> {
    let messages = recording.links.iter().flat_map(|own| &own.messages);
    let mut all: Vec<(Arc<str>, Arc<str>)> = messages
        .map(|own| (Arc::clone(&own.from), Arc::clone(&own.to)))
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The spacing of two robots of a recording.
fn heard(recording: &Recording, ahead: &str, behind: &str) -> Vec<Bin> {
    let of = |name: &str| recording.robot(name).map(poses).unwrap_or_default();
    let (ahead, behind) = (of(ahead), of(behind));
    Pair::default().hear(&ahead, &behind)
}

/// The poses of a robot's rows.
fn poses(robot: &Robot) -> Vec<Pose> {
    let rows = streams::poses(robot).unwrap_or_default().into_iter();
    let seen = rows.filter(|(t_s, [x, y, _])| [t_s, x, y].iter().all(|own| own.is_finite()));
    seen.map(|(t_s, [x, y, yaw])| (t_s, [x, y, if yaw.is_finite() { yaw } else { 0.0 }]))
        .collect()
}

/// Of those who are ahead of a robot the nearest is the one that it follows; from the front.
fn in_order(pairs: impl Iterator<Item = ((Arc<str>, Arc<str>), Usual)>) -> Vec<Follower> {
    let mut nearest: BTreeMap<Arc<str>, (Arc<str>, Usual)> = BTreeMap::new();
    for ((ahead, name), usual) in pairs {
        let known = nearest.get(&name);
        if known.is_none_or(|(_, own)| usual.spacing_m < own.spacing_m) {
            nearest.insert(name, (ahead, usual));
        }
    }
    let mut followers: Vec<Follower> = Vec::new();
    while !nearest.is_empty() {
        let is_front = |ahead: &Arc<str>| !nearest.contains_key(ahead);
        let next = nearest.iter().find(|(_, (ahead, _))| is_front(ahead));
        let Some(name) = next.map(|own| Arc::clone(own.0)) else {
            // on a closed course the first is also behind the last, but furthest
            let all = nearest.iter();
            let furthest = all.max_by(|a, b| a.1.1.spacing_m.total_cmp(&b.1.1.spacing_m));
            let Some(name) = furthest.map(|own| Arc::clone(own.0)) else {
                break;
            };
            nearest.remove(&name);
            continue;
        };
        if let Some((ahead, usual)) = nearest.remove(&name) {
            followers.push(Follower {
                ahead,
                name,
                pair: Pair::default(),
                usual,
                count: 0,
                first_s: 0.0,
                beside_m: 0.0,
                outside: None,
            });
        }
    }
    followers
}
