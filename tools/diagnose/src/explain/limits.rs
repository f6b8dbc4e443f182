//! From which size on an effect that was not found would have been seen, of a machine that is commanded
//! speeds or nothing: beside the findings, by its deviation, with the error that it would make.

use slipstream_sim::effects::find;

use super::figures::root_means;
use super::prediction::some_windows;
use super::scene::Scene;
use super::search::problem;
use super::sight::{self, SIGMAS};
use crate::answer::{Limit, Seen};
use crate::estimate::scoring::Problem;
use crate::estimate::term::{Attribution, Link, Term};
use crate::filter::motion_law::table_of;
use crate::judge::POSE;
use crate::model::streams::{Joint, ROBUST};
use crate::model::wheel_parameters::LAW_FIRST;
use crate::predict::drawn::Drawn;
use crate::select::elimination::LEAST_APART;
use crate::select::selected::Selected;

/// Windows by which the error of a limit is predicted.
const WINDOWS: usize = 12;
/// What the parameters of an effect of both wheels say.
const OF_WHEELS: [&str; 2] = ["both wheels", "right over left"];

/// The limits of all terms that no finding has.
pub(super) fn limits(scene: &Scene<'_>) -> Vec<Limit> {
    let most = WINDOWS.div_ceil(scene.predictors.len());
    let base = scene.predictors.iter().enumerate().map(|(run, predictor)| {
        let windows = some_windows(predictor, most);
        let errors = predictor.errors(run, scene.with_all, &windows);
        (windows, errors.drawn)
    });
    let base: Vec<_> = base.collect();
    // beside recordings from before: what a change would have to be
    let asked = scene.all;
    let found = asked.found;
    let joint = Joint::new(asked.streams, &found.nominal, &found.table.weights, ROBUST);
    let problem = problem(&joint, &found.table);
    let judged = found.table.terms.iter().filter(|term| !term.is_profiled());
    let mut limits: Vec<Limit> = judged
        .flat_map(|term| of_term((scene, &base), &problem, term))
        .collect();
    let error = |limit: &Limit| limit.error[0].or(limit.error[1]).unwrap_or(0.0);
    limits.sort_by(|a, b| error(b).total_cmp(&error(a)));
    limits
}

/// The limits of what no finding has of a term.
fn of_term((scene, base): (&Scene<'_>, &Base), problem: &Problem<'_>, term: &Term) -> Vec<Limit> {
    let found = scene.all.found;
    // radii and track are one term: what no finding has of it is ruled out as well
    let claimed = |effect: &str| scene.claims.iter().any(|claim| claim.effect == effect);
    let shown = term.shown.iter().filter(|shown| !claimed(shown.effect));
    let shown: Vec<&Attribution> = shown.collect();
    if shown.is_empty() {
        return Vec::new();
    }
    let sizes = sizes(&found.selected, problem, term);
    let each = shown.into_iter().flat_map(|shown| {
        let numbered = shown.parameters.iter().enumerate();
        numbered.map(move |(number, index)| (shown, number, *index))
    });
    each.filter_map(|(shown, number, index)| {
        let (moved, _) = found.table.weights[index].first()?;
        let named = named((shown, *moved), number, index)?;
        let place = term.parameters.iter().position(|own| *own == index);
        let change = place.and_then(|place| *sizes.get(place)?);
        let error = change.map_or([None, None], |change| caused(scene, base, index, change));
        Some(limit(shown, named, change, error))
    })
    .collect()
}

/// From which change on each parameter of a term would have been found; none where nothing is known of it.
fn sizes(selected: &Selected, problem: &Problem<'_>, term: &Term) -> Vec<Option<f64>> {
    let places = 0..term.parameters.len();
    let deviations: Vec<f64> = if selected.kept(term.name).is_some() {
        let own = term.parameters.iter();
        own.map(|i| selected.deviation(&[(*i, 1.0)])).collect()
    } else {
        let beside = sight::beside(problem, &selected.fit, term);
        let Some(own) = beside else {
            return Vec::new();
        };
        let all = places.clone();
        all.map(|i| own.covariance[(i, i)].sqrt()).collect()
    };
    let apart = problem.likelihood.apart(&selected.fit.at).max(LEAST_APART);
    let size = |place: usize| {
        let own = deviations[place] * term.inflation;
        let floor = apart * (term.resolution[place] + term.repeatability[place]);
        SIGMAS * (own * own + floor).sqrt()
    };
    places
        .map(|place| Some(size(place)).filter(|size| size.is_finite()))
        .collect()
}

/// The limit of a parameter of an effect, by what it would have to change.
fn limit(
    shown: &Attribution,
    (parameter, link): (&'static str, Link),
    change: Option<f64>,
    error: [Option<f64>; 2],
) -> Limit {
    let (effect, unit) = match (shown.effect, parameter) {
        ("unknown", own) if own.starts_with("turn rate") => ("motion_law", "rad/s"),
        ("unknown", _) => ("motion_law", "m/s"),
        (own, _) => {
            let info = find(own).and_then(|info| info.parameter(parameter));
            (own, info.map_or("1", |own| own.unit))
        }
    };
    let (seen, size) = match link {
        Link::Log => (Seen::Around(1.0), change.map(f64::exp_m1)),
        _ => (Seen::Above, change),
    };
    Limit {
        effect,
        word: shown.word.map(|(_, word)| word),
        parameter,
        unit,
        seen,
        size,
        usual: 1.0,
        error,
    }
}

/// What a fitted parameter that moves this one of the filters is called, and how it changes; one of a table stands for
/// all.
fn named(
    (shown, moved): (&Attribution, usize),
    number: usize,
    index: usize,
) -> Option<(&'static str, Link)> {
    if shown.effect == "unknown" {
        let table = table_of(moved.checked_sub(LAW_FIRST)?)?;
        return (number == 0).then_some((table.meaning, Link::Identity));
    }
    let mut values = shown.values.iter();
    let own = values.find(|value| value.weights.iter().any(|(own, _)| *own == index))?;
    match own.weights.as_slice() {
        [_] => Some((own.name, own.link)),
        _ => Some((OF_WHEELS.get(number)?, own.link)),
    }
}

/// Some windows (s) of each run as the findings predict them: what a change is compared with.
type Base = [(Vec<[f64; 2]>, Drawn)];

/// Root mean square by which predictions change with this parameter: place (m) and heading (rad).
fn caused(scene: &Scene<'_>, base: &Base, index: usize, change: f64) -> [Option<f64>; 2] {
    let key = &scene.all.found.table.keys[index];
    let Some(own) = scene.own.found.table.find(key) else {
        return [None, None];
    };
    let mut at = scene.at.clone();
    at[own] += change;
    let moved = scene.own.machine_at(&at);
    let runs = scene.predictors.iter().zip(base).enumerate();
    root_means(runs.flat_map(|(run, (predictor, (windows, own)))| {
        let other = predictor.errors(run, &moved, windows).drawn;
        let places = own.path.iter().zip(&other.path);
        let places = places.flat_map(|(a, b)| {
            let [(ax, ay), (bx, by)] = [a.predicted, b.predicted];
            [(POSE, ax - bx), (POSE + 1, ay - by)]
        });
        let yaws = own.errors[POSE + 2].iter().zip(&other.errors[POSE + 2]);
        let yaws = yaws.map(|((_, a), (_, b))| (POSE + 2, a - b));
        places.chain(yaws).collect::<Vec<_>>()
    }))
}
