//! Thresholds on commands: a recording has finitely many commands, so that a threshold is found by
//! trying those between them.

use rayon::prelude::*;

use super::fit::Fit;
use super::machine::Machine;
use super::screen::{Candidate, beside};
use crate::model::hypothesis::{Hypothesis, all_sizes, threshold};

/// Thresholds that are tried first, and the largest share of all commanded sizes that one swallows.
const TRIED: usize = 80;
const MOST: f64 = 0.95;
/// Of these, those around which others are tried.
const LEADERS: usize = 4;

impl Machine {
    /// All sizes that are commanded in any run, small to large.
    fn sizes(&self) -> Vec<f64> {
        let tracks = self.tracks.iter();
        let mut sizes: Vec<f64> = tracks.flat_map(|t| all_sizes(t, &self.model)).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.dedup();
        sizes
    }

    /// The threshold that gains most beside `fit`, at its gains.
    pub(crate) fn threshold(&self, fit: &Fit, kind: &Hypothesis) -> Option<Candidate> {
        let sizes = self.sizes();
        if sizes.len() < 2 {
            return None;
        }
        let place = |k: usize| {
            let share = (k as f64 + 0.5) / TRIED as f64;
            (MOST * share * sizes.len() as f64) as usize
        };
        let mut places: Vec<usize> = (0..TRIED).map(place).collect();
        places.push(sizes.len());
        places.dedup();
        let name = kind.values[0].0;
        let at = |place: usize| {
            let mut own = kind.clone();
            own.set(name, threshold(&sizes, place));
            own
        };
        let value = |place: usize| {
            let e = self.promising(fit, &beside(fit, &at(place)))?;
            Some(self.deviance(&e))
        };
        let mut ranked: Vec<(f64, usize)> = (0..places.len())
            .into_par_iter()
            .filter_map(|k| Some((value(places[k])?, k)))
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let leaders = ranked.par_iter().take(LEADERS).map(|(own, k)| {
            let before = k.checked_sub(1).map_or(0, |k| places[k]);
            let after = places.get(k + 1).copied().unwrap_or(sizes.len());
            climbed((*own, places[*k]), [before, after], &value)
        });
        let (best, place) = leaders.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Candidate {
            hypothesis: at(place),
            gain: fit.deviance - fit.log_determinant() - best,
            fit: None,
        })
    }

    /// `fit` with its thresholds moved to where they fit best at its gains.
    pub(crate) fn with_thresholds(&self, mut fit: Fit) -> Fit {
        for index in 0..fit.hypotheses.len() {
            if !fit.hypotheses[index].is_threshold() {
                continue;
            }
            let sizes = self.sizes();
            let (name, now) = fit.hypotheses[index].values[0];
            let at = |place: usize| {
                let mut all = fit.hypotheses.clone();
                all[index].set(name, threshold(&sizes, place));
                all
            };
            let value = |place: usize| {
                let e = self.promising(&fit, &at(place))?;
                Some(self.deviance(&e))
            };
            let place = sizes.partition_point(|size| *size < now);
            let width = sizes.len().div_ceil(TRIED).max(2);
            let range = [
                place.saturating_sub(width),
                (place + width).min(sizes.len()),
            ];
            let Some(own) = value(place) else { continue };
            let (_, best) = climbed((own, place), range, &value);
            if best != place
                && let Some(moved) = self.pass(at(best), fit.noise)
                && moved.deviance < fit.deviance
            {
                fit = moved;
            }
        }
        fit
    }
}

/// The best place within `range`, by steps that are halved where none helps.
fn climbed(
    from: (f64, usize),
    [first, last]: [usize; 2],
    value: &(dyn Fn(usize) -> Option<f64> + Sync),
) -> (f64, usize) {
    let (mut best, mut place) = from;
    let mut step = ((last - first) / 4).max(1);
    loop {
        let down = place.saturating_sub(step).max(first);
        let up = (place + step).min(last);
        let next = [down, up]
            .into_iter()
            .filter(|other| *other != place)
            .filter_map(|other| Some((value(other)?, other)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match next {
            Some((own, other)) if own < best => (best, place) = (own, other),
            _ if step == 1 => return (best, place),
            _ => step /= 2,
        }
    }
}
