//! From which size on an effect that was not found would have been seen.

use rayon::prelude::*;
use slipstream_sim::effects::When;

use crate::answer::{Limit, Seen};
use crate::explain::figures::root_means;
use crate::model::hypothesis::{Hypothesis, is_limit, kinds, sizes_of};
use crate::model::plant::channels::precisions;
use crate::model::plant::filtered::{Filtered, least_change};
use crate::model::plant::machine::Machine;
use crate::predict::predictor::Predictor;

/// Estimate over standard deviation from which on an effect would have been found.
const SIGMAS: f64 = 4.5;
/// Windows by which the error is predicted that a limit causes.
const WINDOWS: usize = 6;
/// Rise of −2 ln L from which on a size that was tried counts as refuted.
const REFUTED: f64 = 24.0;
/// Share of the smallest change that the catalogue expects, over which a derivative is taken.
const STEP: f64 = 0.1;

/// The limits of everything in `all` that `fit` does not hold.
pub(crate) fn limits(
    machine: &Machine,
    predictor: &Predictor,
    fit: &Filtered,
    all: &[Hypothesis],
) -> Vec<Limit> {
    let kinds = kinds(all.iter().filter(|h| !fit.has(h)));
    let windows = predictor.some_windows(WINDOWS);
    let base = predictor.residuals(&windows, &fit.hypotheses);
    let caused = |one: &Hypothesis, limit: &Limit| {
        let Some(moved) = at_limit(machine, one, limit) else {
            return [None, None];
        };
        let with = predictor.residuals(&windows, &fit.beside(&moved));
        let each = windows.iter().zip(base.iter().zip(&with));
        let each = each.filter_map(|(window, (a, b))| Some((window, a.as_ref()?, b.as_ref()?)));
        root_means(each.flat_map(|(window, before, after)| {
            let rows = window.channels.iter().zip(before.iter().zip(after));
            rows.map(|(channel, (before, after))| {
                let channel = usize::from(*channel);
                (channel, (after - before) * predictor.deviation(channel))
            })
        }))
    };
    let each = kinds.par_iter().flat_map_iter(|kind| {
        let own = of_kind(machine, fit, kind).into_iter();
        own.map(|limit| Limit {
            error: caused(kind[0], &limit),
            ..limit
        })
    });
    let mut limits: Vec<Limit> = each.collect();
    let error = |limit: &Limit| limit.error[0].or(limit.error[1]).unwrap_or(-1.0);
    let remote = |limit: &Limit| limit.size.map_or(-1.0, |size| size / limit.usual);
    limits.sort_by(|a, b| {
        let order = error(b).total_cmp(&error(a));
        order.then_with(|| remote(b).total_cmp(&remote(a)))
    });
    limits
}

/// An effect with the size of its limit; `None` without one.
fn at_limit(machine: &Machine, one: &Hypothesis, limit: &Limit) -> Option<Hypothesis> {
    let size = limit.size.filter(|size| size.is_finite())?;
    let value = match limit.seen {
        Seen::Below => size,
        Seen::Above | Seen::Around(_) => one.nothing(&machine.model, limit.parameter) + size,
    };
    Some(with_only(machine, one, limit.parameter, value))
}

/// An effect with one of its sizes; its others do nothing, while places and directions stay where they begin.
fn with_only(machine: &Machine, one: &Hypothesis, name: &str, value: f64) -> Hypothesis {
    let mut own = one.clone();
    if sizes_of(one.info) == one.values.len() {
        for (name, value) in &mut own.values {
            *value = one.nothing(&machine.model, name);
        }
    }
    own.set(name, value);
    own
}

fn of_kind(machine: &Machine, fit: &Filtered, kind: &[&Hypothesis]) -> Vec<Limit> {
    let one = kind[0];
    match one.info.acts {
        When::Sliding | When::Above => vec![by_trial(machine, fit, kind, Seen::Below)],
        When::Below | When::Apart => vec![by_trial(machine, fit, kind, Seen::Above)],
        _ => {
            let parameters = one.values.iter().take(sizes_of(one.info));
            parameters
                .map(|(name, _)| by_deviation(machine, fit, one, name))
                .collect()
        }
    }
}

/// The limit of a parameter by its standard deviation beside the effects of `fit`.
fn by_deviation(machine: &Machine, fit: &Filtered, one: &Hypothesis, name: &'static str) -> Limit {
    let nothing = one.nothing(&machine.model, name);
    let step = STEP * least_change(one.info, name);
    let moved = with_only(machine, one, name, nothing + step);
    let size = machine.innovations(fit, &fit.beside(&moved)).and_then(|e| {
        let precisions = precisions(&fit.whitened, &machine.channels);
        let pairs = e.iter().zip(&fit.whitened).zip(&precisions);
        let square: f64 = pairs
            .map(|((after, before), precision)| (after - before).powi(2) * precision)
            .sum();
        (square > 1e-12).then(|| SIGMAS * step / square.sqrt())
    });
    let seen = if nothing == 0.0 {
        Seen::Above
    } else {
        Seen::Around(nothing)
    };
    limit(one, name, seen, size)
}

/// The limit of what changes nothing until it is large, or small, enough: of the sizes that were tried
/// the one nearest to nothing that the recording refutes.
fn by_trial(machine: &Machine, fit: &Filtered, kind: &[&Hypothesis], seen: Seen) -> Limit {
    let here = machine.deviance(&fit.whitened);
    let name = kind[0].values[0].0;
    let refuted = kind.iter().filter(|one| {
        let e = machine.bounded_innovations(fit, &fit.beside(one));
        e.is_none_or(|e| machine.deviance(&e) > here + REFUTED)
    });
    let sizes = refuted.filter_map(|one| one.value(name));
    let size = if is_limit(kind[0].info) || seen == Seen::Below {
        sizes.max_by(f64::total_cmp)
    } else {
        sizes.min_by(f64::total_cmp)
    };
    limit(kind[0], name, seen, size)
}

fn limit(one: &Hypothesis, name: &'static str, seen: Seen, size: Option<f64>) -> Limit {
    let usual = match seen {
        Seen::Around(nothing) if nothing != 0.0 => 0.05 * nothing.abs(),
        _ => least_change(one.info, name),
    };
    Limit {
        effect: one.info.id,
        word: one.text.map(|(_, word)| word),
        parameter: name,
        unit: one.info.parameter(name).map_or("1", |p| p.unit),
        seen,
        size,
        usual,
        error: [None, None],
    }
}
