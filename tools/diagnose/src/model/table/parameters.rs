//! The parameters of one machine, and its terms.

use super::draft::{Draft, Drafted, Place, Row, about, acts};
use super::known::{Asked, Known};
use super::sizes::{FACTOR, STAMP_SHARE, USUAL, repeatability};
use crate::estimate::Prior;
use crate::estimate::term::Term;
use crate::model::wheel_parameters::{
    RUN_BIAS, RUN_LATE, RUN_POSE_LATE, RUN_RATE, RUN_SCALE, RUN_TRACK,
};

/// Which parameter it is: the same in the table of all runs and in that of today's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key {
    pub(crate) name: &'static str,
    /// Number of the robot counted from the first of today's: negative of runs from before.
    pub(crate) robot: Option<i64>,
    pub(crate) number: usize,
    /// Of runs from before and of today alike, where these are compared.
    pub(crate) is_shared: bool,
}

impl Key {
    /// The first parameter of a name, of a robot or of the machine.
    pub(crate) fn of(name: &'static str, robot: Option<i64>) -> Self {
        Self {
            name,
            robot,
            number: 0,
            is_shared: false,
        }
    }
}

/// The parameters of one machine, and its terms.
#[derive(Debug, Default)]
pub(crate) struct Table {
    /// How each parameter moves what the filters read.
    pub(crate) weights: Vec<Vec<(usize, f64)>>,
    pub(crate) priors: Vec<Prior>,
    /// Longest step of each in one iteration of a fit.
    pub(crate) longest: Vec<f64>,
    pub(crate) keys: Vec<Key>,
    pub(crate) terms: Vec<Term>,
    /// Parameters that are always free and no noise sizes.
    pub(crate) always: Vec<usize>,
    pub(crate) noise: Vec<usize>,
    /// The filters that each parameter moves, a bit for each: of the reference, of the drive.
    pub(crate) parts: Vec<u8>,
    /// Of a change, what runs from before have of the same parameter.
    pub(crate) twins: Vec<Option<usize>>,
    resolution: Vec<f64>,
    repeatability: Vec<f64>,
}

impl Table {
    pub(crate) fn new(asked: &Asked<'_>) -> Self {
        let mut table = Self::default();
        let known = Known::new(asked);
        for term in known.terms() {
            table.add(asked, &known, term);
        }
        table.add_runs(asked);
        table.add_noise(asked);
        let first = asked.streams.drive_first();
        let part = |(index, _): &(usize, f64)| if *index < first { 1 } else { 2 };
        let of = |weights: &Vec<(usize, f64)>| weights.iter().fold(0, |all, own| all | part(own));
        table.parts = table.weights.iter().map(of).collect();
        table
    }

    pub(crate) fn parameters(&self) -> usize {
        self.weights.len()
    }

    /// Variance by which two recordings of one unchanged machine differ in a parameter.
    pub(crate) fn repeats(&self, parameter: usize) -> f64 {
        self.repeatability[parameter]
    }

    pub(crate) fn find(&self, key: &Key) -> Option<usize> {
        self.keys.iter().position(|own| own == key)
    }

    pub(super) fn push(
        &mut self,
        key: Key,
        weights: Vec<(usize, f64)>,
        prior: Prior,
        longest: f64,
    ) -> usize {
        self.keys.push(key);
        self.weights.push(weights);
        self.priors.push(prior);
        self.longest.push(longest);
        self.twins.push(None);
        self.resolution.push(0.0);
        self.repeatability.push(0.0);
        self.keys.len() - 1
    }

    /// The parameter of a row, or what runs from before share with those of today of it.
    fn row(&mut self, asked: &Asked<'_>, row: &Row, is_shared: bool) -> usize {
        let key = Key {
            name: row.name,
            robot: None,
            number: row.number,
            is_shared,
        };
        if let Some(known) = self.find(&key) {
            return known;
        }
        // a part without runs from before has nothing to share with them
        let has = |place: Place| !is_shared || asked.compares(place);
        let moves = row.moves.iter().filter(|(place, _)| has(*place));
        let weights = moves
            .map(|(place, weight)| (asked.index(*place, is_shared), *weight))
            .collect();
        let prior = if is_shared {
            Prior {
                mean: 0.0,
                ..row.prior
            }
        } else {
            row.prior
        };
        let at = self.push(key, weights, prior, row.prior.reach() / 2.0);
        self.resolution[at] = row.resolution * row.resolution;
        self.repeatability[at] = row.repeatability * row.repeatability;
        at
    }

    fn add(&mut self, asked: &Asked<'_>, known: &Known<'_>, draft: Draft) {
        let allowed = |effect: &&str| !asked.excluded.iter().any(|own| own == effect);
        let is_law = draft.shown.iter().any(|shown| shown.effect == "unknown");
        if is_law && !allowed(&"motion_law") || draft.rows.is_empty() {
            return;
        }
        let mut term = Term {
            name: draft.name,
            parameters: Vec::new(),
            resolution: Vec::new(),
            repeatability: Vec::new(),
            inflation: draft.inflation,
            cost: draft.cost,
            search: draft.search,
            usual: USUAL.contains(&draft.name),
            positive: draft.positive,
            needs_relevance: draft.needs_relevance,
            rare: false,
            kinked: draft.positive || draft.name == "lag",
            acts: acts(&draft.rows),
            shown: Vec::new(),
        };
        let compares = asked.streams.compares();
        for row in &draft.rows {
            let at = match row {
                Drafted::Machine(row) => {
                    let at = self.row(asked, row, false);
                    if compares {
                        let twin = self.row(asked, row, true);
                        self.twins[at] = Some(twin);
                        if known.had(asked, row, draft.later) && !self.always.contains(&twin) {
                            self.always.push(twin);
                        }
                    }
                    at
                }
                Drafted::Run {
                    name,
                    run,
                    place,
                    deviation,
                } => self.of_run(asked, name, *run, *place, *deviation),
            };
            term.parameters.push(at);
        }
        term.resolution = term
            .parameters
            .iter()
            .map(|i| self.resolution[*i])
            .collect();
        term.repeatability = term.parameters.iter().map(|_| 0.0).collect();
        if compares {
            let own = term.parameters.iter().map(|i| self.repeatability[*i]);
            term.repeatability = own.collect();
        }
        let nuisance = draft.shown.is_empty();
        for shown in draft.shown {
            if allowed(&shown.effect) {
                term.shown.push(shown.attribution(&term.parameters));
            }
        }
        // what a machine is compared with has its nuisances already
        if nuisance && (!compares || draft.varies) || !term.shown.is_empty() {
            self.terms.push(term);
        }
    }

    fn of_run(
        &mut self,
        asked: &Asked<'_>,
        name: &'static str,
        run: usize,
        parameter: usize,
        deviation: f64,
    ) -> usize {
        let reference = asked.streams.reference;
        let key = Key::of(
            name,
            Some(robot(reference.runs[run].robot, reference.before.robots)),
        );
        let index = reference.of_run(run, parameter);
        if let Some(known) = self.find(&key) {
            return known;
        }
        let at = self.push(
            key,
            vec![(index, 1.0)],
            about(deviation),
            deviation.min(0.3) / 1.5,
        );
        if parameter == RUN_POSE_LATE {
            let stamp_s = STAMP_SHARE * reference.runs[run].pose_interval_s();
            self.resolution[at] = stamp_s * stamp_s;
            return at;
        }
        self.resolution[at] = FACTOR * FACTOR;
        let place = usize::from(parameter == RUN_TRACK);
        let spread = reference.before.spread[place].unwrap_or(0.0);
        let own = [repeatability::SCALE, repeatability::TRACK][place].hypot(spread);
        self.repeatability[at] = own * own;
        at
    }

    /// Biases and clocks of single runs, which belong to sensors; scales and tracks of runs from before.
    fn add_runs(&mut self, asked: &Asked<'_>) {
        let reference = asked.streams.reference;
        let clocks = reference.has_clocks_of_runs();
        for (i, run) in reference
            .runs
            .iter()
            .enumerate()
            .filter(|(_, run)| run.gyro.is_some())
        {
            let mut own = vec![("gyro bias", RUN_BIAS, 0.02)];
            if clocks && reference.as_before(i).is_none() {
                own.extend([("run late", RUN_LATE, 0.3), ("run rate", RUN_RATE, 0.003)]);
            }
            for (name, parameter, deviation) in own {
                let key = Key::of(name, Some(robot(run.robot, reference.before.robots)));
                let index = vec![(reference.of_run(i, parameter), 1.0)];
                let at = self.push(key, index, about(deviation), deviation / 2.0);
                self.always.push(at);
            }
        }
        let spread = reference.before.spread;
        let own = [("run scale", RUN_SCALE), ("run track", RUN_TRACK)];
        for ((name, parameter), spread) in own.into_iter().zip(spread) {
            let Some(spread) = spread else { continue };
            for run in 0..reference.before.runs {
                let at = self.of_run(asked, name, run, parameter, spread);
                self.always.push(at);
            }
        }
    }
}

pub(super) fn robot(robot: usize, before: usize) -> i64 {
    robot as i64 - before as i64
}
