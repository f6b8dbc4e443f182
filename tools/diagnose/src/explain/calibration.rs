//! Calibration of one machine from its wheels and a reference: a fit with every term, from several
//! starts, then backward elimination.

use super::drive_terms::DEAD_ZONE_SHARE;
use super::prediction::reference_error;
use super::term::{
    BAND_TERM, DELAY_TERM, FLOOR, GEOMETRY, LAG_TERM, OFFSET, OFFSET_TURN, RATE_NATS,
    SATURATION_TERM, USE_SHARE,
};
use super::terms;
use super::thinning::is_white;
use super::thresholds::{Thresholds, levels};
use crate::estimate::blocks;
use crate::estimate::cluster::Precision;
use crate::estimate::scoring::{FULL, Fit, Problem, SHORT, SearchLimits};
use crate::model::drive::{DEAD_BAND, DEAD_ZONE, DELAY, LAG, SATURATION};
use crate::model::from_wheels::{
    COMMON, DRIVE_FIRST, FromWheels, GYRO_LATENCY, GYRO_RATE, MACHINE, POSE_LATENCY, POSE_RATE,
    RUN_BIAS, RUN_LATE, RUN_RATE, RUN_SCALE, RUN_TRACK, Reference, TRACK, View,
};
use crate::model::run::Source;
use crate::select::criterion::Criterion;
use crate::select::elimination::{Elimination, Kept, Selected, Shared, Term};

/// The first fit, without outliers: it need not be finished.
const ROUGH: SearchLimits = SearchLimits {
    iterations: 25,
    tolerance_nats: 0.5,
};
/// Latencies from which the search starts (s).
const LATENCIES_S: [f64; 12] = [
    -0.3, -0.25, -0.2, -0.15, -0.1, -0.05, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3,
];
/// Side maxima lie about one sampling interval beside the best one (s).
const BESIDE_S: [f64; 6] = [-0.1, -0.05, -0.025, 0.025, 0.05, 0.1];
/// Where the search looks for them.
const LATENCIES: [usize; 3] = [POSE_LATENCY, GYRO_LATENCY, DRIVE_FIRST + DELAY];
/// Grid of the clocks of single runs: steps to each side, latency (s) and rate of a step.
const RUN_STEPS: i32 = 8;
const RUN_LATE_S: f64 = 0.06;
const RUN_RATE_STEP: f64 = 1e-3;
/// Lag of a drive from which the search starts (s).
const LAG_S: f64 = 0.05;
/// A start this much worse than the best is not followed (nats).
const FOLLOWED_NATS: f64 = 5.0;
/// A start beside the best this much worse is not followed (nats).
const BESIDE_NATS: f64 = 20.0;
/// Runs differ when the probability of their spread without a difference is below this.
const RUNS_DIFFER: f64 = 1e-3;
/// Differences of scale and of track between runs that nobody would call one.
const RUN_FLOORS: [f64; 2] = [0.01, 0.02];

/// What a calibration found.
pub(crate) struct Calibration {
    pub(crate) after: Selected,
    /// Whether scale and track are those of each run.
    pub(crate) by_run: [bool; 2],
    pub(crate) criterion: Criterion,
    /// Ends of the interval in which a dead band of the drive cannot be told apart (rad/s).
    pub(crate) band_rad_s: [f64; 2],
    /// The machine with poses at full rate, where their errors are independent and all are evidence.
    pub(crate) dense: Option<FromWheels>,
    /// The fit beside runs from before, of which this is today's part.
    pub(crate) joint: Option<Joint>,
}

/// A fit of runs from before and of today.
pub(crate) struct Joint {
    pub(crate) machine: FromWheels,
    pub(crate) nominal: Vec<f64>,
    pub(crate) after: Selected,
}

impl Calibration {
    /// Calibrates; `None` where nothing can be compared.
    pub(crate) fn new(machine: &FromWheels, nominal: &[f64], excluded: &[String]) -> Option<Self> {
        if !machine.has_pose() && !machine.has_gyro() {
            return None;
        }
        let (thin, start) = Search::over(machine, nominal, excluded, |search| {
            let mut terms = search.terms([false; 2]);
            let (fit, band_rad_s) = search.full(&mut terms);
            let start = fit.at.clone();
            let dense = machine.dense().filter(|dense| {
                Search::over(dense, nominal, excluded, |search| {
                    let refitted = search.problem.fit(&start, search.noise, FULL);
                    is_white(dense, &refitted.at, Reference::Pose)
                })
            });
            match dense {
                Some(dense) => (Err(dense), start),
                None => (Ok(search.finished(fit, terms, band_rad_s)), start),
            }
        });
        match thin {
            Ok(calibration) => calibration,
            Err(dense) => {
                let found = Search::over(&dense, nominal, excluded, |search| {
                    let mut terms = search.terms([false; 2]);
                    let (fit, band_rad_s) = search.refined(&start, &mut terms);
                    search.finished(fit, terms, band_rad_s)
                });
                found.map(|found| Self {
                    dense: Some(dense),
                    ..found
                })
            }
        }
    }
}

/// The search for the fit with every term.
struct Search<'a> {
    machine: &'a FromWheels,
    problem: &'a Problem<'a>,
    nominal: &'a [f64],
    always: &'a [usize],
    noise: &'a [usize],
    excluded: &'a [String],
    useful: &'a dyn Fn(&Fit, &Fit) -> bool,
}

impl Search<'_> {
    /// Calls `with` with the search over a machine.
    fn over<T>(
        machine: &FromWheels,
        nominal: &[f64],
        excluded: &[String],
        with: impl FnOnce(&Search<'_>) -> T,
    ) -> T {
        let robust = View {
            machine,
            robust: true,
        };
        let problem = machine.problem(&robust, nominal);
        let own: &[usize] = if machine.has_clocks_of_runs() {
            &[RUN_BIAS, RUN_LATE, RUN_RATE]
        } else {
            &[RUN_BIAS]
        };
        let mut always: Vec<usize> = (0..machine.runs.len())
            .filter(|i| machine.runs[*i].gyro.is_some())
            .flat_map(|i| {
                let clocks = machine.as_before(i).is_none();
                own.iter()
                    .filter(move |parameter| **parameter == RUN_BIAS || clocks)
                    .map(move |parameter| machine.of_run(i, *parameter))
            })
            .collect();
        if machine.before.any() {
            always.extend(terms::shared(machine, nominal, excluded));
        }
        let noise = machine.noise();
        with(&Search {
            machine,
            problem: &problem,
            nominal,
            always: &always,
            noise: &noise,
            excluded,
            useful: &|with, without| {
                reference_error(machine, &with.at)
                    < (1.0 - USE_SHARE) * reference_error(machine, &without.at)
            },
        })
    }

    /// The calibration from the fit with all of `terms`.
    fn finished(
        &self,
        mut fit: Fit,
        mut terms: Vec<Term>,
        band_rad_s: [f64; 2],
    ) -> Option<Calibration> {
        let mut by_run = [false; 2];
        let before = &self.machine.before;
        if self.machine.runs.len() > before.runs + 1 || before.spread.iter().any(Option::is_some) {
            let mut names: Vec<&str> = terms.iter().map(|t| t.name).collect();
            if names.contains(&GEOMETRY) {
                names.push(FLOOR);
            }
            let same = |other: Vec<Term>| -> Vec<Term> {
                let own = other.into_iter().filter(|t| names.contains(&t.name));
                own.collect()
            };
            let apart = same(self.terms([true; 2]));
            let (free, physics) = self.elimination(&apart).free(&apart);
            let own = self.of_runs(&fit.at, &free);
            by_run = self.differ(&own, &Precision::new(self.problem, &own, physics)?);
            let known = before.spread.map(|spread| spread.is_some());
            by_run = [by_run[0] || known[0], by_run[1] || known[1]];
            if by_run != [false; 2] {
                terms = same(self.terms(by_run));
                let mut at = own.at.clone();
                self.settle(&mut at, &terms);
                let free = self.elimination(&terms).free(&terms).0;
                fit = self.problem.fit(&at, &free, FULL);
            }
        }
        fit = self.with_law(fit, &mut terms);
        let mut elimination = self.elimination(&terms);
        let after = elimination.settled(fit, &mut terms)?;
        let after = elimination.rivals(after, [DELAY_TERM, LAG_TERM], &terms)?;
        let after = self.offsets_together(after, &terms)?;
        let before = &self.machine.before;
        let runs = self.machine.runs.iter().take(before.runs);
        let first = blocks::total(runs.map(|run| run.blocks));
        let after = elimination.halved(after, before.is_paired(), first);
        Some(Calibration {
            after,
            by_run,
            criterion: elimination.criterion,
            band_rad_s,
            dense: None,
            joint: None,
        })
    }

    /// The fit in which every run has its own scale and track. Where runs differ much, what they share
    /// makes all rows of some of them outliers: it starts also from a fit without outliers.
    fn of_runs(&self, at: &[f64], free: &[usize]) -> Fit {
        let plain = View {
            machine: self.machine,
            robust: false,
        };
        let gaussian = self.machine.problem(&plain, self.nominal);
        let apart = gaussian.fit(at, free, ROUGH);
        let fits = [at, &apart.at].map(|start| self.problem.fit(start, free, FULL));
        let [own, other] = fits;
        if other.objective > own.objective {
            other
        } else {
            own
        }
    }

    /// The fit with all terms and with a law that the catalogue does not have, where it gains beside
    /// everything else.
    fn with_law(&self, full: Fit, terms: &mut Vec<Term>) -> Fit {
        let elimination = self.elimination(terms);
        let with_law = |start: &[f64], own: &[Term], law: &Term, limits: SearchLimits| {
            let mut at = start.to_vec();
            for index in &law.parameters {
                // at exactly 0 the filter leaves a law out
                at[*index] += f64::MIN_POSITIVE;
            }
            let all = [own, std::slice::from_ref(law)].concat();
            self.problem.fit(&at, &elimination.free(&all).0, limits)
        };
        let laws = terms::laws(self.machine, self.excluded);
        let tried = laws
            .into_iter()
            .map(|law| (with_law(&full.at, terms, &law, SHORT), law));
        let best = tried.max_by(|a, b| a.0.objective.total_cmp(&b.0.objective));
        let Some((beside, law)) = best else {
            return full;
        };
        let least = elimination.criterion.least_gain(law.parameters.len());
        if beside.objective - full.objective < least {
            return full;
        }
        let beside = with_law(&beside.at, terms, &law, FULL);
        // thresholds and geometry may have stood in for it
        let stand_in = |t: &Term| [GEOMETRY, SATURATION_TERM, BAND_TERM].contains(&t.name);
        let mut at = full.at;
        let gone = terms.iter().filter(|t| stand_in(t));
        for index in gone.flat_map(|t| &t.parameters) {
            at[*index] = self.nominal[*index];
        }
        let honest: Vec<Term> = terms
            .iter()
            .filter(|t| t.name != SATURATION_TERM && t.name != BAND_TERM)
            .cloned()
            .collect();
        let other = with_law(&at, &honest, &law, FULL);
        let first = if other.objective > beside.objective - FOLLOWED_NATS {
            *terms = honest;
            other
        } else {
            beside
        };
        terms.push(law);
        first
    }

    fn elimination(&self, terms: &[Term]) -> Elimination<'_> {
        Elimination {
            shared: self.machine.before.any().then(|| Shared {
                first: self.machine.shared(0),
                count: MACHINE,
            }),
            problem: self.problem,
            neutral: self.nominal,
            always: self.always.to_vec(),
            noise: self.noise,
            criterion: Criterion::of(self.problem.likelihood, terms.len()),
            useful: self.useful,
        }
    }

    /// Every term that the streams can show. `by_run`: scale and track are those of each run.
    fn terms(&self, by_run: [bool; 2]) -> Vec<Term> {
        terms::terms(self.machine, self.excluded, by_run)
    }

    /// The fit with all of `terms`: first without outliers and clocks, then with outliers, then from
    /// several latencies. Rates of clocks that gain little are taken out of `terms`.
    fn full(&self, terms: &mut Vec<Term>) -> (Fit, [f64; 2]) {
        let clocks = [
            POSE_LATENCY,
            GYRO_LATENCY,
            POSE_RATE,
            GYRO_RATE,
            DRIVE_FIRST + DELAY,
            DRIVE_FIRST + LAG,
            // a start without them has no derivative by them, or a wrong one
            DRIVE_FIRST + SATURATION,
            DRIVE_FIRST + DEAD_ZONE,
        ];
        // what is shared stays as it was before until the changes are found: where a likelihood has several
        // maxima, both together would settle between them
        let shared = |i: usize| self.machine.before.any() && i >= self.machine.shared(0);
        let free_of = |keep: &dyn Fn(usize) -> bool, terms: &[Term]| {
            let (free, _) = self.elimination(terms).free(terms);
            let own = free.into_iter().filter(|i| keep(*i) && !shared(*i));
            own.collect::<Vec<_>>()
        };
        let plain = View {
            machine: self.machine,
            robust: false,
        };
        let gaussian = self.machine.problem(&plain, self.nominal);
        let is_clock = |i: usize| {
            let runs = 0..self.machine.runs.len();
            clocks.contains(&i)
                || runs
                    .flat_map(|run| [RUN_LATE, RUN_RATE].map(|p| self.machine.of_run(run, p)))
                    .any(|own| own == i)
        };
        let still = free_of(&|i| !is_clock(i), terms);
        let mut start = self.nominal.to_vec();
        let crude = self.machine.crude_scale;
        if !self.machine.before.any() && still.contains(&COMMON) && crude != 0.0 {
            start[COMMON] = crude;
        }
        let mut at = gaussian.fit(&start, &still, ROUGH).at;
        for index in self.noise {
            at[*index] -= 0.3;
        }
        let first = self.problem.fit(&at, &still, ROUGH);
        let saturation = DRIVE_FIRST + SATURATION;
        let rates = [POSE_RATE, GYRO_RATE];
        let lean = free_of(&|i| !rates.contains(&i) && i != saturation, terms);
        let mut first = first;
        if lean.contains(&(DRIVE_FIRST + LAG)) {
            // without any lag or dead zone there is no derivative by it
            first.at[DRIVE_FIRST + LAG] += LAG_S;
        }
        if lean.contains(&(DRIVE_FIRST + DEAD_ZONE)) {
            first.at[DRIVE_FIRST + DEAD_ZONE] += DEAD_ZONE_SHARE * self.machine.largest_rad_s();
        }
        if self.machine.has_clocks_of_runs() {
            first = self.clocks_of_runs(first);
        }
        let mut best = self.best_of_latencies(&first, &lean);
        for clock in LATENCIES {
            if lean.contains(&clock) {
                best = self.beside(best, &lean, clock);
            }
        }
        if self.machine.before.any() {
            let kept = |i: &usize| !rates.contains(i) && *i != saturation;
            let (all, _) = self.elimination(terms).free(terms);
            let all: Vec<usize> = all.into_iter().filter(kept).collect();
            best = self.problem.fit(&best.at, &all, FULL);
        }
        let stamped = self.as_stamped(&best.at);
        self.best_with_rates(best, stamped.as_deref(), terms)
    }

    /// Clocks that changed as the stamps of rows did that two recordings of one course have in common.
    fn as_stamped(&self, at: &[f64]) -> Option<Vec<f64>> {
        let before = &self.machine.before;
        let mut at = before.is_paired().then(|| at.to_vec())?;
        let clocks = [[POSE_LATENCY, POSE_RATE], [GYRO_LATENCY, GYRO_RATE]];
        for (own, stamped) in clocks.iter().zip(before.stamped) {
            for (index, change) in own.iter().zip(stamped) {
                let base = self.machine.shared(*index);
                at[*index] = self.nominal[*index] + change;
                at[base] = self.nominal[base];
            }
        }
        Some(at)
    }

    /// `best` with thresholds and rates, or the fit with all of `terms` from `other` where that is better.
    fn best_with_rates(
        &self,
        best: Fit,
        other: Option<&[f64]>,
        terms: &mut Vec<Term>,
    ) -> (Fit, [f64; 2]) {
        let (all, _) = self.elimination(terms).free(terms);
        let every = terms.clone();
        let (best, band_rad_s) = self.with_rates(best, terms);
        let other = other.map(|start| self.problem.fit(start, &all, FULL));
        match other {
            Some(other) if other.objective > best.objective => {
                *terms = every;
                (other, band_rad_s)
            }
            _ => (best, band_rad_s),
        }
    }

    /// The fit with all of `terms` from where a fit to fewer rows ended.
    fn refined(&self, start: &[f64], terms: &mut Vec<Term>) -> (Fit, [f64; 2]) {
        let late = [POSE_RATE, GYRO_RATE, DRIVE_FIRST + SATURATION];
        let (free, _) = self.elimination(terms).free(terms);
        let lean: Vec<usize> = free.into_iter().filter(|i| !late.contains(i)).collect();
        let mut at = start.to_vec();
        for index in late.into_iter().chain([DRIVE_FIRST + DEAD_BAND]) {
            at[index] = self.nominal[index];
        }
        if lean.contains(&(DRIVE_FIRST + LAG)) && at[DRIVE_FIRST + LAG].abs() < LAG_S / 10.0 {
            at[DRIVE_FIRST + LAG] = LAG_S / 10.0;
        }
        let best = self.problem.fit(&at, &lean, FULL);
        let paired = self.machine.before.is_paired();
        self.best_with_rates(best, paired.then_some(start), terms)
    }

    /// `best` with thresholds of the drive and rates of clocks; what gains little is taken out of
    /// `terms`.
    fn with_rates(&self, mut best: Fit, terms: &mut Vec<Term>) -> (Fit, [f64; 2]) {
        let mut band_rad_s = [0.0; 2];
        if self.machine.is_commanded() {
            (best, band_rad_s) = self.with_thresholds(best, terms);
        }
        let (all, _) = self.elimination(terms).free(terms);
        let rated = self.problem.fit(&best.at, &all, FULL);
        if rated.objective - best.objective > RATE_NATS {
            return (rated, band_rad_s);
        }
        terms.retain(|term| {
            !term
                .parameters
                .iter()
                .any(|i| *i == POSE_RATE || *i == GYRO_RATE)
        });
        (best, band_rad_s)
    }

    /// The gyro's clock of each run from the best point of a grid.
    fn clocks_of_runs(&self, mut fit: Fit) -> Fit {
        let view = View {
            machine: self.machine,
            robust: true,
        };
        let all = 0..self.machine.runs.len();
        for run in all.filter(|run| self.machine.as_before(*run).is_none()) {
            let [late, rate] =
                [RUN_LATE, RUN_RATE].map(|parameter| self.machine.of_run(run, parameter));
            let grid = (-RUN_STEPS..=RUN_STEPS)
                .flat_map(|i| (-RUN_STEPS..=RUN_STEPS).map(move |k| [i, k]));
            let of = |[i, k]: [i32; 2]| {
                let mut at = fit.at.clone();
                at[late] = f64::from(i) * RUN_LATE_S;
                at[rate] = f64::from(k) * RUN_RATE_STEP;
                (view.gyro_value(run, &at), at)
            };
            let best = grid.map(of).max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, at)) = best {
                fit.at = at;
            }
        }
        fit
    }

    fn best_of_latencies(&self, first: &Fit, lean: &[usize]) -> Fit {
        let value = self.problem.objective(&first.at, lean);
        let mut starts = vec![first.at.clone()];
        for clock in LATENCIES {
            if !lean.contains(&clock) {
                continue;
            }
            let at = |latency_s: f64| {
                let mut at = first.at.clone();
                at[clock] += latency_s;
                (self.problem.objective(&at, lean), at)
            };
            let best = LATENCIES_S
                .map(at)
                .into_iter()
                .max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, best)) = best.filter(|(own, _)| *own > value - FOLLOWED_NATS) {
                let shifted = starts.iter().map(|start| {
                    let mut start = start.clone();
                    start[clock] = best[clock];
                    start
                });
                starts.extend(shifted.collect::<Vec<_>>());
            }
        }
        let fits = starts
            .iter()
            .map(|start| self.problem.fit(start, lean, SHORT));
        let best = fits.max_by(|a, b| a.objective.total_cmp(&b.objective));
        let best = best.unwrap_or_else(|| first.clone());
        self.problem.fit(&best.at, lean, FULL)
    }

    /// The fit with thresholds of the drive.
    fn with_thresholds(&self, best: Fit, terms: &mut Vec<Term>) -> (Fit, [f64; 2]) {
        let commands = self
            .machine
            .runs
            .iter()
            .filter_map(|run| match &run.wheels {
                Source::Measured(_) => None,
                Source::Commanded(path) => Some(path),
            });
        let thresholds = Thresholds {
            problem: self.problem,
            first: DRIVE_FIRST,
            top_rad_s: self.machine.largest_rad_s(),
            levels_rad_s: levels(commands),
            known: self.machine.before.any().then(|| {
                [SATURATION, DEAD_BAND]
                    .map(|i| self.nominal[self.machine.shared(DRIVE_FIRST + i)] != 0.0)
            }),
        };
        let best = thresholds.saturated(best, terms);
        thresholds.banded(best, terms)
    }

    /// Looks for a better maximum beside the one that was found.
    fn beside(&self, best: Fit, lean: &[usize], clock: usize) -> Fit {
        let mut trials: Vec<(f64, Vec<f64>)> = BESIDE_S
            .iter()
            .map(|shift_s| {
                let mut at = best.at.clone();
                at[clock] += shift_s;
                (self.problem.objective(&at, lean), at)
            })
            .collect();
        trials.sort_by(|a, b| b.0.total_cmp(&a.0));
        trials.retain(|(value, _)| *value > best.objective - BESIDE_NATS);
        let fits = trials
            .iter()
            .take(2)
            .map(|(_, at)| self.problem.fit(at, lean, SHORT));
        let better = fits.max_by(|a, b| a.objective.total_cmp(&b.objective));
        match better {
            Some(better) if better.objective > best.objective + 0.5 => {
                self.problem.fit(&better.at, lean, FULL)
            }
            _ => best,
        }
    }

    /// Whether the scale and the track of the runs differ (Cochran's Q).
    fn differ(&self, fit: &Fit, precision: &Precision) -> [bool; 2] {
        use statrs::distribution::{ChiSquared, ContinuousCDF};
        [(RUN_SCALE, RUN_FLOORS[0]), (RUN_TRACK, RUN_FLOORS[1])].map(|(parameter, floor)| {
            let runs = self.machine.before.runs..self.machine.runs.len();
            let values: Vec<(f64, f64)> = runs
                .filter_map(|run| {
                    let index = self.machine.of_run(run, parameter);
                    let place = fit.free.iter().position(|f| *f == index)?;
                    Some((
                        fit.at[index],
                        precision.covariance[(place, place)] + floor * floor,
                    ))
                })
                .filter(|(_, variance)| variance.sqrt() < 0.15)
                .collect();
            if values.len() < 2 {
                return false;
            }
            let weights: f64 = values.iter().map(|(_, v)| 1.0 / v).sum();
            let mean = values.iter().map(|(x, v)| x / v).sum::<f64>() / weights;
            let q: f64 = values
                .iter()
                .map(|(x, v)| (x - mean) * (x - mean) / v)
                .sum();
            let spread = ChiSquared::new(values.len() as f64 - 1.0).map_or(1.0, |c| c.sf(q));
            spread < RUNS_DIFFER || parameter == RUN_TRACK && self.machine.skids
        })
    }

    /// A mounting is known by place and yaw: where one of them is needed, both are estimated.
    fn offsets_together(&self, found: Selected, terms: &[Term]) -> Option<Selected> {
        let has = |name: &str| found.kept.iter().any(|kept| kept.term.name == name);
        let missing = match [OFFSET, OFFSET_TURN].map(has) {
            [true, false] => OFFSET_TURN,
            [false, true] => OFFSET,
            _ => return Some(found),
        };
        let Some(term) = terms.iter().find(|term| term.name == missing) else {
            return Some(found);
        };
        let mut kept = found.kept;
        kept.push(Kept {
            term: term.clone(),
            gain: 0.0,
            wald: 0.0,
        });
        let all: Vec<Term> = kept.iter().map(|kept| kept.term.clone()).collect();
        let elimination = self.elimination(&all);
        let (free, physics) = elimination.free(&all);
        let fit = self.problem.fit(&found.fit.at, &free, FULL);
        let precision = Precision::new(self.problem, &fit, physics)?;
        if let Some(last) = kept.last_mut() {
            last.term.floors = elimination.floors(term, &fit);
        }
        Some(Selected {
            fit,
            precision,
            kept,
            alike: found.alike,
            halves: None,
        })
    }

    /// Puts what is no longer free back to its nominal value; what is shared again gets the mean of
    /// the runs.
    fn settle(&self, at: &mut [f64], terms: &[Term]) {
        for (shared, own) in [(COMMON, RUN_SCALE), (TRACK, RUN_TRACK)] {
            let indices: Vec<usize> = (self.machine.before.runs..self.machine.runs.len())
                .map(|run| self.machine.of_run(run, own))
                .collect();
            if terms.iter().any(|t| t.parameters.contains(&shared)) {
                let changes = indices.iter().map(|i| at[*i] - self.nominal[*i]);
                let mean = changes.sum::<f64>() / indices.len() as f64;
                at[shared] = self.nominal[shared] + mean;
                indices.iter().for_each(|i| at[*i] = self.nominal[*i]);
            } else {
                at[shared] = self.nominal[shared];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;
    use slipstream_recording::recording::{Pose, Robot, Stream, Wheels};

    use super::*;
    use crate::model::from_wheels::{ASYMMETRY, OFFSET_X, OFFSET_Y};

    const RADIUS_M: f64 = 0.1;
    const HALF_TRACK_M: f64 = 0.3;

    fn nominal() -> RobotModel {
        slipstream_testkit::kinematic(RADIUS_M, HALF_TRACK_M)
    }

    /// A number in [-1, 1] that looks random, the same on every machine.
    fn noise(seed: u64) -> f64 {
        let mut x = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x1234_5678_9ABC_DEF0;
        for shift in [30, 27, 31] {
            x = (x ^ (x >> shift)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        }
        (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Eighty seconds of curves: wheels at 50 Hz, poses at 10 Hz. The wheels are `scale` times as
    /// large as nominal, the camera sits at `offset` (m) and is late.
    fn robot(scale: f64, offset: [f64; 2], latency_s: f64) -> Robot {
        let speeds = |t: f64| {
            let (v, w) = (0.5 + 0.3 * (0.7 * t).sin(), 0.6 * (0.31 * t).sin());
            [
                (v + HALF_TRACK_M * w) / RADIUS_M,
                (v - HALF_TRACK_M * w) / RADIUS_M,
            ]
        };
        let (mut angles, mut pose) = ([0.0_f64; 2], [0.0_f64; 3]);
        let mut wheels = (Vec::new(), Vec::new(), Vec::new());
        let mut seen = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let dt = 1e-3;
        for k in 0..80_000_u64 {
            let t = k as f64 * dt;
            if k % 20 == 0 {
                wheels.0.push(t);
                wheels.1.push(angles[0]);
                wheels.2.push(angles[1]);
            }
            if k % 100 == 7 {
                let (sin, cos) = pose[2].sin_cos();
                let [ox, oy] = offset;
                seen.0.push(t + latency_s);
                seen.1
                    .push(pose[0] + ox * cos - oy * sin + 0.004 * noise(4 * k));
                seen.2
                    .push(pose[1] + ox * sin + oy * cos + 0.004 * noise(4 * k + 1));
                seen.3.push(pose[2] + 0.004 * noise(4 * k + 2));
            }
            let speed = speeds(t + dt / 2.0);
            let turned = speed.map(|s| s * dt);
            angles = [angles[0] + turned[0], angles[1] + turned[1]];
            let way = scale * RADIUS_M * (turned[0] + turned[1]) / 2.0;
            let turn = scale * RADIUS_M * (turned[0] - turned[1]) / (2.0 * HALF_TRACK_M);
            let (sin, cos) = (pose[2] + turn / 2.0).sin_cos();
            pose = [pose[0] + way * cos, pose[1] + way * sin, pose[2] + turn];
        }
        let mut robot = Robot::named("r1");
        robot.wheels = Some(Stream {
            t_s: wheels.0,
            values: Wheels::Angle {
                right_rad: wheels.1,
                left_rad: wheels.2,
            },
            unknown: Vec::new(),
        });
        robot.pose = Some(Stream {
            t_s: seen.0,
            values: Pose {
                x_m: seen.1,
                y_m: seen.2,
                yaw_rad: Some(seen.3),
            },
            unknown: Vec::new(),
        });
        robot
    }

    fn calibrated(robot: &Robot) -> Option<Calibration> {
        let machine = FromWheels::new(&[robot], &nominal(), &[])?;
        Calibration::new(&machine, &machine.nominal(&nominal()), &[])
    }

    #[test]
    fn a_model_that_is_right_needs_nothing() -> Result<(), &'static str> {
        let found = calibrated(&robot(1.0, [0.0; 2], 0.0)).ok_or("no calibration")?;
        let names: Vec<&str> = found.after.kept.iter().map(|kept| kept.term.name).collect();
        assert!(names.is_empty(), "{names:?}");
        Ok(())
    }

    #[test]
    fn radius_camera_and_latency_are_found_together() -> Result<(), &'static str> {
        let found = calibrated(&robot(0.95, [-0.2, 0.05], 0.08)).ok_or("no calibration")?;
        let mut names: Vec<&str> = found.after.kept.iter().map(|kept| kept.term.name).collect();
        names.sort_unstable();
        assert_eq!(names, [GEOMETRY, OFFSET, OFFSET_TURN, "pose latency"]);
        for (index, truth) in [
            (COMMON, 0.95_f64.ln()),
            (ASYMMETRY, 0.0),
            (TRACK, 0.0),
            (OFFSET_X, -0.2),
            (OFFSET_Y, 0.05),
            (POSE_LATENCY, 0.08),
        ] {
            let error = (found.after.fit.at[index] - truth).abs();
            let deviation = found.after.deviation(&[(index, 1.0)]);
            // the interval has a floor: what nobody would call a difference
            assert!(error < 3.5 * deviation, "{index}: {error} of {deviation}");
            assert!(deviation < 0.012, "{index}: {deviation}");
        }
        Ok(())
    }
}
