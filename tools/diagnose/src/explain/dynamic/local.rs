//! Effects at one time or place: pushes by a backward pass, patches by trying places along the way.

use rayon::prelude::*;
use slipstream_sim::effects::find;

use super::channels::weights;
use super::fit::{Fit, may_slide};
use super::machine::Machine;
use super::screen::{Candidate, beside};
use crate::filter::dynamic::impulse::{Impulse, impulses};
use crate::model::hypothesis::Hypothesis;

/// A push lasts this long (s); its first instant lies half of it before the middle.
const PUSH_S: f64 = 0.06;

/// Gusts at most, and the time before and after its largest impulse (s) that belongs to one.
const GUSTS: usize = 16;
const GUST_S: [f64; 2] = [0.08, 0.15];

/// Cells of the floor in which a patch is tried (m), and how many of them at most beside their
/// neighbours.
const CELL_M: f64 = 0.1;
const CELLS: usize = 12;
/// Frictions and radii (m) with which each is tried.
const TRIED: [[f64; 2]; 6] = [
    [0.05, 0.1],
    [0.05, 0.2],
    [0.08, 0.15],
    [0.08, 0.25],
    [0.14, 0.15],
    [0.14, 0.3],
];
/// Patches that are looked at with gains of their own.
const PATCHES: usize = 6;

/// Gain (−2 ln L) at the gains of the rolling model below which a place is not looked at again.
const PLACE_GAIN: f64 = 6.0;

/// Trials of a shrinking random search, and how fast it shrinks.
const TRIALS: u32 = 60;
const SHRINKS: f64 = 0.965;
/// Share of what small noise on the wheels costs that a place has to bring back.
const SHARE: f64 = 0.2;
/// Rounds of the search, and the gain (−2 ln L) of one below which the next is narrower.
const ROUNDS: usize = 6;
const ROUND_GAIN: f64 = 20.0;
/// Standard deviations of the first trials: x, y, radius (m) and one over the friction.
const WIDE: [f64; 4] = [0.12, 0.12, 0.08, 3.0];
const NARROW: [f64; 4] = [0.04, 0.04, 0.03, 1.2];
/// Bounds of radius (m) and of one over the friction.
const RADII_M: [f64; 2] = [0.03, 1.0];
const LEAST_INVERSE: f64 = 2.0;

impl Machine {
    /// The impulse that gains most beside `fit`, and its run.
    fn impulse(&self, fit: &Fit) -> Option<(usize, Impulse)> {
        let weights = weights(&fit.whitened, &self.channels);
        let lever = self.model.robot.com_to_axle_m.unwrap_or(0.0);
        let mut first = 0;
        let mut best: Option<(usize, Impulse)> = None;
        for (run, pass) in fit.passes.iter().enumerate() {
            let end = first + 3 * self.runs[run].rows.len();
            let own = impulses(pass, &fit.whitened[first..end], &weights[first..end], lever);
            let left_out = &self.runs[run].left_out_s;
            let believed = |t_s: f64| {
                let mut near = left_out.iter();
                !near.any(|[from, to]| (from - PUSH_S..=to + PUSH_S).contains(&t_s))
            };
            for impulse in own.into_iter().filter(|own| believed(own.t_s)) {
                if best.is_none_or(|(_, known)| impulse.gain > known.gain) {
                    best = Some((run, impulse));
                }
            }
            first = end;
        }
        best
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
        self.excluded.push("push".to_owned());
        self.nominal()
    }

    /// The push that gains most beside `fit`.
    pub(crate) fn push(&self, fit: &Fit) -> Option<Candidate> {
        if may_slide(&self.model, &fit.hypotheses) || !self.has_pose() {
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

    /// The patch that gains most beside `fit`, fitted.
    pub(crate) fn patch(&self, fit: &Fit) -> Option<Candidate> {
        if !self.has_pose() {
            return None;
        }
        let info = find("friction_patch")?;
        let base = if may_slide(&self.model, &fit.hypotheses) {
            fit.clone()
        } else {
            self.rolling_with_wheel_noise(fit)?
        };
        let places = self.conspicuous_places(fit, &base)?;
        let tried: Vec<Hypothesis> = places
            .iter()
            .flat_map(|[x, y]| {
                TRIED.map(|[friction, radius_m]| patch(info, [*x, *y, radius_m, 1.0 / friction]))
            })
            .collect();
        let value = |at: &Fit, h: &Hypothesis| {
            let e = self.innovations(at, &beside(fit, h))?;
            Some(self.deviance(&e))
        };
        let still = base.deviance - base.log_determinant();
        let mut ranked: Vec<(f64, &Hypothesis)> = tried
            .par_iter()
            .filter_map(|h| Some((still - value(&base, h)?, h)))
            .filter(|(gain, _)| *gain > PLACE_GAIN.max(SHARE * (base.deviance - fit.deviance)))
            .collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        // the best place of each friction and radius: they have optima of their own
        let mut kinds: Vec<[Option<f64>; 2]> = Vec::new();
        ranked.retain(|(_, h)| {
            let kind = [h.value("friction"), h.value("radius_m")];
            let new = !kinds.contains(&kind);
            kinds.push(kind);
            new
        });
        ranked.truncate(PATCHES);
        let settled = ranked.par_iter().filter_map(|(_, h)| {
            let begun = self.begun(fit, beside(fit, h))?;
            Some(self.settled(begun, &WIDE))
        });
        let best = settled.min_by(|a, b| a.deviance.total_cmp(&b.deviance))?;
        Some(Candidate {
            hypothesis: best.hypotheses.last()?.clone(),
            gain: fit.deviance - best.deviance,
            fit: Some(best),
        })
    }

    /// Places of the floor where the innovations of `base` are largest, and those beside them.
    fn conspicuous_places(&self, fit: &Fit, base: &Fit) -> Option<Vec<[f64; 2]>> {
        let mut places: Vec<[f64; 2]> = Vec::new();
        self.watched(fit, &fit.hypotheses, |_, _, state, _| {
            let [x, y, _] = state.pose();
            places.push([x, y]);
        })?;
        let mut energy: Vec<([i64; 2], f64)> = Vec::new();
        let squares = base
            .whitened
            .chunks(3)
            .map(|row| row.iter().map(|e| e * e).sum::<f64>());
        let stamps = self.stamps.chunks(3).map(|row| row[0]);
        let mut all: Vec<(usize, f64, f64)> = stamps
            .zip(squares)
            .map(|((stamp_s, run), square)| (run, stamp_s, square))
            .collect();
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        // rows and places are in nearly the same order: by time
        for ((_, _, square), place) in all.iter().zip(&places) {
            let cell = place.map(|at| (at / CELL_M).round() as i64);
            match energy.iter_mut().find(|(known, _)| *known == cell) {
                Some((_, sum)) => *sum += square,
                None => energy.push((cell, *square)),
            }
        }
        energy.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        energy.truncate(CELLS);
        let mut cells: Vec<[i64; 2]> = Vec::new();
        for ([i, k], _) in energy {
            for (di, dk) in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)] {
                let cell = [i + di, k + dk];
                if !cells.contains(&cell) {
                    cells.push(cell);
                }
            }
        }
        Some(
            cells
                .iter()
                .map(|cell| cell.map(|i| i as f64 * CELL_M))
                .collect(),
        )
    }

    /// The last effect of `fit`, a patch, moved and resized by a random search, and the noise anew. Its
    /// edge has no usable derivative.
    fn moved_patch(&self, fit: Fit, spread: &[f64; 4]) -> Option<Fit> {
        let own = fit.hypotheses.last()?.clone();
        let get = |name: &str| own.value(name).unwrap_or(0.0);
        let mut at = [
            get("x_m"),
            get("y_m"),
            get("radius_m"),
            1.0 / get("friction"),
        ];
        let mut best = fit.deviance - fit.log_determinant();
        let mut random = Random(1);
        let mut shrunk = 1.0;
        for _ in 0..TRIALS {
            let mut trial = at;
            for (own, spread) in trial.iter_mut().zip(spread) {
                if random.uniform() < 0.7 {
                    *own += spread * shrunk * random.normal();
                }
            }
            shrunk *= SHRINKS;
            trial[2] = trial[2].abs().clamp(RADII_M[0], RADII_M[1]);
            trial[3] = trial[3].abs().max(LEAST_INVERSE);
            let mut all = fit.hypotheses.clone();
            *all.last_mut()? = patch(own.info, trial);
            let Some(e) = self.innovations(&fit, &all) else {
                continue;
            };
            let value = self.deviance(&e);
            if value < best {
                (best, at) = (value, trial);
            }
        }
        let mut all = fit.hypotheses.clone();
        *all.last_mut()? = patch(own.info, at);
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
        for _ in 0..ROUNDS {
            let before = fit.deviance;
            let Some(next) = self.moved_patch(fit.clone(), &spread) else {
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

fn patch(info: &'static slipstream_sim::effects::Info, [x, y, r, inverse]: [f64; 4]) -> Hypothesis {
    let values = vec![
        ("x_m", x),
        ("y_m", y),
        ("radius_m", r),
        ("friction", 1.0 / inverse),
    ];
    Hypothesis::new(info, values)
}

fn wrapped(angle: f64) -> f64 {
    let turns = (angle / std::f64::consts::TAU).round();
    angle - turns * std::f64::consts::TAU
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
