//! From which size on an effect that was not found would have been seen.

use rayon::prelude::*;
use slipstream_sim::effects::{Channel, Info, When};

use crate::answer::{Limit, Seen};
use crate::windows::bench::{Bench, Node};
use crate::windows::hypothesis::{Hypothesis, kinds, least_probe, points_downhill, sizes_of};
use crate::windows::linear;
use crate::windows::misfit::Misfit;
use crate::windows::weigh::Found;

/// Estimate over standard deviation from which on an effect would have been found.
const SIGMAS: f64 = 4.5;
/// Δ(−2 ln L) from which on a size that was tried counts as refuted.
const REFUTED: f64 = 24.0;

/// The limits of everything in `all` that `found` does not hold, the least well known first and what
/// cannot be judged last.
pub(crate) fn limits(bench: &Bench, all: &[Hypothesis], found: &Found) -> Vec<Limit> {
    let held = |h: &Hypothesis| found.node.hypotheses.iter().any(|known| known.is_like(h));
    let kinds = kinds(all.iter().filter(|h| !held(h)));
    let limits = kinds
        .par_iter()
        .flat_map_iter(|kind| of_kind(bench, &found.node, kind));
    let mut limits: Vec<Limit> = limits.collect();
    let rank = |limit: &Limit| limit.size.map_or(-1.0, |size| remoteness(limit, size));
    limits.sort_by(|a, b| rank(b).total_cmp(&rank(a)));
    limits
}

/// How large a limit is beside what is usual.
fn remoteness(limit: &Limit, size: f64) -> f64 {
    let ratio = size / limit.usual;
    if limit.seen == Seen::Below {
        1.0 / ratio
    } else {
        ratio
    }
}

fn of_kind(bench: &Bench, node: &Node, kind: &[&Hypothesis]) -> Vec<Limit> {
    match kind[0].info.acts {
        When::Sliding if kind[0].replaces.is_none() => {
            vec![by_trial(bench, node, kind, Seen::Below)]
        }
        When::Above => vec![by_trial(bench, node, kind, Seen::Below)],
        When::Below => vec![by_trial(bench, node, kind, Seen::Above)],
        // a size whichever way is down
        _ if points_downhill(kind[0].info) => {
            let all = kind.iter().flat_map(|one| by_deviation(bench, node, one));
            let worst = all.reduce(|a, b| {
                if b.size.is_none_or(|b| Some(b) > a.size) {
                    b
                } else {
                    a
                }
            });
            worst.into_iter().collect()
        }
        _ => by_deviation(bench, node, kind[0]),
    }
}

/// Limits from the standard deviation that each parameter has beside the effects of `node`.
fn by_deviation(bench: &Bench, node: &Node, one: &Hypothesis) -> Vec<Limit> {
    let deviations = deviations(bench, node, one).unwrap_or_default();
    let sigmas = SIGMAS * grain(bench, one.info);
    let parameters = one.values.iter().enumerate().take(sizes_of(one.info));
    let limits = parameters.map(|(i, (name, _))| {
        let nothing = one.nothing(&bench.model, name);
        let deviation = deviations.get(i).copied().filter(|d| d.is_finite());
        let seen = if nothing == 0.0 {
            Seen::Above
        } else {
            Seen::Around(nothing)
        };
        limit(
            one,
            name,
            seen,
            deviation.map(|deviation| sigmas * deviation),
        )
    });
    limits.collect()
}

fn limit(one: &Hypothesis, name: &'static str, seen: Seen, size: Option<f64>) -> Limit {
    let own = one.info.parameter(name);
    let usual = usual(one.info, name);
    Limit {
        effect: one.info.id,
        word: one.text.map(|(_, word)| word),
        parameter: name,
        unit: own.map_or("1", |p| p.unit),
        seen,
        size,
        usual: match seen {
            Seen::Around(nothing) if nothing != 0.0 => 0.05 * nothing.abs(),
            _ => usual,
        },
    }
}

/// The smallest size at which the catalogue expects an effect, or 1 where it says none.
fn usual(info: &Info, name: &str) -> f64 {
    least_probe(info, name).unwrap_or(1.0)
}

/// The standard deviation of each parameter of `one` beside the effects of `node`, to first order.
fn deviations(bench: &Bench, node: &Node, one: &Hypothesis) -> Option<Vec<f64>> {
    let mut hypotheses = node.hypotheses.clone();
    hypotheses.push(one.clone());
    bench.posed(&hypotheses, &bench.windows, |problem, values| {
        let (known, starts) = (node.fit.values.len(), &node.fit.starts);
        let base = problem.residuals(values, starts)?;
        let mut steps = problem.first_steps(values);
        let columns = problem.columns(values, starts, &base, &mut steps, known)?;
        let weights = node.fit.misfit.weights();
        let windows = bench.windows.iter().zip(&node.fit.linear).enumerate();
        let normals: Vec<_> = windows
            .map(|(w, (window, linear))| {
                let more: Vec<&[f64]> = columns.iter().map(|column| column[w].as_slice()).collect();
                linear.normal(window, &weights, &linear.residuals, &more)
            })
            .collect();
        let covariance = linear::covariance(&normals);
        let own = known..values.len();
        Some(own.map(|i| covariance[(i, i)].max(0.0).sqrt()).collect())
    })
}

/// The limit of an effect that changes nothing until it is large enough: of the sizes that were
/// tried, the one nearest to nothing that the recording refutes.
fn by_trial(bench: &Bench, node: &Node, kind: &[&Hypothesis], seen: Seen) -> Limit {
    let refuted = kind.par_iter().filter(|one| is_refuted(bench, node, one));
    let own = |one: &&&Hypothesis| one.values.last().map(|(_, value)| *value);
    let sizes = refuted.filter_map(|one| own(&one));
    let size = if seen == Seen::Below {
        sizes.reduce_with(f64::max)
    } else {
        sizes.reduce_with(f64::min)
    };
    let name = kind[0].values.last().map_or("", |(name, _)| *name);
    limit(kind[0], name, seen, size)
}

fn is_refuted(bench: &Bench, node: &Node, one: &Hypothesis) -> bool {
    let mut hypotheses = node.hypotheses.clone();
    hypotheses.push(one.clone());
    let deviance = bench.posed(&hypotheses, &bench.windows, |problem, values| {
        let residuals = problem.residuals(values, &node.fit.starts)?;
        Some(Misfit::new(&bench.windows, &residuals).deviance())
    });
    let refuted = REFUTED * grain(bench, one.info).powi(2);
    deviance.is_some_and(|deviance| deviance > node.fit.misfit.deviance() + refuted)
}

/// How many times more an effect has to show: what shows in the encoders, by whole counts.
fn grain(bench: &Bench, info: &Info) -> f64 {
    let apart = |channel: &Channel| matches!(channel, Channel::SensorPose | Channel::SensorImu);
    match info.channels.iter().all(apart) {
        true => 1.0,
        false => bench.count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_sim::effects::CATALOGUE;

    /// A push and a patch that a model lists are judged by each of their numbers.
    #[test]
    fn only_where_a_mass_lies_and_which_way_is_down_are_no_sizes() {
        for info in CATALOGUE {
            let first_alone = ["payload", "floor_slope"].contains(&info.id);
            let expected = if first_alone {
                1
            } else {
                info.parameters.len()
            };
            assert_eq!(sizes_of(info), expected, "{}", info.id);
            assert_eq!(points_downhill(info), info.id == "floor_slope");
        }
    }

    #[test]
    fn every_number_has_a_usual_size() {
        for info in CATALOGUE {
            for parameter in info.parameters {
                let usual = usual(info, parameter.name);
                assert!(
                    usual.is_finite() && usual > 0.0,
                    "{} {}",
                    info.id,
                    parameter.name
                );
            }
        }
    }
}
