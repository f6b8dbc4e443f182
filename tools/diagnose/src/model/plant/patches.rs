//! Patches of the floor: each place where something pushes is tried, and the best patches are moved and resized.

use std::collections::BTreeMap;

use rayon::prelude::*;
use slipstream_sim::effects::find;

use super::filtered::Filtered;
use super::likelihood::Plant;
use super::machine::Machine;
use crate::estimate::scoring::SearchLimits;
use crate::model::hypothesis::Hypothesis;

/// Lengths by which a patch is looked for are in half tracks. Cells of the floor in which one is tried,
/// and how many of them at most.
const CELL: f64 = 0.8;
const CELLS: usize = 8;
/// Least distance between two of them.
const APART: f64 = 1.5;
/// Places that are less apart from the most conspicuous one may belong to one patch.
const NEAR: f64 = 6.0;
/// Gain (−2 ln L) of an impulse where nothing pushes: that of its two numbers.
const NO_PUSH: f64 = 2.0;
/// Ways from the middle of a cell, radii and frictions that are tried in each.
const WAYS: [f64; 3] = [-0.9, 0.0, 0.9];
const RADII: [f64; 4] = [0.6, 1.0, 1.7, 2.8];
const FRICTIONS: [f64; 2] = [0.05, 0.1];
/// Patches that are looked at with gains of their own.
const PATCHES: usize = 2;

/// Gain (−2 ln L) at the gains of the rolling model below which a place is not looked at again.
const PLACE_GAIN: f64 = 6.0;

/// Trials of a random search, and how its steps grow with success and shrink without: one in five
/// succeeds where they stay as they are (evolution strategy; Rechenberg 1973).
const TRIALS: u32 = 60;
const WIDER: f64 = 1.5;
const NARROWER: f64 = 0.9;
/// Share of what small noise on the wheels costs that a place has to bring back.
const SHARE: f64 = 0.2;
/// Rounds of the search, and the gain (nats) of one below which the next is narrower.
const ROUNDS: u64 = 16;
const ROUND_GAIN: f64 = 10.0;
/// Rounds without such a gain after which a search ends.
const IDLE: u32 = 3;
/// Standard deviations of the first trials, from afar and from close by: x, y, radius, and one over the friction.
const WIDE: [f64; 4] = [1.2, 1.2, 0.8, 3.0];
const NARROW: [f64; 4] = [0.4, 0.4, 0.3, 1.2];
/// Bounds of the radius and of one over the friction.
const RADIUS: [f64; 2] = [0.3, 10.0];
const LEAST_INVERSE: f64 = 2.0;

/// A fit of the noise around a patch, which then moves again.
const SETTLING: SearchLimits = SearchLimits {
    iterations: 3,
    tolerance_nats: 1.0,
};

impl Plant<'_> {
    /// Where fits of a patch begin beside `at`.
    pub(super) fn patches(&self, at: &[f64]) -> Option<Vec<Vec<f64>>> {
        let fit = self.filtered(at)?;
        let small = self.table.with_small_noise(at);
        let base = self.with_noise_of_wheels(&fit, &small)?;
        let places = self.machine.conspicuous_places(&fit, &base)?;
        // at small noise what slides is told from what pushes; where only noise is left, at its own
        let least = PLACE_GAIN.max(SHARE * (base.deviance - fit.deviance));
        let mut moved = self.machine.patches(&base, &places, least);
        moved.extend(self.machine.patches(&fit, &places, PLACE_GAIN));
        let settled = moved
            .par_iter()
            .map(|own| self.settled(self.table.with(&small, own), WIDE));
        let mut settled: Vec<(f64, Vec<f64>)> = settled.collect();
        settled.sort_by(|a, b| b.0.total_cmp(&a.0));
        settled.truncate(1);
        Some(settled.into_iter().map(|(_, at)| at).collect())
    }

    /// The patch of `at` moved and resized where that gains: its edge has no usable derivative.
    pub(super) fn refined_patch(&self, at: &[f64]) -> Vec<f64> {
        self.settled(at.to_vec(), NARROW).1
    }

    /// A patch moved while that gains: the noise falls as it comes near, and the search sharpens. Its
    /// log-likelihood with the priors of noise (nats), and where it is.
    fn settled(&self, begun: Vec<f64>, mut spread: [f64; 4]) -> (f64, Vec<f64>) {
        let problem = self.table.problem(self);
        let with_noise = |at: &[f64]| {
            let fit = problem.fit(at, &self.table.told, SETTLING);
            (fit.objective, fit.at)
        };
        let mut best = with_noise(&begun);
        let mut idle = 0;
        for round in 1..=ROUNDS {
            let before = best.0;
            let Some(moved) = self.moved(&best.1, &spread, round) else {
                break;
            };
            let next = with_noise(&moved);
            if next.0 > best.0 {
                best = next;
            }
            if best.0 - before < ROUND_GAIN {
                spread = spread.map(|own| own * 0.5);
                idle += 1;
            } else {
                idle = 0;
            }
            if idle == IDLE {
                break;
            }
        }
        best
    }

    /// The patch of `at` moved and resized at its gains.
    fn moved(&self, at: &[f64], spread: &[f64; 4], seed: u64) -> Option<Vec<f64>> {
        let fit = self.filtered(at)?;
        let own = fit.hypotheses.iter().position(|own| own.is_placed())?;
        let mut all = fit.hypotheses.clone();
        let own = all.remove(own);
        all.push(own);
        let (_, all) = self.machine.searched(&fit, all, spread, seed);
        Some(self.table.with(at, all.last()?))
    }
}

impl Machine {
    /// The patches near `places` that gain most at the gains of `base`, and `least`.
    fn patches(&self, base: &Filtered, places: &[[f64; 2]], least: f64) -> Vec<Hypothesis> {
        let Some(info) = find("friction_patch") else {
            return Vec::new();
        };
        let still = base.deviance - base.log_determinant();
        let b = self.model.robot.half_track_m;
        let each = places.par_iter().filter_map(|place| {
            let tried = around(info, *place, b).into_par_iter();
            let tried = tried.filter_map(|h| {
                let e = self.bounded_innovations(base, &base.beside(&h))?;
                Some((self.deviance(&e), h))
            });
            let best = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
            let (deviance, mut all) = self.searched(base, base.beside(&best.1), &WIDE, 1);
            Some((still - deviance, all.pop()?))
        });
        let mut moved: Vec<(f64, Hypothesis)> = each.filter(|(gain, _)| *gain > least).collect();
        moved.sort_by(|a, b| b.0.total_cmp(&a.0));
        moved.truncate(PATCHES);
        moved.into_iter().map(|(_, own)| own).collect()
    }

    /// Places of the floor where something pushes the robot of `base` while a wheel is there: most first.
    fn conspicuous_places(&self, fit: &Filtered, base: &Filtered) -> Option<Vec<[f64; 2]>> {
        let mut wheels: Vec<Vec<(f64, [[f64; 2]; 2])>> = vec![Vec::new(); self.runs.len()];
        let b = self.model.robot.half_track_m;
        self.watched(fit, &fit.hypotheses, |run, t_s, state, _| {
            wheels[run].push((t_s, self.contacts(state.pose())));
        })?;
        let mut gains: BTreeMap<[i64; 2], f64> = BTreeMap::new();
        for (run, impulse) in self.impulses(base) {
            let own = &wheels[run];
            let at = own.partition_point(|(t_s, _)| *t_s < impulse.t_s);
            for wheel in own.get(at).iter().flat_map(|(_, places)| places) {
                let cell = wheel.map(|at| (at / (CELL * b)).round() as i64);
                *gains.entry(cell).or_default() += impulse.gain - NO_PUSH;
            }
        }
        let mut cells: Vec<([i64; 2], f64)> = gains.into_iter().collect();
        cells.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        cells.retain(|(_, gain)| *gain > PLACE_GAIN);
        let mut places: Vec<[f64; 2]> = Vec::new();
        for (cell, _) in cells {
            let place = cell.map(|i| i as f64 * CELL * b);
            let apart = |other: &[f64; 2]| (place[0] - other[0]).hypot(place[1] - other[1]);
            if places.len() < CELLS && places.iter().all(|other| apart(other) > APART * b) {
                places.push(place);
            }
        }
        places.extend(middle(&places, NEAR * b));
        Some(places)
    }

    /// The last of `all`, a patch, moved and resized by a random search from `seed` at the gains of `fit`; and −2 ln L
    /// there, but for what does not depend on it. Its edge has no usable derivative.
    fn searched(
        &self,
        fit: &Filtered,
        all: Vec<Hypothesis>,
        spread: &[f64; 4],
        seed: u64,
    ) -> (f64, Vec<Hypothesis>) {
        let value = |all: &[Hypothesis]| {
            let e = self.bounded_innovations(fit, all);
            e.map_or(f64::INFINITY, |e| self.deviance(&e))
        };
        let mut best = (value(&all), all);
        let Some(own) = best.1.last().cloned() else {
            return best;
        };
        let get = |name: &str| own.value(name).unwrap_or(0.0);
        let mut at = [
            get("x_m"),
            get("y_m"),
            get("radius_m"),
            1.0 / get("friction"),
        ];
        let b = self.model.robot.half_track_m;
        let lengths = [b, b, b, 1.0];
        let mut random = Random(seed);
        let mut scale = 1.0;
        let mut again: Option<[f64; 4]> = None;
        for _ in 0..TRIALS {
            let mut trial = at;
            // a step that gained is taken once more: patches that mend one edge after the other lie along a valley
            if let Some(step) = again.take() {
                for (own, step) in trial.iter_mut().zip(step) {
                    *own += step;
                }
            } else {
                for ((own, spread), length) in trial.iter_mut().zip(spread).zip(lengths) {
                    if random.uniform() < 0.7 {
                        *own += spread * length * scale * random.normal();
                    }
                }
            }
            trial[2] = trial[2].abs().clamp(RADIUS[0] * b, RADIUS[1] * b);
            trial[3] = trial[3].abs().max(LEAST_INVERSE);
            let mut all = best.1.clone();
            all.pop();
            all.push(patch(own.info, trial));
            let value = value(&all);
            if value < best.0 {
                again = Some(std::array::from_fn(|i| WIDER * (trial[i] - at[i])));
                (best, at) = ((value, all), trial);
                scale *= WIDER;
            } else {
                scale *= NARROWER;
            }
        }
        best
    }
}

/// The middle of the places near the first one: where wheels enter a patch and leave it something pushes as well.
fn middle(places: &[[f64; 2]], near_m: f64) -> Option<[f64; 2]> {
    let [x, y] = *places.first()?;
    let near = places
        .iter()
        .filter(|own| (own[0] - x).hypot(own[1] - y) < near_m);
    let (count, sum) = near.fold((0.0, [0.0; 2]), |(count, sum), own| {
        (count + 1.0, [sum[0] + own[0], sum[1] + own[1]])
    });
    (count > 1.0).then(|| sum.map(|own| own / count))
}

/// Patches around a place, for a robot of this half track (m).
fn around(
    info: &'static slipstream_sim::effects::Info,
    [x, y]: [f64; 2],
    b: f64,
) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for dx in WAYS {
        for dy in WAYS {
            for radius in RADII {
                for friction in FRICTIONS {
                    all.push(patch(
                        info,
                        [x + dx * b, y + dy * b, radius * b, 1.0 / friction],
                    ));
                }
            }
        }
    }
    all
}

fn patch(info: &'static slipstream_sim::effects::Info, [x, y, r, inverse]: [f64; 4]) -> Hypothesis {
    let values = vec![
        ("x_m", x),
        ("y_m", y),
        ("radius_m", r),
        ("friction", 1.0 / inverse),
    ];
    Hypothesis::new(info, values)
}

/// Random numbers of a fixed seed: the same search finds the same.
struct Random(u64);

impl Random {
    /// The upper bits of a linear congruential generator (Knuth's MMIX).
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Standard normal, by twelve uniform numbers.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}
