//! Effects at one time or place: pushes by a backward pass, patches by trying places along the way.

use std::collections::BTreeMap;

use rayon::prelude::*;
use slipstream_sim::effects::find;

use super::channels::weights;
use super::fit::Fit;
use super::machine::Machine;
use super::screen::{Candidate, beside};
use crate::filter::dynamic::impulse::{Impulse, impulses};
use crate::filter::wrapped;
use crate::model::hypothesis::Hypothesis;

/// A push lasts this long (s); its first instant lies half of it before the middle.
const PUSH_S: f64 = 0.06;

/// Gusts at most, and the time before and after its largest impulse (s) that belongs to one.
const GUSTS: usize = 16;
const GUST_S: [f64; 2] = [0.08, 0.15];

/// Lengths by which a patch is looked for are in half tracks. Cells of the floor in which one is tried,
/// and how many of them at most.
const CELL: f64 = 0.8;
const CELLS: usize = 8;
/// Least distance between two of them.
const APART: f64 = 1.5;
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

/// Share of the gain of the best of all others below which a patch is not fitted.
const RIVAL: f64 = 0.3;

/// Trials of a random search, and how its steps grow with success and shrink without: one in five
/// succeeds where they stay as they are (evolution strategy; Rechenberg 1973).
const TRIALS: u32 = 60;
const WIDER: f64 = 1.5;
const NARROWER: f64 = 0.9;
/// Share of what small noise on the wheels costs that a place has to bring back.
const SHARE: f64 = 0.2;
/// Rounds of the search, and the gain (−2 ln L) of one below which the next is narrower.
const ROUNDS: u64 = 6;
const ROUND_GAIN: f64 = 20.0;
/// Standard deviations of the first trials: x, y, radius, and one over the friction.
const WIDE: [f64; 4] = [1.2, 1.2, 0.8, 3.0];
const NARROW: [f64; 4] = [0.4, 0.4, 0.3, 1.2];
/// Bounds of the radius and of one over the friction.
const RADIUS: [f64; 2] = [0.3, 10.0];
const LEAST_INVERSE: f64 = 2.0;

impl Machine {
    /// Impulses beside `fit` in every interval that is believed, each with its run.
    fn impulses(&self, fit: &Fit) -> Vec<(usize, Impulse)> {
        let weights = weights(&fit.whitened, &self.channels);
        let lever = self.model.robot.com_to_axle_m.unwrap_or(0.0);
        let mut first = 0;
        let mut all = Vec::new();
        for (run, pass) in fit.passes.iter().enumerate() {
            let end = first + 3 * self.runs[run].rows.len();
            let own = impulses(pass, &fit.whitened[first..end], &weights[first..end], lever);
            let left_out = &self.runs[run].left_out_s;
            let believed = |impulse: &Impulse| {
                let mut near = left_out.iter();
                !near.any(|[from, to]| (from - PUSH_S..=to + PUSH_S).contains(&impulse.t_s))
            };
            all.extend(own.into_iter().filter(believed).map(|own| (run, own)));
            first = end;
        }
        all
    }

    /// The impulse that gains most beside `fit`, and its run.
    fn impulse(&self, fit: &Fit) -> Option<(usize, Impulse)> {
        let all = self.impulses(fit).into_iter();
        all.reduce(|best, own| if own.1.gain > best.1.gain { own } else { best })
    }

    /// Marks the times at which something pushes for a moment beside `nominal`, one after the other,
    /// while that gains `due` (−2 ln L). Returns the nominal model there.
    pub(crate) fn mark_gusts(&mut self, nominal: Fit, due: f64) -> Option<Fit> {
        let mut fit = nominal;
        for _ in 0..GUSTS {
            let Some((run, impulse)) = self.impulse(&fit).filter(|(_, own)| own.gain > due) else {
                break;
            };
            let [before, after] = GUST_S;
            self.runs[run]
                .gusts_s
                .push([impulse.t_s - before, impulse.t_s + after]);
            let next = self.pass(Vec::new(), fit.noise)?;
            fit = self.with_noise(next, 1, super::noise_sizes::QUICK);
        }
        self.nominal(&[])
    }

    /// The push that gains most beside `fit`.
    pub(crate) fn push(&self, fit: &Fit) -> Option<Candidate> {
        if !self.has_pose() {
            return None;
        }
        let info = find("push")?;
        let (run, impulse) = self.impulse(fit)?;
        let mut heading = 0.0;
        self.watched(fit, &fit.hypotheses, |index, t_s, state, _| {
            if index == run && t_s <= impulse.t_s {
                heading = state.pose()[2];
            }
        })?;
        let [along, across] = impulse.size;
        let hypothesis = Hypothesis::new(
            info,
            vec![
                ("t_s", (impulse.t_s - 0.5 * PUSH_S).max(0.0)),
                ("impulse_n_s", along.hypot(across)),
                ("direction_rad", wrapped(heading + across.atan2(along))),
            ],
        );
        Some(Candidate {
            hypothesis,
            gain: impulse.gain,
            fit: None,
        })
    }

    /// The patch that gains most beside `fit`, fitted; none where the best of all others, with a gain of
    /// `rival` (−2 ln L), gains much more at a glance.
    pub(crate) fn patch(&self, fit: &Fit, rival: f64) -> Option<Candidate> {
        if !self.has_pose() {
            return None;
        }
        let base = self.rolling_with_wheel_noise(fit)?;
        let places = self.conspicuous_places(fit, &base)?;
        // at small noise what slides is told from what pushes; where only noise is left, at its own
        let least = PLACE_GAIN.max(RIVAL * rival);
        let least_at_base = least.max(SHARE * (base.deviance - fit.deviance));
        let mut moved = self.patches(fit, &base, &places, least_at_base);
        moved.extend(self.patches(fit, fit, &places, least));
        let settled = moved.into_par_iter().filter_map(|all| {
            let begun = self.begun(fit, all)?;
            Some(self.settled(begun, &WIDE))
        });
        let best = settled.min_by(|a, b| a.deviance.total_cmp(&b.deviance))?;
        Some(Candidate {
            hypothesis: best.hypotheses.last()?.clone(),
            gain: fit.deviance - best.deviance,
            fit: Some(best),
        })
    }

    /// The patches near `places` that gain most beside `fit` at the gains of `base`, and `least`.
    fn patches(
        &self,
        fit: &Fit,
        base: &Fit,
        places: &[[f64; 2]],
        least: f64,
    ) -> Vec<Vec<Hypothesis>> {
        let Some(info) = find("friction_patch") else {
            return Vec::new();
        };
        let still = base.deviance - base.log_determinant();
        let b = self.model.robot.half_track_m;
        let each = places.par_iter().filter_map(|place| {
            let tried = around(info, *place, b).into_par_iter();
            let tried = tried.filter_map(|h| {
                let e = self.promising(base, &beside(fit, &h))?;
                Some((self.deviance(&e), h))
            });
            let best = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
            let (deviance, all) = self.searched(base, beside(fit, &best.1), &WIDE, 1);
            Some((still - deviance, all))
        });
        let mut moved: Vec<(f64, Vec<Hypothesis>)> =
            each.filter(|(gain, _)| *gain > least).collect();
        moved.sort_by(|a, b| b.0.total_cmp(&a.0));
        moved.truncate(PATCHES);
        moved.into_iter().map(|(_, all)| all).collect()
    }

    /// Places of the floor where something pushes the robot of `base` while a wheel is there: most first.
    fn conspicuous_places(&self, fit: &Fit, base: &Fit) -> Option<Vec<[f64; 2]>> {
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
        Some(places)
    }

    /// The last of `all`, a patch, moved and resized by a random search from `seed` at the gains of `fit`; and −2 ln L
    /// there, but for what does not depend on it. Its edge has no usable derivative.
    fn searched(
        &self,
        fit: &Fit,
        all: Vec<Hypothesis>,
        spread: &[f64; 4],
        seed: u64,
    ) -> (f64, Vec<Hypothesis>) {
        let value = |all: &[Hypothesis]| {
            let e = self.promising(fit, all);
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
        for _ in 0..TRIALS {
            let mut trial = at;
            for ((own, spread), length) in trial.iter_mut().zip(spread).zip(lengths) {
                if random.uniform() < 0.7 {
                    *own += spread * length * scale * random.normal();
                }
            }
            trial[2] = trial[2].abs().clamp(RADIUS[0] * b, RADIUS[1] * b);
            trial[3] = trial[3].abs().max(LEAST_INVERSE);
            let mut all = best.1.clone();
            all.pop();
            all.push(patch(own.info, trial));
            let value = value(&all);
            if value < best.0 {
                (best, at) = ((value, all), trial);
                scale *= WIDER;
            } else {
                scale *= NARROWER;
            }
        }
        best
    }

    /// The last effect of `fit`, a patch, moved and resized, and the noise anew.
    fn moved_patch(&self, fit: Fit, spread: &[f64; 4], seed: u64) -> Option<Fit> {
        let (_, all) = self.searched(&fit, fit.hypotheses.clone(), spread, seed);
        let moved = self.pass(all, fit.noise)?;
        let moved = self.with_noise(moved, 1, super::noise_sizes::QUICK);
        Some(if moved.deviance < fit.deviance {
            moved
        } else {
            fit
        })
    }

    /// A patch moved while that gains: the noise falls as it comes near, and the search sharpens.
    fn settled(&self, mut fit: Fit, spread: &[f64; 4]) -> Fit {
        let mut spread = *spread;
        for round in 1..=ROUNDS {
            let before = fit.deviance;
            let Some(next) = self.moved_patch(fit.clone(), &spread, round) else {
                break;
            };
            fit = next;
            if before - fit.deviance < ROUND_GAIN {
                spread = spread.map(|own| own * 0.5);
            }
        }
        fit
    }

    /// A patch to the end: narrower and narrower.
    pub(crate) fn settled_patch(&self, fit: Fit) -> Fit {
        self.settled(fit, &NARROW)
    }
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
