//! The scores of a watch.

use serde::Serialize;
use slipstream_diagnose::{Event, State};
use slipstream_recording::Recording;
use slipstream_trial::own::Change;

use super::kinds::Kind;

/// What is raised again with an onset this near (s) is the same alarm under a better name.
const SAME_S: f64 = 3.0;

/// One change.
#[derive(Debug, Serialize)]
pub(super) struct Case {
    pub(super) effect: &'static str,
    pub(super) parameter: &'static str,
    pub(super) both: bool,
    /// Size over the smallest that the rest of the recording would show, and the size: of a factor, its logarithm.
    pub(super) multiple: f64,
    pub(super) size: f64,
    /// When it was raised after its begin (s), and how far the robot had driven by then (m).
    pub(super) delay_s: Option<f64>,
    pub(super) way_m: Option<f64>,
    /// After how long it is expected to be seen (s).
    pub(super) limit_s: Option<f64>,
    /// As what it was raised, and at last.
    pub(super) raised_as: Option<String>,
    pub(super) named_as: Option<String>,
    pub(super) is_named: bool,
    /// Onset that was said less the true one (s).
    pub(super) onset_error_s: Option<f64>,
    /// Whether the size lies within the interval.
    pub(super) in_interval: Option<bool>,
    /// Alarms of something before it.
    pub(super) false_alarms: Vec<String>,
}

impl Case {
    pub(super) fn new(
        kind: &Kind,
        (multiple, size): (f64, f64),
        change: &Change,
        onset_s: f64,
        events: &[Event],
        heard: &Recording,
    ) -> Self {
        let all = events.iter().filter_map(raised);
        let (early, after): (Vec<_>, Vec<_>) = all.partition(|own| own.t_s < onset_s);
        let first = after.first();
        // what is raised again with the same alarm is a better name for it
        let last = after.iter().take_while(|own| {
            first.is_some_and(|first| (own.onset_s - first.onset_s).abs() < SAME_S)
        });
        let last = last.last();
        let robot = heard.robots.first();
        let alike = robot.map(|own| change.look_alikes(own)).unwrap_or_default();
        let is_it =
            |effect: &str| effect == change.effect() || alike.iter().any(|own| own == effect);
        let in_interval = last
            .filter(|own| own.finding.effect == change.effect())
            .and_then(|own| {
                let mut all = own.finding.parameters.iter();
                let found = all.find(|own| own.name == kind.parameter)?;
                let [low, high] = found.ci95?;
                let (_, value) = change
                    .parameters()
                    .into_iter()
                    .find(|own| own.0 == kind.parameter)?;
                let is_factor = kind.is_factor();
                let was = found.nominal.unwrap_or(if is_factor { 1.0 } else { 0.0 });
                let truth = if is_factor { was * value } else { was + value };
                Some((low..=high).contains(&truth))
            });
        Self {
            effect: kind.effect,
            parameter: kind.parameter,
            both: kind.both,
            multiple,
            size,
            delay_s: first.map(|own| own.t_s - onset_s),
            way_m: first.and_then(|own| way_m(heard, [onset_s, own.t_s])),
            limit_s: None,
            raised_as: first.map(|own| own.finding.effect.clone()),
            named_as: last.map(|own| own.finding.effect.clone()),
            is_named: last.is_some_and(|own| is_it(&own.finding.effect)),
            onset_error_s: last.map(|own| own.onset_s - onset_s),
            in_interval,
            false_alarms: early
                .iter()
                .map(|own| {
                    format!(
                        "{} since {:.1} s at {:.1} s",
                        own.finding.effect, own.onset_s, own.t_s
                    )
                })
                .collect(),
        }
    }
}

/// How far a robot drove by its poses, in steps of half a second (m).
fn way_m(heard: &Recording, [from_s, to_s]: [f64; 2]) -> Option<f64> {
    let pose = heard.robots.first()?.pose.as_ref()?;
    let rows = pose
        .t_s
        .iter()
        .zip(pose.values.x_m.iter().zip(&pose.values.y_m));
    let within = rows
        .filter(|(t_s, (x, y))| (from_s..=to_s).contains(*t_s) && x.is_finite() && y.is_finite());
    let (mut way, mut last): (f64, Option<(f64, f64, f64)>) = (0.0, None);
    for (t_s, (x, y)) in within {
        match last {
            Some((before_s, ..)) if t_s - before_s < 0.5 => continue,
            Some((_, a, b)) => way += (x - a).hypot(y - b),
            None => (),
        }
        last = Some((*t_s, *x, *y));
    }
    Some(way)
}

/// All scores.
#[derive(Debug, Serialize)]
pub(super) struct Scores {
    format: u32,
    pub(super) on: String,
    /// How long was heard, and when changes began (s).
    pub(super) heard_s: f64,
    pub(super) onset_s: f64,
    /// Alarms where nothing changed.
    pub(super) null_alarms: Vec<String>,
    pub(super) cases: Vec<Case>,
    /// Whether it was interrupted: only the changes that were heard before are there.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) interrupted: bool,
}

impl Scores {
    pub(super) fn new(on: &str, heard_s: f64, onset_s: f64, null: &[Event]) -> Self {
        let alarms = null.iter().filter_map(raised);
        Self {
            format: 1,
            on: on.to_owned(),
            heard_s,
            onset_s,
            null_alarms: alarms.map(|own| own.finding.effect.clone()).collect(),
            cases: Vec::new(),
            interrupted: false,
        }
    }

    pub(super) fn add(&mut self, case: Case, limit_s: Option<f64>) {
        self.cases.push(Case { limit_s, ..case });
    }
}

/// Whether an event is that something was raised.
fn raised(event: &Event) -> Option<&slipstream_diagnose::Change> {
    match event {
        Event::Change(own) if own.state == State::Raised => Some(own),
        _ => None,
    }
}
