//! What changed since runs from before, for a machine whose masses are known.
//!
//! What runs from before need is found first. It acts in all runs, its numbers fitted with whatever
//! changed; a change acts in runs of today alone, and has to explain more than the same effect in all runs.

use super::judged::{Judged, alone, machine_of, whole};
use super::selection::{Known, Selected, Selection, fitted_noise};
use crate::estimate::scoring::FULL;
use crate::model::hypothesis::{self, Hypothesis, in_force, with};
use crate::model::plant::filtered::{Filtered, values};
use crate::model::plant::likelihood::Plant;
use crate::model::plant::machine::Machine;
use crate::model::plant::table::Table;
use crate::predict::predictor::Predictor;
use crate::request::Request;
use crate::select::criterion::Criterion;

/// Effects of one place or time, which runs do not share.
const LOCAL: [&str; 2] = ["push", "friction_patch"];

/// What changed from the first to the second.
pub(super) fn judged(
    request: &Request<'_>,
    [before, today]: [&Predictor; 2],
    progress: &(dyn Fn(&str) + Sync),
) -> Option<Judged> {
    let said = |what: &str| progress(&format!("from before: {what}"));
    let then = whole(alone(request, before, &said)?, &said)?.selected;
    let mut model = before.model.clone();
    if let Some(unknown) = &then.unknown {
        model.effects.extend(unknown.spec.clone());
    }
    let mut known = then.fit.hypotheses;
    known.retain(|own| !own.is_momentary());
    let excluded = [request.excluded, &LOCAL.map(str::to_owned)].concat();
    let tracks = [before.tracks.as_slice(), today.tracks.as_slice()].concat();
    let mut machine = machine_of(&tracks, &model, &excluded);
    machine.before = before.tracks.len();
    let all = changes(&hypothesis::all(&model, &today.tracks, &excluded), &known);
    let mut selection = Selection {
        machine,
        all: &all,
        known: &known,
        progress,
        begun: None,
        is_whole: true,
    };
    let selected = selection.run()?;
    alone_today(&selection.machine, selected, today, &excluded)
}

/// Hypotheses of changes: of what acts already with other numbers, and of everything else.
fn changes(all: &[Hypothesis], known: &[Hypothesis]) -> Vec<Hypothesis> {
    let is_known = |own: &&Hypothesis| known.iter().any(|known| known.is_of(own));
    let fresh = all.iter().filter(|own| !is_known(own));
    let since = |own: &Hypothesis| Hypothesis {
        since: true,
        ..own.clone()
    };
    fresh.chain(known).map(since).collect()
}

/// The same of today's runs alone, whose model has what acted before.
fn alone_today(
    joint: &Machine,
    selected: Selected,
    today: &Predictor,
    excluded: &[String],
) -> Option<Judged> {
    let fit = &selected.fit;
    let shared = in_force(&fit.hypotheses, false);
    let model = with(&joint.model, &shared);
    let machine = machine_of(&today.tracks, &model, excluded);
    let mut changes: Vec<usize> = (0..fit.hypotheses.len()).collect();
    changes.retain(|at| fit.hypotheses[*at].since);
    let listed = |own: &Hypothesis| Hypothesis {
        since: false,
        replaces: match own.counterpart(&fit.hypotheses) {
            None => own.replaces,
            Some(at) => place(&joint.model, &shared, &fit.hypotheses[at]),
        },
        ..own.clone()
    };
    let own = changes.iter().map(|at| &fit.hypotheses[*at]);
    let all: Vec<Hypothesis> = own.map(listed).collect();
    let places: Vec<usize> = changes.iter().flat_map(|at| numbers(fit, *at)).collect();
    let table = Table::new(&machine, &all, &[]);
    let plant = Plant::new(&machine, &table);
    let still = fitted_noise(&plant)?;
    let at = all
        .iter()
        .fold(still.clone(), |at, own| table.with(&at, own));
    let at = table.problem(&plant).fit(&at, &table.told, FULL).at;
    let pick = |at: &usize| (selected.gains[*at], selected.alike[*at].clone());
    let (gains, alike) = changes.iter().map(pick).unzip();
    let known = selected.known.as_ref();
    let nominal = known.map_or_else(Vec::new, |known| intervals(fit, known));
    let selected = Selected {
        nominal: plant.filtered(&still)?.as_ref().clone(),
        fit: plant.filtered(&at)?.as_ref().clone(),
        known: known.map(|known| known.of(&places)),
        at,
        gains,
        alike,
        tried: selected.tried,
        unknown: None,
        needed: None,
    };
    Some(Judged {
        all: hypothesis::all(&model, &today.tracks, excluded),
        nominal,
        selected,
        table,
        machine,
    })
}

/// Where the model with `shared` lists `own`, one of them.
fn place(
    model: &slipstream_bus::RobotModel,
    shared: &[Hypothesis],
    own: &Hypothesis,
) -> Option<usize> {
    if own.replaces.is_some() {
        return own.replaces;
    }
    let added = shared.iter().filter(|h| h.replaces.is_none());
    let order = added.into_iter().position(|h| h.is_of(own))?;
    Some(model.effects.len() + order)
}

/// Places of the fitted numbers of a hypothesis.
fn numbers(fit: &Filtered, at: usize) -> std::ops::Range<usize> {
    let own = &fit.hypotheses[at];
    let first = values(&fit.hypotheses[..at]).len();
    first..first + values(std::slice::from_ref(own)).len()
}

/// 95 % intervals of what acted before.
fn intervals(fit: &Filtered, known: &Known) -> Vec<(&'static str, &'static str, [f64; 2])> {
    let blocks = known.blocks;
    let width = Criterion { tried: 1, blocks }.half_width();
    let shared = fit.hypotheses.iter().enumerate().filter(|(_, h)| !h.since);
    let each = shared.flat_map(|(at, own)| {
        let values = numbers(fit, at).zip(&own.values);
        values.map(|(place, (name, value))| {
            let half = width * known.covariance[(place, place)].sqrt();
            (own.info.id, *name, [value - half, value + half])
        })
    });
    each.filter(|(.., [low, high])| low.is_finite() && high.is_finite())
        .collect()
}
