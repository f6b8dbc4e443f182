//! What a robot does when all is well: recordings of it, or the begin of what is heard.

use std::path::PathBuf;

use slipstream_answer::Verdict;
use slipstream_diagnose::{Request, Watch, diagnose};
use slipstream_recording::recording::Robot;
use slipstream_recording::{Recording, joined};

use super::spoken::Spoken;
use crate::exit::Error;
use crate::models::Models;
use crate::print::note_line;
use crate::progress;
use crate::reading::Reading;

/// Rows that were heard.
#[derive(Default)]
pub(super) struct Kept {
    pieces: Vec<Recording>,
    span_s: Option<[f64; 2]>,
}

impl Kept {
    pub(super) fn keep(&mut self, piece: Recording) {
        for t_s in piece.robots.iter().flat_map(ends_s) {
            let [from_s, to_s] = self.span_s.unwrap_or([t_s; 2]);
            self.span_s = Some([from_s.min(t_s), to_s.max(t_s)]);
        }
        self.pieces.push(piece);
    }

    /// From the first row to the last (s).
    pub(super) fn span_s(&self) -> f64 {
        self.span_s.map_or(0.0, |[from_s, to_s]| to_s - from_s)
    }

    fn joined(&self) -> Option<Recording> {
        joined(self.pieces.iter(), f64::NEG_INFINITY)
    }
}

/// The stamps at which each stream begins and ends (s).
fn ends_s(robot: &Robot) -> impl Iterator<Item = f64> {
    let both = robot.stamps().flat_map(|own| [own.first(), own.last()]);
    let known = both.flatten().copied();
    known.filter(|t_s| t_s.is_finite())
}

/// Makes watches of baselines.
pub(super) struct Learner<'a> {
    models: &'a Models,
    excluded: &'a [String],
    kept: Kept,
    baseline: Vec<Recording>,
}

impl<'a> Learner<'a> {
    pub(super) fn new(models: &'a Models, excluded: &'a [String]) -> Self {
        Self {
            models,
            excluded,
            kept: Kept::default(),
            baseline: Vec::new(),
        }
    }

    /// A watch beside recordings.
    pub(super) fn of_files(
        &mut self,
        files: &[PathBuf],
        reading: &Reading,
    ) -> Result<Watch, Error> {
        for file in files {
            self.baseline
                .push(reading.read(file, self.models)?.recording);
        }
        self.learn()
    }

    /// Hears a piece of the begin; the watch, once it has so many seconds.
    pub(super) fn hear(&mut self, piece: Recording, learn_s: f64) -> Result<Option<Watch>, Error> {
        self.kept.keep(piece);
        if self.kept.span_s() < learn_s {
            return Ok(None);
        }
        self.baseline = std::mem::take(&mut self.kept)
            .joined()
            .into_iter()
            .collect();
        let watch = self.learn()?;
        note_line!("baseline learnt from the first {learn_s} s; watching");
        Ok(Some(watch))
    }

    fn learn(&self) -> Result<Watch, Error> {
        let line = progress::line();
        let request = Request {
            recordings: &self.baseline,
            against: &[],
            model_of: &|robot| self.models.of(robot),
            excluded: self.excluded,
            excluded_s: &[],
            progress: &|step| line.set_message(step.to_owned()),
        };
        let watch = Watch::new(&request);
        line.finish_and_clear();
        Ok(watch?)
    }

    /// Says what differs in rows that were heard; whether anything does, and whether it has a name.
    pub(super) fn compare(&self, heard: &Kept, spoken: &mut Spoken) -> Result<Verdict, Error> {
        let recordings: Vec<Recording> = heard.joined().into_iter().collect();
        let line = progress::line();
        let request = Request {
            recordings: &recordings,
            against: &self.baseline,
            model_of: &|robot| self.models.of(robot),
            excluded: self.excluded,
            excluded_s: &[],
            progress: &|step| line.set_message(step.to_owned()),
        };
        let answer = diagnose(&request);
        line.finish_and_clear();
        let (answer, _) = answer?;
        spoken.compared(&answer, heard.span_s)?;
        Ok(if answer.findings.is_empty() {
            answer.verdict
        } else {
            Verdict::Explained
        })
    }
}
