//! Which effects a recording of a robot whose masses are known needs.

use nalgebra::DMatrix;
use slipstream_sim::effects::find;

use super::outside::Outside;
use super::unknown::Unknown;
use crate::estimate::Likelihood;
use crate::estimate::scoring::{FULL, SearchLimits};
use crate::estimate::term::Term;
use crate::model::hypothesis::{Hypothesis, kinds};
use crate::model::plant::filtered::Filtered;
use crate::model::plant::likelihood::Plant;
use crate::model::plant::located::pushes;
use crate::model::plant::machine::Machine;
use crate::model::plant::table::Table;
use crate::select::chosen::Chosen;
use crate::select::criterion::Criterion;
use crate::select::effort::Effort;
use crate::select::elimination::Elimination;
use crate::select::selected::Selected as Needed;

/// A fit of noise sizes from which others begin: it need not be finished.
const ROUGH: SearchLimits = SearchLimits {
    iterations: 12,
    tolerance_nats: 0.5,
};
/// Change of the logs of all noise sizes from which they are searched a second time.
const LESS: f64 = -2.5;
/// Gusts at most, and the time before and after its largest impulse (s) that belongs to one.
const MOST_DISTURBANCES: usize = 16;
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
    /// The terms that are needed, from which more may be looked for; `None` of a comparison.
    pub(super) needed: Option<Needed>,
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
    /// What was found before single pushes and forces outside of the catalogue were looked for, and whether they are
    /// now.
    pub(crate) begun: Option<Selected>,
    pub(crate) is_whole: bool,
}

impl Selection<'_> {
    /// What is needed.
    pub(crate) fn run(&mut self) -> Option<Selected> {
        let table = Table::new(&self.machine, self.all, self.known);
        let found = self.among(&table)?;
        if !self.is_whole || !self.is_disturbed(&found) {
            return Some(found);
        }
        (self.progress)("looking for single pushes");
        let disturbances = self.disturbances()?;
        if disturbances.len() == MOST_DISTURBANCES {
            // what pushes all the time is no gust
            return Some(found);
        }
        for (run, span_s) in disturbances {
            self.machine.runs[run].disturbances_s.push(span_s);
        }
        self.among(&table)
    }

    /// Whether what was found leaves pushes, each by itself.
    fn is_disturbed(&self, found: &Selected) -> bool {
        let whole = found.whole();
        !self.machine.is_silent(whole)
            && pushes(self.machine.impulses(whole), due_of_push(found.tried)) > 1
    }

    /// Times at which something pushes for a moment, each with its run, one after the other while that gains what is due.
    fn disturbances(&self) -> Option<Vec<(usize, [f64; 2])>> {
        let due = due_of_push(kinds(self.all).len());
        let mut machine = self.machine.clone();
        let table = Table::new(&machine, &[], &[]);
        let mut at = table.start.clone();
        let mut disturbances = Vec::new();
        while disturbances.len() < MOST_DISTURBANCES {
            let plant = Plant::new(&machine, &table);
            at = table.problem(&plant).fit(&at, &table.told, ROUGH).at;
            let found = machine.impulse(plant.filtered(&at)?.as_ref());
            let Some((run, impulse)) = found.filter(|(_, own)| own.gain > due) else {
                break;
            };
            let [before, after] = GUST_S;
            let span_s = [impulse.t_s - before, impulse.t_s + after];
            machine.runs[run].disturbances_s.push(span_s);
            disturbances.push((run, span_s));
        }
        Some(disturbances)
    }

    fn among(&mut self, table: &Table) -> Option<Selected> {
        let begun = self.begun.take();
        let plant = Plant::new(&self.machine, table);
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
            // what the model says of a gain holds; blocks have to agree on one term alone
            agreement: Criterion::of(&plant, table.terms.len()).alone(),
            effort: Effort::NARROW,
            twins: &table.twins,
            useful: &|_, _, _| true,
        };
        let begun = begun.and_then(|own| Some((own.nominal, own.needed?)));
        let (nominal, mut needed) = match begun {
            Some(own) => own,
            None => self.first(&mut selection, table, &plant)?,
        };
        let mut unknown = None;
        let last = plant.filtered(&needed.fit.at)?;
        if self.is_whole && self.machine.before == 0 && !self.machine.is_silent(&last) {
            (self.progress)("looking for forces that no effect explains");
            let outside = Outside {
                selection: &selection,
                plant: &plant,
                terms: &table.terms,
            };
            let mut left: Vec<Term> = needed.kept.iter().map(|own| own.term.clone()).collect();
            let mut fit = needed.fit.clone();
            let count = left.len();
            unknown = outside.found(&mut fit, &mut left);
            if left.len() < count {
                needed = selection.run(fit, &left)?;
            }
        }
        let fit = plant.filtered(&needed.fit.at)?.as_ref().clone();
        let (gains, alike) = weighed(table, &fit, &needed);
        Some(Selected {
            nominal,
            known: Some(known(&plant, &needed)),
            gains,
            alike,
            tried: table.terms.len(),
            unknown,
            fit,
            at: needed.fit.at.clone(),
            needed: Some(needed),
        })
    }

    /// The model as it is, with its noise, and the terms that are needed beside it.
    fn first(
        &self,
        selection: &mut Elimination<'_>,
        table: &Table,
        plant: &Plant<'_>,
    ) -> Option<(Filtered, Needed)> {
        (self.progress)("fitting the model as it is");
        let begun = self.as_it_is(selection, plant);
        let nominal = plant.filtered(&begun.fit.at)?;
        let needed = if self.machine.is_silent(&nominal) {
            selection.run(begun.fit, &[])?
        } else {
            self.needed(selection, table, begun)?
        };
        Some((nominal.as_ref().clone(), needed))
    }

    /// What is needed beside `begun`.
    fn needed(
        &self,
        selection: &mut Elimination<'_>,
        table: &Table,
        begun: Chosen,
    ) -> Option<Needed> {
        let hear = |name: &str| (self.progress)(&format!("found {}", name.replace('_', " ")));
        (self.progress)("trying every effect");
        let chosen = selection.forward(begun, &table.terms, &hear);
        let chosen = selection.exchanged(chosen, &table.terms);
        let mut terms = chosen.terms;
        let mut needed = selection.settled(chosen.fit, &mut terms)?;
        needed.alike = chosen.alike;
        Some(needed)
    }

    /// The fit of what is known and of the noise.
    fn as_it_is(&self, selection: &Elimination<'_>, plant: &Plant<'_>) -> Chosen {
        let (free, _) = selection.free(&[]);
        Chosen {
            fit: selection
                .problem
                .fit(&plant.table.start, &free, selection.effort.full),
            terms: Vec::new(),
            alike: Vec::new(),
        }
    }
}

/// What a push has to gain (−2 ln L), beside so many effects that were tried.
fn due_of_push(tried: usize) -> f64 {
    let numbers = find("push").map_or(1, |info| info.parameters.len());
    2.0 * Criterion { tried, blocks: 2 }.least_gain(numbers)
}

/// Parameters of the model as it is, with its noise.
pub(crate) fn fitted_noise(plant: &Plant<'_>) -> Option<Vec<f64>> {
    let table = plant.table;
    let problem = table.problem(plant);
    let fits = [0.0, LESS].map(|shift| {
        let mut at = table.start.clone();
        for index in &table.sizes {
            at[*index] += shift;
        }
        problem.fit(&at, &table.told, FULL)
    });
    let best = fits
        .into_iter()
        .max_by(|a, b| a.objective.total_cmp(&b.objective))?;
    Some(best.at)
}

/// What each effect of a fit brings (nats), and those that fit as well in its place.
fn weighed(table: &Table, fit: &Filtered, found: &Needed) -> (Vec<f64>, Vec<Vec<&'static str>>) {
    let of = |own: &Hypothesis| {
        let term = table.term_of(own)?;
        let kept = found.kept(term.name)?;
        let alike = found.alike.iter().filter(|[name, _]| *name == term.name);
        let effect = |[_, other]: &[&'static str; 2]| {
            let mut all = table.terms.iter();
            let own = all.find(|term| term.name == *other);
            own.and_then(|term| term.shown.first())
                .map_or(*other, |shown| shown.effect)
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
fn known(plant: &Plant<'_>, found: &Needed) -> Known {
    let fit = &found.fit;
    let weights = plant.table.weights(&fit.at);
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
