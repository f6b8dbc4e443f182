//! From which size on an effect that was not found would have been seen, of a machine that is commanded
//! speeds or nothing: beside the findings, by its deviation, with the error that it would make.

use slipstream_sim::effects::find;

use super::prediction::{Errors, Predictor};
use super::scene::{Scene, some_windows};
use super::search::problem;
use super::sight::{self, SIGMAS};
use crate::answer::{Limit, Seen};
use crate::estimate::scoring::Problem;
use crate::estimate::term::{Attribution, Link, Term};
use crate::model::from_wheels::TURNS_FIRST;
use crate::model::streams::{Joint, ROBUST};
use crate::select::elimination::LEAST_APART;

/// Windows by which the error of a limit is predicted.
const WINDOWS: usize = 12;
/// What the parameters of an effect of both wheels say.
const OF_WHEELS: [&str; 2] = ["both wheels", "right over left"];

/// The limits of all terms that no finding has.
pub(super) fn limits(scene: &Scene<'_>) -> Vec<Limit> {
    let base = Base::new(scene);
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
    let selected = &found.selected;
    // radii and track are one term: what no finding has of it is ruled out as well
    let claimed = |effect: &str| scene.claims.iter().any(|claim| claim.effect == effect);
    let shown: Vec<&Attribution> = term
        .shown
        .iter()
        .filter(|shown| !claimed(shown.effect))
        .collect();
    if shown.is_empty() {
        return Vec::new();
    }
    let deviations: Option<Vec<f64>> = if selected.kept(term.name).is_some() {
        let own = term.parameters.iter();
        Some(own.map(|i| selected.deviation(&[(*i, 1.0)])).collect())
    } else {
        sight::beside(problem, &selected.fit, term).map(|own| {
            let places = 0..term.parameters.len();
            places.map(|i| own.covariance[(i, i)].sqrt()).collect()
        })
    };
    let apart = problem.likelihood.apart(&selected.fit.at).max(LEAST_APART);
    let size = |index: usize| {
        let place = term.parameters.iter().position(|own| *own == index)?;
        let own = deviations.as_ref()?[place] * term.inflation;
        let floor = apart * (term.resolution[place] + term.repeatability[place]);
        let size = SIGMAS * (own * own + floor).sqrt();
        size.is_finite().then_some(size)
    };
    let each = shown.into_iter().flat_map(|shown| {
        shown
            .parameters
            .iter()
            .enumerate()
            .filter_map(move |(number, index)| {
                let moves = &found.table.weights[*index];
                let of_turns = moves.iter().any(|(read, _)| *read >= TURNS_FIRST);
                let own = named((shown, of_turns), number, *index)?;
                Some((shown, *index, own))
            })
    });
    each.map(|(shown, index, (parameter, link))| {
        let change = size(index);
        let error = change.map_or([None, None], |change| base.caused(scene, index, change));
        let is_factor = link == Link::Log;
        let unit = find(shown.effect).and_then(|info| info.parameter(parameter));
        Limit {
            effect: if shown.effect == "unknown" {
                "motion_law"
            } else {
                shown.effect
            },
            word: shown.word.map(|(_, word)| word),
            parameter,
            unit: match (shown.effect, unit) {
                ("unknown", _) if parameter == "turn_rate" => "rad/s",
                ("unknown", _) => "m/s",
                (_, Some(own)) => own.unit,
                (_, None) => "1",
            },
            seen: if is_factor {
                Seen::Around(1.0)
            } else {
                Seen::Above
            },
            size: change.map(|change| if is_factor { change.exp_m1() } else { change }),
            usual: 1.0,
            error,
        }
    })
    .collect()
}

/// What a fitted parameter is called, and how it changes; one of a table stands for all.
fn named(
    (shown, of_turns): (&Attribution, bool),
    number: usize,
    index: usize,
) -> Option<(&'static str, Link)> {
    if shown.effect == "unknown" {
        let acts_on = if of_turns { "turn_rate" } else { "speed" };
        return (number == 0).then_some((acts_on, Link::Identity));
    }
    let mut values = shown.values.iter();
    let own = values.find(|value| value.weights.iter().any(|(own, _)| *own == index))?;
    match own.weights.as_slice() {
        [_] => Some((own.name, own.link)),
        _ => Some((OF_WHEELS.get(number)?, own.link)),
    }
}

/// Some windows of each run as the findings predict them: what a change is compared with.
struct Base {
    runs: Vec<(Vec<[f64; 2]>, Errors)>,
}

impl Base {
    fn new(scene: &Scene<'_>) -> Self {
        let most = WINDOWS.div_ceil(scene.predictors.len());
        let runs = scene.predictors.iter().enumerate().map(|(run, predictor)| {
            let windows = some_windows(predictor, most);
            let errors = predictor.errors(run, scene.with_all, &windows, true);
            (windows, errors)
        });
        Self {
            runs: runs.collect(),
        }
    }

    /// Root mean square by which predictions change with this parameter: place (m) and heading (rad).
    fn caused(&self, scene: &Scene<'_>, index: usize, change: f64) -> [Option<f64>; 2] {
        let Some(own) = scene
            .own
            .found
            .table
            .find(&scene.all.found.table.keys[index])
        else {
            return [None, None];
        };
        let mut at = scene.at.clone();
        at[own] += change;
        let moved = scene.own.machine_at(&at);
        let [mut place, mut turn] = [[0.0_f64; 2]; 2];
        let runs = scene.predictors.iter().zip(&self.runs).enumerate();
        for (run, (predictor, (windows, own))) in runs {
            let other = predictor.errors(run, &moved, windows, true);
            let pairs = own.predicted.iter().zip(&other.predicted);
            for ((ax, ay), (bx, by)) in pairs.filter(|(p, _)| p.0.is_finite()) {
                place = [
                    place[0] + (ax - bx).powi(2) + (ay - by).powi(2),
                    place[1] + 1.0,
                ];
            }
            let ends = turns(predictor, own).into_iter();
            for (a, b) in ends.zip(turns(predictor, &other)) {
                turn = [turn[0] + (a - b).powi(2), turn[1] + 1.0];
            }
        }
        [place, turn].map(|[squares, count]| (count > 0.0).then(|| (squares / count).sqrt()))
    }
}

/// Errors of the heading.
fn turns(predictor: &Predictor<'_>, errors: &Errors) -> Vec<f64> {
    if !predictor.run.has_heading() {
        return Vec::new();
    }
    let own = errors
        .residuals
        .iter()
        .filter(|(_, channel, _)| *channel == 4);
    own.map(|(_, _, residual)| *residual)
        .filter(|residual| residual.is_finite())
        .collect()
}
