//! From which size on an effect that was not found would have been found: what these recordings cannot show.

use slipstream_sim::effects::find;

use super::fitted::Fitted;
use super::search::problem;
use crate::answer::Detectable;
use crate::estimate::cluster::Precision;
use crate::estimate::scoring::Fit;
use crate::estimate::scoring::Problem;
use crate::estimate::term::{Link, Term};
use crate::model::streams::{Joint, ROBUST};
use crate::select::elimination::{KNOWN_SHARE, LEAST_APART};

/// Deviations from which on an effect would have been found.
pub(super) const SIGMAS: f64 = 4.5;

/// What the streams would have shown, but for effects that were found.
pub(super) fn detectable(robot: &str, own: &Fitted<'_>) -> Vec<Detectable> {
    let found = own.found;
    let joint = Joint::new(own.streams, &found.nominal, &found.table.weights, ROBUST);
    let problem = problem(&joint, &found.table);
    let selected = &found.selected;
    let mut all: Vec<Detectable> = Vec::new();
    for term in found.table.terms.iter().filter(|term| !term.is_profiled()) {
        if selected.kept(term.name).is_some() || term.is_nuisance() {
            continue;
        }
        let precision = beside(&problem, &selected.fit, term);
        let precision = precision.filter(|own| is_known(&problem, term, own));
        for shown in term.shown.iter().filter(|shown| shown.run.is_none()) {
            for value in &shown.values {
                let size = precision.as_ref().map(|precision| {
                    let apart = problem.likelihood.apart(&selected.fit.at).max(LEAST_APART);
                    let least = found.criterion.least_gain(term.parameters.len()) + term.cost;
                    size(term, precision, &value.weights, [apart, least])
                });
                let size = size.filter(|own| own.is_finite());
                let unit = find(shown.effect).and_then(|info| info.parameter(value.name));
                all.push(Detectable {
                    robot: robot.to_owned(),
                    effect: shown.effect,
                    parameter: value.name,
                    unit: unit.map_or("1", |own| own.unit),
                    smallest: size.map(|own| match value.link {
                        Link::Identity => own,
                        Link::Log | Link::LogLoss => own.exp_m1(),
                    }),
                });
            }
        }
    }
    all
}

/// What would be known of a term beside what was found; its parameters come first.
pub(super) fn beside(problem: &Problem<'_>, fit: &Fit, term: &Term) -> Option<Precision> {
    let own = term.parameters.iter().copied();
    let others = fit.free.iter().copied();
    let others = others.filter(|i| !term.parameters.contains(i));
    let mut beside = Fit {
        free: own.chain(others).collect(),
        ..fit.clone()
    };
    for index in &term.parameters {
        // at exactly 0 a law or a threshold has no derivative
        beside.at[*index] += f64::MIN_POSITIVE;
    }
    Precision::new(problem, &beside, beside.free.len())
}

/// Whether the data say more of a term than its prior does.
fn is_known(problem: &Problem<'_>, term: &Term, precision: &Precision) -> bool {
    let mut all = term.parameters.iter().enumerate();
    all.all(|(place, index)| {
        let prior = problem.priors[*index].reach();
        precision.covariance[(place, place)] < KNOWN_SHARE * prior * prior
    })
}

/// The size from which on both tests of a term are passed: its deviations, and the gain (nats) that it has to
/// bring. `apart`: share of the variance that two recordings do not have in common.
fn size(term: &Term, known: &Precision, weights: &[(usize, f64)], [apart, least]: [f64; 2]) -> f64 {
    let places: Vec<(usize, f64)> = weights
        .iter()
        .filter_map(|(index, weight)| {
            let place = term.parameters.iter().position(|own| own == index)?;
            Some((place, *weight))
        })
        .collect();
    let variance = |of: &dyn Fn(usize, usize) -> f64| -> f64 {
        let pairs = places
            .iter()
            .flat_map(|a| places.iter().map(move |b| (a, b)));
        pairs.map(|((i, u), (k, w))| u * w * of(*i, *k)).sum()
    };
    let own = variance(&|i, k| known.covariance[(i, k)]) * term.inflation * term.inflation;
    let floors = places.iter();
    let floors =
        floors.map(|(i, w)| w * w * apart * (term.resolution[*i] + term.repeatability[*i]));
    let by_blocks = SIGMAS * (own + floors.sum::<f64>()).sqrt();
    let expected = variance(&|i, k| known.expected[(i, k)]);
    let all: Vec<usize> = (0..term.parameters.len()).collect();
    let by_gain = (2.0 * least * known.overdispersion(&all) * expected).sqrt();
    by_blocks.max(by_gain)
}
