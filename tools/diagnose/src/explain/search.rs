//! The search for the terms that the streams of one machine need.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::open_loop::drive_error;
use super::prediction::reference_error;
use super::thinning::is_white;
use crate::estimate::Likelihood;
use crate::estimate::cluster::Precision;
use crate::estimate::scoring::{FULL, Fit, Problem, SearchLimits};
use crate::estimate::term::Term;
use crate::model::from_wheels::{FromWheels, Reference};
use crate::model::streams::{Joint, ROBUST, Streams, read};
use crate::model::table::{Asked, Key, Table};
use crate::model::view::View;
use crate::select::chosen::Chosen;
use crate::select::criterion::Criterion;
use crate::select::effort::Effort;
use crate::select::elimination::Elimination;
use crate::select::selected::Selected;

/// A fit of noise sizes from which others begin: it need not be finished.
const ROUGH: SearchLimits = SearchLimits {
    iterations: 25,
    tolerance_nats: 0.5,
};
/// Shifts of the logs of all noise sizes from which they are searched.
const NOISE_SHIFTS: [f64; 3] = [0.0, 1.0, -1.5];
/// What lasts has to lower the error of predictions by this share.
const USE_SHARE: f64 = 0.02;
/// Runs differ when the probability of their spread without a difference is below this.
const RUNS_DIFFER: f64 = 1e-3;
/// Share of what they would have to gain that a score test has to promise before runs are fitted apart.
const MAY_DIFFER: f64 = 0.5;
/// Differences of scale, of track and of latency (s) between runs that nobody would call one.
const RUN_FLOORS: [f64; 3] = [0.01, 0.02, 0.01];
/// Runs whose scale, track or latency is not known to this do not tell whether runs differ.
const RUN_KNOWN: f64 = 0.15;
/// What may differ from run to run.
const OF_RUNS: [&str; 3] = ["run scale", "run track", "run pose late"];
/// Grid of the clocks of single runs: steps to each side, latency (s) and rate of a step.
const RUN_STEPS: i32 = 8;
const RUN_LATE_S: f64 = 0.06;
const RUN_RATE_STEP: f64 = 1e-3;

/// What the streams of a machine need.
pub(crate) struct Searched {
    pub(crate) table: Table,
    /// What the filters read under the nominal model.
    pub(crate) nominal: Vec<f64>,
    pub(crate) selected: Selected,
    pub(crate) criterion: Criterion,
    /// Whether scale, track and latency of the poses are those of each run.
    pub(crate) by_run: [bool; 3],
    /// Nothing is known of it: the data do not determine a fit.
    pub(crate) is_undetermined: bool,
    /// The machine with poses at full rate, where their errors are independent and all are evidence.
    pub(crate) dense: Option<FromWheels>,
}

/// What is asked of a search.
pub(crate) struct Search<'a> {
    pub(crate) streams: Streams<'a>,
    pub(crate) nominal: &'a [f64],
    pub(crate) excluded: &'a [String],
    pub(crate) hear: &'a dyn Fn(&str),
}

impl Search<'_> {
    /// What is needed.
    pub(crate) fn run(&self) -> Searched {
        self.needed().unwrap_or_else(|| self.undetermined())
    }

    /// First what the catalogue has, then scale and track of single runs, then laws outside of the catalogue, and
    /// at last the rows at full rate.
    fn needed(&self) -> Option<Searched> {
        let table = self.table([false; 3]);
        let first = self.chosen(&table);
        let (table, chosen, by_run) = self.of_runs(table, first)?;
        let all = self.with_laws(&table, chosen);
        let selected = self.selected(&table, all)?;
        let (selected, dense) = self.at_full_rate(&table, selected)?;
        Some(Searched {
            criterion: self.criterion(&table),
            nominal: self.nominal.to_vec(),
            table,
            selected,
            by_run,
            is_undetermined: false,
            dense,
        })
    }

    /// What was selected, refined with poses at full rate where their errors are independent; and the machine with
    /// these.
    fn at_full_rate(
        &self,
        table: &Table,
        selected: Selected,
    ) -> Option<(Selected, Option<FromWheels>)> {
        let Some(dense) = self.streams.reference.dense() else {
            return Some((selected, None));
        };
        let own = self.over(&dense);
        let noise = own.fit(table, &selected.fit.at, &table.noise);
        let at = read(self.nominal, &table.weights, &noise.at);
        if !is_white(&dense, &at, Reference::Pose) {
            return Some((selected, None));
        }
        let fit = own.fit(table, &noise.at, &selected.fit.free);
        let chosen = Chosen {
            fit,
            terms: selected.kept.into_iter().map(|kept| kept.term).collect(),
            alike: selected.alike,
        };
        let refined = own.selected(table, chosen)?;
        Some((refined, Some(dense)))
    }

    /// The same search over another reading of the references.
    fn over<'b>(&'b self, reference: &'b FromWheels) -> Search<'b> {
        Search {
            streams: Streams {
                reference,
                drive: self.streams.drive,
            },
            nominal: self.nominal,
            excluded: self.excluded,
            hear: self.hear,
        }
    }

    /// The nominal model, where the data do not determine any other.
    fn undetermined(&self) -> Searched {
        let table = self.table([false; 3]);
        Searched {
            criterion: self.criterion(&table),
            nominal: self.nominal.to_vec(),
            selected: Selected::nothing(table.parameters()),
            table,
            by_run: [false; 3],
            is_undetermined: true,
            dense: None,
        }
    }

    fn table(&self, by_run: [bool; 3]) -> Table {
        Table::new(&Asked {
            streams: self.streams,
            nominal: self.nominal,
            excluded: self.excluded,
            by_run,
        })
    }

    fn criterion(&self, table: &Table) -> Criterion {
        self.selecting(table, ROBUST, |own| own.criterion)
    }

    /// What `of` says of a selection among the terms of a table; `robust` as of [`Joint::new`].
    fn selecting<T>(
        &self,
        table: &Table,
        robust: [bool; 2],
        of: impl FnOnce(&mut Elimination<'_>) -> T,
    ) -> T {
        let joint = Joint::new(self.streams, self.nominal, &table.weights, robust);
        let read_by = (self.streams, self.nominal);
        let useful = |term: &Term, with: &Fit, without: &Fit| {
            is_useful(read_by, table, term, [with, without])
        };
        of(&mut Elimination {
            problem: &problem(&joint, table),
            always: table.always.clone(),
            noise: &table.noise,
            sizes: &table.noise,
            weights: &table.weights,
            parts: &table.parts,
            nominal: &self.nominal_values(table),
            criterion: Criterion::of(&joint, table.terms.len()),
            agreement: Criterion::of(&joint, table.terms.len()),
            effort: Effort::WIDE,
            twins: &table.twins,
            useful: &useful,
        })
    }

    /// The fit of some parameters from `at`.
    fn fit(&self, table: &Table, at: &[f64], free: &[usize]) -> Fit {
        self.selecting(table, ROBUST, |own| own.problem.fit(at, free, FULL))
    }

    /// The table and what was chosen, with scale, track and latency of the poses of each run where runs differ in them.
    fn of_runs(&self, table: Table, chosen: Chosen) -> Option<(Table, Chosen, [bool; 3])> {
        let reference = self.streams.reference;
        let today = reference.runs.len() - reference.before.runs;
        let [scale, track] = reference.before.spread.map(|spread| spread.is_some());
        let mut by_run = [scale, track, false];
        let may = [true, true, reference.has_pose() && !self.streams.compares()];
        if today > 1 && (reference.has_pose() || reference.has_gyro()) {
            let apart = self.table(may);
            let at = self.apart_at(&table, &chosen, &apart);
            if reference.skids || self.may_differ(&apart, &chosen, &at) {
                let own = self.apart(&apart, &chosen, at);
                let differ = self.differ(&apart, &own)?;
                by_run = [0, 1, 2].map(|i| by_run[i] || differ[i]);
                if by_run == may {
                    return Some((apart, own, by_run));
                }
            }
        }
        if by_run == [false; 3] {
            return Some((table, chosen, by_run));
        }
        let apart = self.table(by_run);
        let at = self.apart_at(&table, &chosen, &apart);
        let own = self.apart(&apart, &chosen, at);
        Some((apart, own, by_run))
    }

    /// Whether runs may differ, by a score test (Rao 1948) at the noise that was fitted and at less.
    fn may_differ(&self, apart: &Table, chosen: &Chosen, at: &[f64]) -> bool {
        let terms = terms_apart(apart, chosen);
        let own = apart.keys.iter().enumerate();
        let own = own.filter(|(_, key)| OF_RUNS.contains(&key.name));
        let own: Vec<usize> = own.map(|(index, _)| index).collect();
        let chance = ChiSquared::new(own.len().max(1) as f64);
        let chance = chance.map_or(0.0, |own| own.inverse_cdf(1.0 - RUNS_DIFFER));
        let promise = self.selecting(apart, ROBUST, |selection| {
            selection.promise(at, &selection.free(&terms).0, &own)
        });
        promise > 0.5 * MAY_DIFFER * chance
    }

    /// What was found, as parameters of a table in which scale and track are those of each run.
    fn apart_at(&self, table: &Table, chosen: &Chosen, apart: &Table) -> Vec<f64> {
        let value = |key: &Key| table.find(key).map_or(0.0, |known| chosen.fit.at[known]);
        let shared = |name| value(&Key::of(name, None));
        let keys = apart.keys.iter();
        let at = keys.map(|key| match key.name {
            "run scale" => shared("radius"),
            "run track" => shared("track"),
            // without wheels, a delay of the commands is that of the poses
            "run pose late" if apart.find(&Key::of("delay", None)).is_none() => {
                shared("late pose") + shared("delay")
            }
            "run pose late" => shared("late pose"),
            _ => value(key),
        });
        at.collect()
    }

    /// A fit from `at` with what was found, and scale and track of each run in the place of those of the machine.
    fn apart(&self, apart: &Table, chosen: &Chosen, at: Vec<f64>) -> Chosen {
        let at = self.with_clocks_of_runs(apart, at);
        let at = self.with_latencies_of_runs(apart, at);
        let terms = terms_apart(apart, chosen);
        // where runs differ much, what they share makes all rows of some of them outliers
        let (free, other) = self.selecting(apart, [false; 2], |plain| {
            let (free, _) = plain.free(&terms);
            let fit = plain.problem.fit(&at, &free, ROUGH);
            (free, fit)
        });
        let [own, other] = [&at, &other.at].map(|start| self.fit(apart, start, &free));
        Chosen {
            fit: if other.objective > own.objective {
                other
            } else {
                own
            },
            terms,
            alike: chosen.alike.clone(),
        }
    }

    /// What the nominal model lacks of the catalogue.
    fn chosen(&self, table: &Table) -> Chosen {
        let catalogue = &table.terms[..first_law(table)];
        // physics before tails: whether a row of the wheels is an outlier is asked of a drive that fits
        let begun = self.selecting(table, [true, false], |early| {
            early.forward_from_both(self.begun(early, table), catalogue, self.hear)
        });
        self.selecting(table, ROBUST, |selection| {
            let begun = Chosen {
                fit: selection.fit(&begun.fit.at, &begun.terms, &table.terms),
                ..begun
            };
            let chosen = selection.forward(begun, catalogue, self.hear);
            selection.exchanged(chosen, catalogue)
        })
    }

    /// What was chosen, with laws that the catalogue does not have where one is lacking.
    fn with_laws(&self, table: &Table, chosen: Chosen) -> Chosen {
        let count = chosen.terms.len();
        self.selecting(table, ROBUST, |selection| {
            let with = selection.forward(chosen, &table.terms[first_law(table)..], self.hear);
            if with.terms.len() == count {
                return with;
            }
            let with = selection.forward(with, &table.terms, self.hear);
            selection.exchanged(with, &table.terms)
        })
    }

    /// What is needed of what was chosen.
    fn selected(&self, table: &Table, chosen: Chosen) -> Option<Selected> {
        let mut terms = chosen.terms;
        self.selecting(table, ROBUST, |selection| {
            let mut found = selection.settled(chosen.fit, &mut terms)?;
            found.alike = chosen.alike;
            if self.streams.is_paired() {
                return Some(found);
            }
            let blocks = selection.problem.likelihood.blocks();
            Some(selection.halved(found, &self.halves(blocks)))
        })
    }

    /// A fit without any term: the best of several.
    fn begun(&self, early: &Elimination<'_>, table: &Table) -> Chosen {
        let (free, _) = early.free(&[]);
        let start = vec![0.0; table.parameters()];
        let start = self.with_clocks_of_runs(table, start);
        let fits = NOISE_SHIFTS.map(|shift| {
            let at = early.with_noise(&start, shift);
            early.problem.fit(&at, &free, ROUGH)
        });
        let best = fits
            .into_iter()
            .max_by(|a, b| a.objective.total_cmp(&b.objective));
        let best = best.map_or(start, |own| own.at);
        Chosen {
            fit: early.problem.fit(&best, &free, FULL),
            terms: Vec::new(),
            alike: Vec::new(),
        }
    }

    /// The gyro's clock of each run from the best point of a grid.
    fn with_clocks_of_runs(&self, table: &Table, mut at: Vec<f64>) -> Vec<f64> {
        for run in 0..self.streams.reference.runs.len() {
            let of = |name| self.of_run(table, name, run);
            let (Some(late), Some(rate)) = (of("run late"), of("run rate")) else {
                continue;
            };
            let grid = (-RUN_STEPS..=RUN_STEPS)
                .flat_map(|i| (-RUN_STEPS..=RUN_STEPS).map(move |k| [i, k]));
            let moved = |[i, k]: [i32; 2]| {
                let mut at = at.clone();
                at[late] = f64::from(i) * RUN_LATE_S;
                at[rate] = f64::from(k) * RUN_RATE_STEP;
                at
            };
            let best = self.best(table, (Reference::Gyro, run), grid.map(moved));
            at = best.unwrap_or(at);
        }
        at
    }

    /// The latency of the poses of each run from the best point of a grid around its own.
    fn with_latencies_of_runs(&self, table: &Table, mut at: Vec<f64>) -> Vec<f64> {
        for run in 0..self.streams.reference.runs.len() {
            let Some(late) = self.of_run(table, "run pose late", run) else {
                continue;
            };
            let moved = |step: i32| {
                let mut at = at.clone();
                at[late] += f64::from(step) * RUN_LATE_S;
                at
            };
            let all = (-RUN_STEPS..=RUN_STEPS).map(moved);
            at = self.best(table, (Reference::Pose, run), all).unwrap_or(at);
        }
        at
    }

    /// Place of a parameter of one run.
    fn of_run(&self, table: &Table, name: &'static str, run: usize) -> Option<usize> {
        let machine = self.streams.reference;
        let robot = machine.runs[run].robot as i64 - machine.before.robots as i64;
        table.find(&Key::of(name, Some(robot)))
    }

    /// The parameters by which a reference of a run is likeliest.
    fn best(
        &self,
        table: &Table,
        (reference, run): (Reference, usize),
        all: impl Iterator<Item = Vec<f64>>,
    ) -> Option<Vec<f64>> {
        let view = View {
            machine: self.streams.reference,
            robust: true,
        };
        let valued = all.map(|at| {
            let read = read(self.nominal, &table.weights, &at);
            (view.value_of(reference, run, &read), at)
        });
        let best = valued.max_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, at)| at)
    }

    /// What the model has of each parameter already.
    fn nominal_values(&self, table: &Table) -> Vec<f64> {
        let of = |parameter: usize| {
            let first = table.weights[parameter].first();
            first.map_or(0.0, |(index, _)| self.nominal[*index])
        };
        let all = 0..table.parameters();
        all.map(|own| of(own) + table.twins[own].map_or(0.0, of))
            .collect()
    }

    /// The halves of today's blocks, as those that each leaves out.
    fn halves(&self, blocks: usize) -> [Vec<bool>; 2] {
        let mut left_out = [vec![false; blocks], vec![false; blocks]];
        for [first, end] in self.streams.blocks_of_today() {
            let middle = first + (end - first) / 2;
            left_out[0][middle..end].fill(true);
            left_out[1][first..middle].fill(true);
        }
        left_out
    }

    /// Whether scale, track and latency of the runs differ (Cochran's Q).
    fn differ(&self, apart: &Table, chosen: &Chosen) -> Option<[bool; 3]> {
        let fit = &chosen.fit;
        let precision = self.selecting(apart, ROBUST, |own| {
            let (_, physics) = own.free(&chosen.terms);
            Precision::new(own.problem, fit, physics)
        })?;
        Some([0, 1, 2].map(|kind| {
            let (name, floor) = (OF_RUNS[kind], RUN_FLOORS[kind]);
            let own = apart.keys.iter().enumerate();
            let own = own.filter(|(_, key)| key.name == name && key.robot.is_some_and(|r| r >= 0));
            let values = own.filter_map(|(index, _)| {
                let place = fit.place(index)?;
                let variance = precision.covariance[(place, place)] + floor * floor;
                (variance.sqrt() < RUN_KNOWN).then_some([fit.at[index], variance])
            });
            let is_floor = name == "run track" && self.streams.reference.skids;
            differs(&values.collect::<Vec<_>>()) || is_floor
        }))
    }
}

/// Whether predictions of what a term acts on are better with it.
fn is_useful(
    (streams, nominal): (Streams<'_>, &[f64]),
    table: &Table,
    term: &Term,
    fits: [&Fit; 2],
) -> bool {
    let [with, without] = fits.map(|fit| read(nominal, &table.weights, &fit.at));
    let middle = streams.drive_first();
    let better = |error: &dyn Fn(&[f64]) -> f64| error(&with) < (1.0 - USE_SHARE) * error(&without);
    let on_reference = term.acts.on_reference || streams.drive.is_none();
    let drive = streams.drive.filter(|_| term.acts.on_drive);
    on_reference && better(&|at| reference_error(streams.reference, &at[..middle]))
        || drive.is_some_and(|drive| better(&|at| drive_error(drive, &at[middle..])))
}

/// Whether values with these variances differ beyond chance (Cochran 1954).
fn differs(values: &[[f64; 2]]) -> bool {
    if values.len() < 2 {
        return false;
    }
    let weights: f64 = values.iter().map(|[_, v]| 1.0 / v).sum();
    let mean = values.iter().map(|[x, v]| x / v).sum::<f64>() / weights;
    let q: f64 = values
        .iter()
        .map(|[x, v]| (x - mean) * (x - mean) / v)
        .sum();
    let chance = ChiSquared::new(values.len() as f64 - 1.0);
    chance.map_or(1.0, |chi2| chi2.sf(q)) < RUNS_DIFFER
}

/// The place of the first law among the terms of a table: they come after everything that the catalogue has.
fn first_law(table: &Table) -> usize {
    let mut terms = table.terms.iter();
    let first = terms.position(|term| term.name.starts_with("law"));
    first.unwrap_or(table.terms.len())
}

/// The terms of a table in which scale, track or latency are those of each run, of those that were chosen.
fn terms_apart(apart: &Table, chosen: &Chosen) -> Vec<Term> {
    let of_runs = [
        "scale of runs",
        "track of runs",
        "latency of runs",
        "geometry",
    ];
    let kept = |term: &&Term| of_runs.contains(&term.name) || chosen.has(term.name);
    apart.terms.iter().filter(kept).cloned().collect()
}

/// The problem of fitting a likelihood with the priors of a table.
pub(crate) fn problem<'a>(likelihood: &'a dyn Likelihood, table: &Table) -> Problem<'a> {
    Problem {
        likelihood,
        priors: table.priors.clone(),
        longest: table.longest.clone(),
        sizes: Vec::new(),
    }
}
