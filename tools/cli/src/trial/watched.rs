//! `slipstream trial --on RECORDING --watch`: changes that begin while a robot drives.

mod kinds;
mod scored;
mod text;

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use slipstream_bus::{InputError, RobotModel};
use slipstream_diagnose::{Event, Request, Smallest, Watch};
use slipstream_recording::{Pieces, Recording, mended};
use slipstream_trial::own::{alone, changed_since, half, span_s};

use self::kinds::{Kind, MULTIPLES};
use self::scored::{Case, Scores};
use super::text::ended;
use crate::exit::{Error, Exit};
use crate::interrupt::Stop;
use crate::models::Models;
use crate::output_file::{self, write_json};
use crate::progress;
use crate::reading::Reading;

/// Where in the rows a change begins.
const BEGINS: f64 = 1.0 / 3.0;
/// Length of the pieces that are heard (s).
const PIECE_S: f64 = 0.5;

/// What is asked.
pub(super) struct Asked<'a> {
    /// The recording, how to read it, and its model.
    pub(super) on: &'a Path,
    pub(super) reading: &'a Reading,
    pub(super) robot: &'a [String],
    /// Recordings that are the baseline, in place of the first half.
    pub(super) against: &'a [PathBuf],
    /// Effects that are not tried.
    pub(super) without: &'a [String],
    pub(super) json: Option<&'a Path>,
    pub(super) stop: &'a Stop,
}

/// Runs the command.
pub(super) fn run(asked: &Asked<'_>) -> Result<Exit, Error> {
    let models = Models::read(asked.robot)?;
    let read = |path: &Path| -> Result<Recording, Error> {
        let recording = asked.reading.read(path, &models)?.recording;
        let first = recording.robots.first();
        let model = first.and_then(|robot| models.of(&robot.name));
        let model = model.or_else(|| recording.model.clone());
        let (mended, _) = mended(&recording, &|_| model.clone());
        let own = Recording {
            model,
            ..alone(&mended)
        };
        Ok(own)
    };
    let whole = read(asked.on)?;
    let place = asked.on.display().to_string();
    let model = whole.model.clone().ok_or_else(|| {
        InputError::new(&place, "has no model", "give one with --robot robot.toml")
    })?;
    let others = asked.against.iter().map(|path| read(path));
    let others: Vec<Recording> = others.collect::<Result<_, _>>()?;
    let (baseline, heard) = parts(&whole, others, &model);
    let line = progress::line();
    let mut watch = Watch::new(&Request {
        recordings: &baseline,
        against: &[],
        model_of: &|_| Some(model.clone()),
        excluded: asked.without,
        excluded_s: &[],
        progress: &|step| line.set_message(step.to_owned()),
    })?;
    line.finish_and_clear();
    let span_s = heard.robots.first().map(span_s);
    let [from_s, to_s] = span_s.filter(|[a, b]| a <= b).ok_or_else(|| {
        InputError::new(&place, "has no rows to watch", "give a longer recording")
    })?;
    let onset_s = from_s + (to_s - from_s) * BEGINS;
    let (null, limits) = unchanged(&mut watch, &heard, onset_s);
    let mut scores = Scores::new(&whole.name, to_s - from_s, onset_s - from_s, &null);
    let mut kinds = kinds::all(&heard, &model);
    kinds.retain(|own| limits.last(own).is_some());
    let bar = progress::bar(kinds.len() * MULTIPLES.len(), "watched");
    asked.stop.keep();
    'cases: for (number, kind) in kinds.iter().enumerate() {
        for (place, multiple) in MULTIPLES.into_iter().enumerate() {
            bar.inc(1);
            scores.interrupted = asked.stop.asked.load(Ordering::Relaxed);
            if scores.interrupted {
                break 'cases;
            }
            let Some(smallest) = limits.last(kind) else {
                continue;
            };
            let size = smallest * multiple;
            if size > kind.most {
                continue;
            }
            let is_positive = kind.effect == "actuator_delay" || (number + place) % 2 == 0;
            let signed = if is_positive { size } else { -size };
            let change = (kind.of)(signed);
            let copy = changed_since(&heard, &model, &change, onset_s);
            let events = replay(&mut watch, copy);
            scores.add(
                Case::new(kind, (multiple, signed), &change, onset_s, &events, &heard),
                limits.seen_s(kind, size),
            );
        }
    }
    bar.finish_and_clear();
    if let Some(file) = asked.json {
        write_json(&output_file::place(file, scores.interrupted), &scores)?;
    }
    text::print(&scores);
    Ok(ended(scores.interrupted))
}

/// The baseline and what is heard: other recordings and the whole; of several runs all but the last and that one; or else
/// both halves.
fn parts(
    whole: &Recording,
    others: Vec<Recording>,
    model: &RobotModel,
) -> (Vec<Recording>, Recording) {
    let named = |own: Recording| Recording {
        model: Some(model.clone()),
        ..own
    };
    if !others.is_empty() {
        let mut heard = whole.clone();
        heard.robots.truncate(1);
        return (others, heard);
    }
    if whole.same_robot && whole.robots.len() > 1 {
        let (mut baseline, mut heard) = (whole.clone(), whole.clone());
        baseline.robots.pop();
        heard.robots.drain(..whole.robots.len() - 1);
        heard.same_robot = false;
        return (vec![named(baseline)], named(heard));
    }
    let [first, second] = [false, true].map(|own| named(half(whole, own)));
    (vec![first], second)
}

/// The smallest changes that would be seen, over time.
struct SmallestChanges {
    onset_s: f64,
    looks: Vec<(f64, Vec<Smallest>)>,
}

impl SmallestChanges {
    fn of(all: &[Smallest], kind: &Kind) -> Option<f64> {
        let mut all = all.iter();
        let is_it = |own: &&Smallest| {
            own.effect == kind.effect && own.parameter == kind.parameter && own.both == kind.both
        };
        all.find(is_it)
            .map(|own| own.size)
            .filter(|own| own.is_finite())
    }

    /// At the end.
    fn last(&self, kind: &Kind) -> Option<f64> {
        Self::of(&self.looks.last()?.1, kind)
    }

    /// How long after its begin a change of this size would be expected to be seen (s).
    fn seen_s(&self, kind: &Kind, size: f64) -> Option<f64> {
        let mut looks = self.looks.iter();
        let is_seen =
            |own: &&(f64, Vec<Smallest>)| Self::of(&own.1, kind).is_some_and(|own| own <= size);
        looks.find(is_seen).map(|own| own.0 - self.onset_s)
    }
}

/// What is said of a copy without a change, and what would be seen in it.
fn unchanged(watch: &mut Watch, heard: &Recording, onset_s: f64) -> (Vec<Event>, SmallestChanges) {
    let mut limits = SmallestChanges {
        onset_s,
        looks: Vec::new(),
    };
    watch.again();
    let mut events = Vec::new();
    for (end_s, piece) in Pieces::new(heard.clone(), PIECE_S) {
        events.extend(watch.hear(&piece));
        if end_s > onset_s {
            limits.looks.push((end_s, watch.smallest(onset_s)));
        }
    }
    (events, limits)
}

/// What is said of a copy until the first change is settled, by the rows alone.
fn replay(watch: &mut Watch, copy: Recording) -> Vec<Event> {
    watch.again();
    let pieces = Pieces::new(copy, PIECE_S);
    pieces.flat_map(|(_, piece)| watch.hear(&piece)).collect()
}
