//! A watch over robots: pieces of a recording in, changes out.

use std::collections::VecDeque;
use std::sync::Arc;

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::recording::Robot;
use slipstream_recording::{Pieces, Recording, joined};

use super::alarm::{Alarm, State};
use super::change::as_finding;
pub use super::event::{Change, Event};
use super::filters::prepared;
use super::formation::Formation;
use super::links::Links;
use super::robot::{FALSE_ALARM_LOOKS, Found, Smallest, Watched, YOUNG_S};
use super::silence::Silence;
use crate::answer::{Answer, Finding, Warning};
use crate::data::faults;
use crate::data::feed::Oddity;
use crate::diagnosis::{diagnose, machines};
use crate::request::{Request, Runs, model_of};

/// Length of the pieces into which a baseline is cut (s).
const PIECE_S: f64 = 0.5;
/// How long rows are kept for a diagnosis (s).
const KEPT_S: f64 = 300.0;
/// A change that was raised may get another name for so long (s); then a diagnosis is due.
const RENAMED_S: f64 = 8.0;
/// Rows before a change that are compared with it, at least (s).
const BEFORE_S: f64 = 20.0;

/// A diagnosis that is due; it takes seconds, so that another thread should make it.
pub struct Question {
    robot: String,
    number: u64,
    recording: Recording,
    against: Arc<Vec<Recording>>,
    model: RobotModel,
    excluded: Vec<String>,
}

impl Question {
    /// Diagnoses the rows since a change beside those before it.
    ///
    /// # Errors
    /// As [`diagnose`].
    pub fn diagnose(&self) -> Result<Answer, InputError> {
        let recordings = std::slice::from_ref(&self.recording);
        let request = Request {
            recordings,
            against: &self.against,
            model_of: &|_| Some(self.model.clone()),
            excluded: &self.excluded,
            excluded_s: &[],
            progress: &|_| (),
        };
        diagnose(&request).map(|(answer, _)| answer)
    }
}

/// A robot that is watched, and what was said of it.
struct Attended {
    watched: Watched,
    alarm: Option<Alarm>,
    silence: Silence,
    /// When its parameters were last taken as they are (s); before, they are those of the baseline.
    absorbed_s: Option<f64>,
}

/// A watch.
pub struct Watch {
    robots: Vec<Attended>,
    links: Links,
    formation: Formation,
    /// The baseline has one robot, which the one of the source is, whatever it is called.
    is_alone: bool,
    baseline: Arc<Vec<Recording>>,
    kept: VecDeque<Recording>,
    unknown: Vec<String>,
    questions: u64,
    excluded: Vec<String>,
}

impl Watch {
    /// A watch over the robots of `request.recordings`, which are the baseline: what they do when nothing changed.
    ///
    /// # Errors
    /// A baseline of which nothing can be compared, or a robot without a model.
    pub fn new(request: &Request<'_>) -> Result<Self, InputError> {
        let (recordings, _) = faults::mended(request.recordings, request.model_of);
        let request = &Request {
            recordings: &recordings,
            ..*request
        };
        let machines = machines(request.recordings);
        let robots = machines.iter().map(|machine| learnt(request, machine));
        let mut robots: Vec<Attended> = robots.collect::<Result<_, _>>()?;
        // the links together have as many false alarms as a robot
        let links = Links::new(&recordings, request.excluded, robots.len() as f64 + 1.0);
        let shares = robots.len() + usize::from(!links.is_empty());
        let looks = FALSE_ALARM_LOOKS * shares as f64;
        robots.iter_mut().for_each(|own| own.watched.expect(looks));
        let excluded = request.excluded.to_vec();
        Ok(Self {
            is_alone: robots.len() == 1,
            robots,
            links,
            formation: Formation::new(&recordings),
            baseline: Arc::new(recordings.into_owned()),
            kept: VecDeque::new(),
            unknown: Vec::new(),
            questions: 0,
            excluded,
        })
    }

    /// Hears the rows of a piece; what it says of them.
    pub fn hear(&mut self, piece: &Recording) -> Vec<Event> {
        let mut events = Vec::new();
        for robot in &piece.robots {
            let is_alone = self.is_alone && piece.robots.len() == 1;
            let mut known = self.robots.iter_mut();
            let own = known.find(|own| is_alone || own.watched.name == robot.name);
            match own {
                Some(own) => own.hear(robot, &piece.name, &mut events),
                None if !self.unknown.contains(&robot.name)
                    && self.unknown.len() < MOST_UNKNOWN =>
                {
                    self.unknown.push(robot.name.clone());
                    events.push(not_in_baseline(robot, &piece.name));
                }
                None => (),
            }
        }
        events.extend(self.links.hear(piece));
        self.formation.hear(piece, &mut events);
        self.keep(piece);
        events
    }

    fn keep(&mut self, piece: &Recording) {
        self.kept.push_back(piece.clone());
        let now_s = self.robots.iter().map(|own| own.watched.now_s());
        let until_s = now_s.fold(f64::NEG_INFINITY, f64::max) - KEPT_S;
        let old = |piece: &Recording| {
            piece
                .robots
                .iter()
                .filter_map(Robot::last_s)
                .all(|t_s| t_s < until_s)
        };
        while self.kept.len() > MOST_KEPT || self.kept.front().is_some_and(old) {
            self.kept.pop_front();
        }
    }

    /// A diagnosis that is due.
    pub fn question(&mut self) -> Option<Question> {
        let place = self.robots.iter().position(Attended::asks)?;
        let own = &mut self.robots[place];
        let alarm = own.alarm.as_mut()?;
        let origin_s = own.watched.feed.origin_s.unwrap_or(0.0);
        let onset_s = alarm.found.onset_s + origin_s;
        self.questions += 1;
        alarm.asks(self.questions);
        let named = |from_s: f64| {
            let mut rows = joined(self.kept.iter(), from_s)?;
            rows.robots
                .retain(|robot| self.is_alone || robot.name == own.watched.name);
            Some(rows)
        };
        let mut against = Arc::clone(&self.baseline);
        if let Some(since_s) = own.absorbed_s
            && alarm.found.onset_s - since_s >= BEFORE_S
            && let Some(mut before) = named(since_s + origin_s)
        {
            before = Pieces::new(before, onset_s - since_s - origin_s).next()?.1;
            against = Arc::new(vec![before]);
        }
        Some(Question {
            robot: own.watched.name.clone(),
            number: self.questions,
            recording: named(onset_s)?,
            against,
            model: own.watched.model.clone(),
            excluded: self.excluded.clone(),
        })
    }

    /// Hears what a diagnosis said.
    pub fn answered(
        &mut self,
        question: &Question,
        answer: &Result<Answer, InputError>,
    ) -> Vec<Event> {
        let mut robots = self.robots.iter_mut();
        let own = robots.find(|own| own.watched.name == question.robot);
        own.map_or_else(Vec::new, |own| own.answered(question.number, answer))
    }

    /// Begins anew with the same baseline: nothing was heard.
    pub fn again(&mut self) {
        for own in &mut self.robots {
            own.watched.again();
            own.silence.again();
            (own.alarm, own.absorbed_s) = (None, None);
        }
        self.links.again();
        self.formation.again();
        self.kept.clear();
        self.unknown.clear();
    }

    /// The smallest changes since a time (s) that the rows heard since would be expected to show, of the first robot.
    pub fn smallest(&self, since_s: f64) -> Vec<Smallest> {
        self.robots.first().map_or_else(Vec::new, |own| {
            let origin_s = own.watched.feed.origin_s.unwrap_or(0.0);
            own.watched.smallest(since_s - origin_s)
        })
    }
}

/// Robots without a baseline that are named at most, and pieces that are kept.
const MOST_UNKNOWN: usize = 16;
const MOST_KEPT: usize = 4096;

fn not_in_baseline(robot: &Robot, recording: &str) -> Event {
    let statement = "is not in the baseline: it is not watched".to_owned();
    let remedy = "give a recording of it with --against".to_owned();
    Event::Fault(
        robot.last_s().unwrap_or(0.0),
        Warning {
            recording: recording.to_owned(),
            robot: Some(robot.name.clone()),
            id: "not_in_baseline".to_owned(),
            statement,
            remedy,
        },
    )
}

/// A machine as its runs say.
fn learnt(request: &Request<'_>, machine: &Runs<'_>) -> Result<Attended, InputError> {
    let name = &machine[0].1.name;
    let model = model_of(request, machine[0])?;
    slipstream_sim::Robot::<f64>::new(&model)?;
    let progress = |what: &str| (request.progress)(&format!("{name}, baseline: {what}"));
    let prepared = prepared(request, machine, &model, &progress)?;
    let rests = prepared.habits.changes_every_s.is_some();
    let runs: Vec<Vec<Robot>> = machine.iter().map(|(_, robot)| cut(robot)).collect();
    progress("how far it strays by itself");
    let watched = Watched::new(name, prepared, &runs);
    let watched = watched.ok_or_else(|| {
        let remedy = "drive some metres with turns, with wheels or commands and a pose or a gyro";
        InputError::new(
            name,
            "is no baseline: its rows tell nothing of the robot",
            remedy,
        )
    })?;
    let robots = machine.iter().map(|(_, robot)| *robot);
    Ok(Attended {
        silence: Silence::new(robots, rests),
        watched,
        alarm: None,
        absorbed_s: None,
    })
}

/// The rows of a robot in pieces.
fn cut(robot: &Robot) -> Vec<Robot> {
    let alone = Recording {
        robots: vec![robot.clone()],
        ..Recording::default()
    };
    let pieces = Pieces::new(alone, PIECE_S);
    pieces
        .filter_map(|(_, own)| own.robots.into_iter().next())
        .collect()
}

impl Attended {
    fn hear(&mut self, piece: &Robot, recording: &str, events: &mut Vec<Event>) {
        let odd = self.watched.hear(piece);
        let origin_s = self.watched.feed.origin_s.unwrap_or(0.0);
        let name = &self.watched.name;
        let fault = |t_s: f64, (id, statement, remedy): (&str, String, &str)| {
            let warning = Warning {
                recording: recording.to_owned(),
                robot: Some(name.clone()),
                id: id.to_owned(),
                statement,
                remedy: remedy.to_owned(),
            };
            Event::Fault(t_s, warning)
        };
        events.extend(odd.into_iter().map(|own| {
            let (t_s, words) = words(own);
            fault(t_s + origin_s, words)
        }));
        let silent = self.silence.hear(piece);
        events.extend(silent.into_iter().map(|(t_s, words)| fault(t_s, words)));
        if self.watched.is_due() {
            self.look(events);
            self.watched.open();
        }
    }

    fn look(&mut self, events: &mut Vec<Event>) {
        if self.silence.is_silent() {
            return;
        }
        let found = self.watched.look();
        match (&mut self.alarm, found) {
            (None, None) => (),
            (None, Some(found)) => {
                events.push(self.event(&found, None, State::Raised));
                self.alarm = Some(Alarm::new(found, self.watched.now_s()));
            }
            (Some(alarm), Some(found)) => {
                alarm.missed = 0;
                let other = self.watched.hypothesis(&found).effect;
                let is_new = other != self.watched.hypothesis(&alarm.found).effect;
                if is_new && self.watched.now_s() - alarm.raised_s > RENAMED_S {
                    return;
                }
                // older onsets are sparse: which of them is left fits best says no more of when it was
                let was_s = alarm.found.onset_s;
                let stays = !is_new && self.watched.now_s() - was_s > YOUNG_S;
                alarm.found = Found {
                    onset_s: if stays { was_s } else { found.onset_s },
                    ..found
                };
                if is_new {
                    let found = alarm.found.clone();
                    events.push(self.event(&found, None, State::Raised));
                }
            }
            (Some(alarm), None) => {
                alarm.missed += 1;
                if alarm.is_gone() {
                    let found = alarm.found.clone();
                    events.push(self.event(&found, None, State::Withdrawn));
                    self.alarm = None;
                }
            }
        }
    }

    fn asks(&self) -> bool {
        let now_s = self.watched.now_s();
        self.alarm.as_ref().is_some_and(|own| own.is_due(now_s))
    }

    fn answered(&mut self, number: u64, answer: &Result<Answer, InputError>) -> Vec<Event> {
        let name = self.watched.name.clone();
        let Some(alarm) = self.alarm.as_mut().filter(|own| own.asked == Some(number)) else {
            return Vec::new();
        };
        alarm.asked = None;
        let findings = answer.as_ref().map_or(&[][..], |own| &own.findings);
        let expected = self.watched.hypothesis(&alarm.found).effect;
        let is_expected = |own: &&Finding| {
            own.effect == expected || own.confused_with.iter().any(|other| other == expected)
        };
        let confirmed = findings.iter().find(is_expected).or(findings.first());
        let found = alarm.found.clone();
        let event = match (confirmed, answer) {
            (Some(finding), _) => {
                let finding = Finding {
                    robot: name,
                    ..finding.clone()
                };
                self.event(&found, Some(finding), State::Confirmed)
            }
            (None, Ok(_)) if alarm.is_last() => self.event(&found, None, State::Withdrawn),
            (None, _) => return Vec::new(),
        };
        self.watched.absorb(found.onset_s, confirmed);
        self.absorbed_s = Some(self.watched.now_s());
        self.alarm = None;
        vec![event]
    }

    fn finding(&self, found: &Found) -> Finding {
        let own = self.watched.hypothesis(found);
        let origin_s = self.watched.feed.origin_s.unwrap_or(0.0);
        let span_s = [found.onset_s, self.watched.now_s()].map(|t_s| t_s + origin_s);
        let robot = (self.watched.name.as_str(), &self.watched.improved);
        let tried = self.watched.hypotheses.all.len();
        as_finding(own, found, robot, tried, span_s)
    }

    fn event(&self, found: &Found, finding: Option<Finding>, state: State) -> Event {
        let origin_s = self.watched.feed.origin_s.unwrap_or(0.0);
        let change = Change {
            t_s: self.watched.now_s() + origin_s,
            onset_s: found.onset_s + origin_s,
            robot: self.watched.name.clone(),
            finding: finding.unwrap_or_else(|| self.finding(found)),
            state,
        };
        Event::Change(Box::new(change))
    }
}

/// What was odd, in words: when (s), and identity, statement and remedy.
fn words(own: Oddity) -> (f64, (&'static str, String, &'static str)) {
    match own {
        Oddity::Backwards { stream, t_s } => (
            t_s,
            (
                "stamps_go_back",
                format!("a row of {stream} is stamped before the one ahead of it; it is left out"),
                "look whether two publishers share the topic, or a clock was set",
            ),
        ),
        Oddity::Jumped { stream, t_s, by_s } => (
            t_s,
            (
                "stamps_jump",
                format!("the stamps of {stream} jump by {by_s:.1} s"),
                "look whether a clock was set, or the stream was paused",
            ),
        ),
        Oddity::Wrapped { t_s } => (
            t_s,
            (
                "counter_wraps",
                "a counter of an encoder begins again; it is taken as running on".to_owned(),
                "nothing to do; a wider counter avoids it",
            ),
        ),
    }
}
