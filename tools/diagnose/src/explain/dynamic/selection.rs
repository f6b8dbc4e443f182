//! Which effects a recording of a robot whose masses are known needs.

use nalgebra::DMatrix;
use slipstream_sim::effects::find;

use super::unknown::Unknown;
use crate::estimate::Likelihood;
use crate::estimate::scoring::{FULL, Fit, SearchLimits};
use crate::estimate::term::Term;
use crate::model::hypothesis::Hypothesis;
use crate::model::plant::filtered::Filtered;
use crate::model::plant::likelihood::Plant;
use crate::model::plant::machine::Machine;
use crate::model::plant::table::Table;
use crate::select::chosen::Chosen;
use crate::select::criterion::Criterion;
use crate::select::elimination::Elimination;
use crate::select::selected::Selected as Needed;

/// A fit of noise sizes from which others begin: it need not be finished.
const ROUGH: SearchLimits = SearchLimits {
    iterations: 12,
    tolerance_nats: 0.5,
};
/// Shifts of the logs of all noise sizes from which they are searched.
const NOISE_SHIFTS: [f64; 2] = [0.0, -2.5];
/// Gusts at most, and the time before and after its largest impulse (s) that belongs to one.
const GUSTS: usize = 16;
const GUST_S: [f64; 2] = [0.08, 0.15];
/// Effects that act by the speed alone, or by the turn rate: from a force outside of the catalogue that
/// does so they cannot be told.
const OF_SPEED: [&str; 4] = [
    "rolling_resistance",
    "axle_friction",
    "viscous_drag",
    "quadratic_drag",
];
const OF_TURN: [&str; 1] = ["yaw_scrub"];

/// What a recording needs.
pub(crate) struct Selected {
    pub(crate) nominal: Filtered,
    pub(crate) fit: Filtered,
    /// The parameters of `fit`.
    pub(crate) at: Vec<f64>,
    /// How well the numbers of its effects are known.
    pub(crate) known: Option<Known>,
    /// Of each effect: what it brings (nats).
    pub(crate) gains: Vec<f64>,
    /// Of each effect: those that fit as well in its place.
    pub(crate) alike: Vec<Vec<&'static str>>,
    /// How many effects were tried.
    pub(crate) tried: usize,
    /// What the catalogue does not hold.
    pub(crate) unknown: Option<Unknown>,
}

/// Covariances of the numbers of effects, in their order.
#[derive(Clone)]
pub(crate) struct Known {
    /// By how blocks differ, at least the model's.
    pub(crate) covariance: DMatrix<f64>,
    /// By the model.
    pub(crate) model: DMatrix<f64>,
    pub(crate) blocks: usize,
}

impl Known {
    /// What is known of these numbers alone.
    pub(crate) fn of(&self, places: &[usize]) -> Self {
        let own = |all: &DMatrix<f64>| all.select_rows(places).select_columns(places);
        Self {
            covariance: own(&self.covariance),
            model: own(&self.model),
            blocks: self.blocks,
        }
    }
}

impl Selected {
    /// Whether an effect is named: one that cannot be told from a force outside of the catalogue is part
    /// of that force.
    pub(crate) fn names(&self, own: &Hypothesis) -> bool {
        let part = |unknown: &Unknown| match unknown.driver {
            "v" => OF_SPEED.contains(&own.info.id),
            "w" => OF_TURN.contains(&own.info.id),
            _ => false,
        };
        !self.unknown.as_ref().is_some_and(part)
    }

    /// The fit of everything that was found.
    pub(crate) fn whole(&self) -> &Filtered {
        self.unknown.as_ref().map_or(&self.fit, |own| &own.fit)
    }
}

/// A selection on one machine.
pub(crate) struct Selection<'a> {
    pub(crate) machine: Machine,
    pub(crate) all: &'a [Hypothesis],
    /// What acts in runs from before.
    pub(crate) known: &'a [Hypothesis],
    pub(crate) progress: &'a (dyn Fn(&str) + Sync),
}

impl Selection<'_> {
    /// What is needed. What pushes more than once follows something, or is nothing to name.
    pub(crate) fn run(&mut self) -> Option<Selected> {
        let first = self.once()?;
        let Some(due) = self.due_of_push(&first) else {
            return Some(first);
        };
        self.machine.excluded.push("push".to_owned());
        let other = self.once()?;
        if other.whole().deviance < first.fit.deviance {
            return Some(other);
        }
        (self.progress)("looking for single pushes");
        self.mark_gusts(due)?;
        self.once()
    }

    /// What another push would have to gain (−2 ln L), where one is found and another one would gain it.
    fn due_of_push(&self, found: &Selected) -> Option<f64> {
        if !found.fit.hypotheses.iter().any(Hypothesis::is_momentary) {
            return None;
        }
        let numbers = find("push").map_or(1, |info| info.parameters.len());
        let due = 2.0 * criterion(found.tried).least_gain(numbers);
        let (_, impulse) = self.machine.impulse(&found.fit)?;
        (impulse.gain > due).then_some(due)
    }

    /// Marks the times at which something pushes for a moment, one after the other, while that gains `due` (−2 ln L).
    fn mark_gusts(&mut self, due: f64) -> Option<()> {
        let table = Table::new(&self.machine, &[], &[]);
        let mut at = table.start.clone();
        for _ in 0..GUSTS {
            let plant = Plant::new(&self.machine, &table);
            at = table.problem(&plant).fit(&at, &table.told, ROUGH).at;
            let found = self.machine.impulse(plant.filtered(&at)?.as_ref());
            let Some((run, impulse)) = found.filter(|(_, own)| own.gain > due) else {
                break;
            };
            let [before, after] = GUST_S;
            let span_s = [impulse.t_s - before, impulse.t_s + after];
            self.machine.runs[run].gusts_s.push(span_s);
        }
        Some(())
    }

    fn once(&self) -> Option<Selected> {
        let table = Table::new(&self.machine, self.all, self.known);
        let plant = Plant::new(&self.machine, &table);
        let problem = table.problem(&plant);
        let count = table.priors.len();
        let mut selection = Elimination {
            problem: &problem,
            always: table.always.clone(),
            noise: &table.told,
            sizes: &table.sizes,
            weights: &vec![Vec::new(); count],
            parts: &vec![1; count],
            nominal: &table.nominal,
            criterion: Criterion::of(&plant, table.terms.len()),
            twins: &table.twins,
            useful: &|_, _, _| true,
        };
        (self.progress)("fitting the model as it is");
        let begun = begun(&selection, &table);
        let nominal = plant.filtered(&begun.fit.at)?;
        let mut terms = Vec::new();
        let mut found: Option<Needed> = None;
        if !self.machine.is_silent(&nominal) {
            let hear = |name: &str| (self.progress)(&format!("found {}", name.replace('_', " ")));
            (self.progress)("trying every effect");
            let chosen = selection.forward(begun.clone(), &table.terms, &hear);
            let chosen = selection.exchanged(chosen, &table.terms);
            terms = chosen.terms;
            let mut needed = selection.settled(chosen.fit, &mut terms)?;
            needed.alike = chosen.alike;
            found = Some(needed);
        } else if !self.known.is_empty() {
            found = selection.settled(begun.fit.clone(), &mut terms);
        }
        let at = found.as_ref().map_or(&begun.fit.at, |own| &own.fit.at).clone();
        let fit = plant.filtered(&at)?.as_ref().clone();
        let (gains, alike) = weighed(&table, &fit, found.as_ref());
        let known = found.as_ref().map(|own| known(&plant, &own.fit, own));
        Some(Selected {
            nominal: nominal.as_ref().clone(),
            known,
            gains,
            alike,
            tried: table.terms.len(),
            unknown: None,
            fit,
            at,
        })
    }
}

/// The criterion of a test among so many terms.
fn criterion(tried: usize) -> Criterion {
    Criterion { tried, blocks: 2 }
}

/// The fit of what is known and of the noise: the best of several.
fn begun(selection: &Elimination<'_>, table: &Table) -> Chosen {
    let (free, _) = selection.free(&[]);
    let fits = NOISE_SHIFTS.map(|shift| {
        let at = selection.with_noise(&table.start, shift);
        selection.problem.fit(&at, &free, ROUGH)
    });
    let best = fits.into_iter().max_by(|a, b| a.objective.total_cmp(&b.objective));
    let at = best.map_or_else(|| table.start.clone(), |own| own.at);
    Chosen {
        fit: selection.problem.fit(&at, &free, FULL),
        terms: Vec::new(),
        alike: Vec::new(),
    }
}

/// The noise of the model as it is: how well it fits (nats), and its parameters.
pub(crate) fn fitted_noise(plant: &Plant<'_>) -> Option<(f64, Vec<f64>)> {
    let table = plant.table;
    let problem = table.problem(plant);
    let fits = NOISE_SHIFTS.map(|shift| {
        let mut at = table.start.clone();
        for index in &table.sizes {
            at[*index] += shift;
        }
        problem.fit(&at, &table.told, FULL)
    });
    let best = fits.into_iter().max_by(|a, b| a.objective.total_cmp(&b.objective))?;
    Some((best.objective, best.at))
}

/// What each effect of a fit brings (nats), and those that fit as well in its place.
fn weighed(table: &Table, fit: &Filtered, found: Option<&Needed>) -> (Vec<f64>, Vec<Vec<&'static str>>) {
    let of = |own: &Hypothesis| {
        let term = table.term_of(own)?;
        let kept = found?.kept(term.name)?;
        let alike = found?.alike.iter().filter(|[name, _]| *name == term.name);
        let effect = |[_, other]: &[&'static str; 2]| {
            let mut all = table.terms.iter();
            let own = all.find(|term| term.name == *other);
            own.and_then(|term| term.shown.first()).map_or(*other, |shown| shown.effect)
        };
        let mut alike: Vec<&str> = alike.map(effect).collect();
        alike.sort_unstable();
        alike.dedup();
        Some((kept.gain, alike))
    };
    let all = fit.hypotheses.iter();
    all.map(|own| of(own).unwrap_or_default()).unzip()
}

/// How well the numbers of the effects of a fit are known.
fn known(plant: &Plant<'_>, fit: &Fit, found: &Needed) -> Known {
    let weights: Vec<Vec<(usize, f64)>> = plant.table.weights(&fit.at).into_iter().flatten().collect();
    let count = weights.len();
    let precision = &found.precision;
    let raise = |place: usize| {
        let ratio = precision.expected[(place, place)] / precision.covariance[(place, place)];
        ratio.sqrt().max(1.0)
    };
    let of = |matrix: &DMatrix<f64>, raise: &dyn Fn(usize) -> f64| {
        DMatrix::from_fn(count, count, |i, k| {
            let mut sum = 0.0;
            for (a, by) in &weights[i] {
                for (b, with) in &weights[k] {
                    let (Some(p), Some(q)) = (fit.place(*a), fit.place(*b)) else {
                        return f64::INFINITY;
                    };
                    sum += by * with * matrix[(p, q)] * raise(p) * raise(q);
                }
            }
            sum
        })
    };
    Known {
        covariance: of(&precision.covariance, &raise),
        model: of(&precision.expected, &|_| 1.0),
        blocks: plant.blocks(),
    }
}

/// The terms that act at a fit.
pub(crate) fn terms_of<'t>(table: &'t Table, fit: &Filtered) -> Vec<&'t Term> {
    fit.hypotheses.iter().filter_map(|own| table.term_of(own)).collect()
}
