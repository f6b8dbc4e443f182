//! The label of a case: the effects that were drawn, those that nuisances are, and what nuisances excuse.

use std::collections::{BTreeMap, BTreeSet};

use super::effects::{look_alikes, tolerance};
use super::log::{Log, LogEffect, Source, Value, run_name};
use super::nuisances::{Apply, TABLE};
use crate::label::{ConcealedEffect, DiagnosisVerdict, Label, ParameterValue, UnknownPhysics};
use crate::maker::case::{channels, words};
use crate::maker::manoeuvre::rounded;

/// Mean lag of rows from which on a latency may be named (s).
const LAG_S: f64 = 0.002;

/// What came of the nuisances of rows: which were applied, and how late they made each stream.
#[derive(Debug)]
pub(super) struct Lags {
    applied: BTreeSet<usize>,
    /// Mean of stamp less true time, by run and source (s).
    lag_s: Vec<[f64; 4]>,
}

impl Lags {
    /// Nothing yet.
    pub(super) fn new(runs: usize) -> Self {
        Self {
            applied: BTreeSet::new(),
            lag_s: vec![[0.0; 4]; runs],
        }
    }

    /// A row of the table was applied.
    pub(super) fn applied(&mut self, row: usize) {
        self.applied.insert(row);
    }

    /// A stream of a run is so late.
    pub(super) fn measured(&mut self, source: Source, run: usize, lag_s: f64) {
        self.lag_s[run][source as usize] = lag_s;
    }

    /// How much later a stream is than its latency says, on average over these runs (s).
    fn beyond(&self, log: &Log, source: Source, runs: std::ops::Range<usize>) -> f64 {
        let at = source as usize;
        let count = runs.len().max(1) as f64;
        let own = |run: usize| {
            self.lag_s[run][at] - log.sensors.latency_s[at] - log.runs[run].latency_s[at]
        };
        runs.map(own).sum::<f64>() / count
    }
}

/// The label.
pub(super) fn label(log: &Log, name: &str, lags: &Lags) -> Label {
    let drawn = log
        .effects
        .iter()
        .filter(|effect| !effect.parameters.is_empty());
    let all: Vec<LogEffect> = drawn.cloned().chain(skid_tracks(log)).collect();
    let late = all.iter().map(|effect| with_lag(effect, log, lags));
    let effects: Vec<ConcealedEffect> = late.map(|effect| concealed(&effect, log)).collect();
    let unknown = turn_loss(log);
    let verdict = match (&unknown, effects.is_empty()) {
        (Some(_), _) => DiagnosisVerdict::Unexplained,
        (None, false) => DiagnosisVerdict::Explained,
        (None, true) => DiagnosisVerdict::Match,
    };
    let is_null = unknown.is_none() && effects.is_empty();
    Label {
        verdict,
        robot_toml: format!("robots/{name}.toml"),
        kind: format!(
            "{}, {}",
            if is_null { "null" } else { "effects" },
            streams(log)
        ),
        notes: notes(log),
        without: Vec::new(),
        nuisances: nuisances(log, lags),
        allowed: allowed(log, lags, &all),
        effects,
        unknown,
    }
}

/// The nuisances that the log really has.
fn nuisances(log: &Log, lags: &Lags) -> Vec<String> {
    let has =
        |row: &usize| matches!(TABLE[*row].apply, Apply::Case(_)) || lags.applied.contains(row);
    let rows = log.nuisances.iter().map(|drawn| drawn.row).filter(has);
    rows.map(|row| TABLE[row].name.to_owned()).collect()
}

/// Findings that nuisances bring: what they allow, and latencies of streams that they make late.
fn allowed(log: &Log, lags: &Lags, effects: &[LogEffect]) -> Vec<String> {
    let mut allowed: BTreeSet<&str> = log.allowed.iter().copied().collect();
    for source in Source::ALL {
        let beyond_s = lags.beyond(log, source, 0..log.runs.len());
        if let Some(id) = source
            .latency()
            .filter(|_| log.has(source) && beyond_s.abs() > LAG_S)
        {
            allowed.insert(id);
            allowed.extend(look_alikes(id, log));
            if log.has(Source::Command) {
                allowed.insert("actuator_delay");
            }
        }
    }
    // What is asked for is not excused.
    allowed.retain(|id| effects.iter().all(|effect| effect.id != *id));
    allowed.into_iter().map(str::to_owned).collect()
}

/// The effect, later by what nuisances of rows add to its stream.
fn with_lag(effect: &LogEffect, log: &Log, lags: &Lags) -> LogEffect {
    let mut effect = effect.clone();
    let source = Source::ALL
        .into_iter()
        .find(|source| source.latency() == Some(effect.id));
    let Some(source) = source else {
        return effect;
    };
    let runs = effect.run.map_or(0..log.runs.len(), |run| run..run + 1);
    let beyond_s = lags.beyond(log, source, runs);
    for (_, value) in &mut effect.parameters {
        if let Value::Number(latency_s) = value {
            *latency_s = rounded(*latency_s + beyond_s);
        }
    }
    effect.tolerance += beyond_s.abs() / 2.0;
    effect
}

/// The effective track of a robot that skids: the factor that fits its turns best, in every run or on every floor.
fn skid_tracks(log: &Log) -> Vec<LogEffect> {
    let Some(skid) = &log.plant.skid else {
        return Vec::new();
    };
    let one_floor = log
        .runs
        .iter()
        .all(|run| run.floor.track == log.runs[0].floor.track);
    let spread = skid.scale * (skid.aside.abs() + skid.gentle / 2.0);
    let effect = |runs: std::ops::Range<usize>| {
        let (mut both, mut nominal) = (0.0, 0.0);
        for run in runs {
            for speeds in log.wheel_speeds(run) {
                let [_, told] = log.robot.twist(speeds);
                let factor = skid.at(told, log.robot.turn_rad_s) * log.runs[run].floor.track;
                both += told * told / factor;
                nominal += told * told;
            }
        }
        let scale = rounded(nominal / both.max(f64::MIN_POSITIVE));
        LogEffect {
            tolerance: spread,
            ..LogEffect::new("track_width", &[("scale", scale)])
        }
    };
    if one_floor {
        vec![effect(0..log.runs.len())]
    } else {
        (0..log.runs.len())
            .map(|run| effect(run..run + 1).in_run(run))
            .collect()
    }
}

fn concealed(effect: &LogEffect, log: &Log) -> ConcealedEffect {
    let value = |(name, value): &(&str, Value)| {
        let value = match value {
            Value::Number(number) => ParameterValue::Number(*number),
            Value::Text(text) => ParameterValue::Text((*text).to_owned()),
        };
        ((*name).to_owned(), value)
    };
    let names = effect.parameters.iter().map(|(name, _)| *name);
    let tolerances =
        names.filter_map(|name| Some((name.to_owned(), rounded(tolerance(effect, name, log)?))));
    ConcealedEffect {
        effect: effect.id.to_owned(),
        robot: run_name(0),
        parameters: effect.parameters.iter().map(value).collect(),
        channels: words(channels(effect.id)),
        confusions: words(&look_alikes(effect.id, log)),
        intervals_s: Vec::new(),
        expected_gain: None,
        deviations: BTreeMap::new(),
        runs: effect.run.into_iter().map(run_name).collect(),
        tolerances: tolerances.collect(),
    }
}

/// Speed lost in turns is no effect of the vocabulary: a law over the turn rate.
fn turn_loss(log: &Log) -> Option<UnknownPhysics> {
    let loss_m = log.plant.turn_loss_m;
    (loss_m > 0.0).then(|| UnknownPhysics {
        robot: run_name(0),
        kind: "turn_loss".to_owned(),
        parameters: BTreeMap::from([(
            "loss_m".to_owned(),
            ParameterValue::Number(rounded(loss_m)),
        )]),
        channels: words(&["longitudinal", "wheel_right", "wheel_left"]),
        driver: words(&["w"]),
        intervals_s: Vec::new(),
        expected_gain: None,
    })
}

/// The streams in words.
fn streams(log: &Log) -> String {
    let all = Source::ALL.into_iter().filter(|source| log.has(*source));
    all.map(Source::name).collect::<Vec<_>>().join(" ")
}

/// How the case was made, for human readers.
fn notes(log: &Log) -> BTreeMap<String, String> {
    let robot = &log.robot;
    let durations: Vec<String> = log
        .runs
        .iter()
        .map(|run| run.duration_s.to_string())
        .collect();
    let mut notes = BTreeMap::from([
        ("course", format!("{:?}", log.course).to_lowercase()),
        ("durations_s", durations.join(" ")),
        ("largest_speed_m_s", robot.speed_m_s.to_string()),
        ("largest_turn_rad_s", robot.turn_rad_s.to_string()),
        ("noise_m_rad_rad_s", format!("{:?}", log.sensors.noise)),
    ]);
    for drawn in log.nuisances.iter().filter(|drawn| !drawn.on.is_empty()) {
        let on = drawn.on.iter().map(|source| source.name());
        let words = format!(
            "{} (size {:.2})",
            on.collect::<Vec<_>>().join(" "),
            drawn.size
        );
        notes.insert(TABLE[drawn.row].name, words);
    }
    if let Some(skid) = &log.plant.skid {
        notes.insert("skid", format!("{skid:?}"));
    }
    if log.plant.slow[0] > 0.0 {
        notes.insert("slow_share_time_s", format!("{:?}", log.plant.slow));
    }
    for (at, noise) in log.plant.noise.iter().enumerate() {
        notes.insert(
            ["noise_1", "noise_2", "noise_3"][at.min(2)],
            format!("{noise:?}"),
        );
    }
    notes
        .into_iter()
        .map(|(key, text)| (key.to_owned(), text))
        .collect()
}
