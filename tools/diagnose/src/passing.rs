//! A force that acts for a while and not else: a gust, or a place that the robot comes to.

use std::ops::Range;

use crate::bench::Bench;
use crate::drivers::{Driver, Sampled};
use crate::force::{self, CHARGE, Missing, Part};
use crate::unknown::{Likelier, PAY};
use crate::wander::{EXPLAINED, GROUP, Judge, PIECE_S, Wander};

/// Share of the largest force below which it does not count as acting, and pieces more at both ends.
const STRONG: f64 = 0.15;
const MARGIN: usize = 2;
/// Share of a force's energy that has to be the same when the robot comes to a place again, and time
/// after which it does (s).
const AGAIN: f64 = 0.5;
const APART_S: f64 = 1.0;

/// A force that acts for a while and not else, if that is likelier than one that always wanders.
pub(crate) fn passing(
    bench: &Bench,
    judge: &Judge,
    samples: &[Vec<Sampled>],
    wander: &Wander,
) -> Option<Likelier> {
    let forces = judge.forces(&wander.level)?;
    let scale = scale(bench);
    let active = active(&forces, scale);
    let within = judge.within(&active, wander.level)?;
    let gain = wander.deviance - within.deviance;
    if gain < PAY[0] || within.rest > EXPLAINED {
        return None;
    }
    let energy = |i: usize| -> f64 {
        let all = forces.iter().flatten();
        all.map(|force| (force[i] * scale[i]).powi(2)).sum()
    };
    let part = usize::from(energy(1) > energy(0));
    let mut pieces: Vec<Piece> = Vec::new();
    for (w, (forces, active)) in forces.iter().zip(&active).enumerate() {
        for (k, force) in forces.iter().enumerate() {
            pieces.push(Piece {
                at_s: bench.windows[w].from_s + PIECE_S * (k as f64 + 0.5),
                sampled: samples[w][k * GROUP],
                force: if active.contains(&k) {
                    force[part]
                } else {
                    0.0
                },
            });
        }
    }
    let axes = [0, 1].into_iter();
    let places = axes.filter_map(|axis| placed(Driver::along(axis, samples)?, &pieces));
    let place = places.max_by(|a, b| a.share.total_cmp(&b.share));
    let (driver, against, weights) = match place {
        Some(place) => (place.driver, place.against, place.weights),
        None => {
            let forces = pieces.iter().map(|piece| piece.force).collect();
            let instants_s = pieces.iter().map(|piece| piece.at_s).collect();
            (Driver::time(instants_s), false, forces)
        }
    };
    let missing = Missing {
        part: [Part::Longitudinal, Part::Yaw][part],
        driver,
        against,
        weights,
        deviance: within.deviance,
    };
    Some(Likelier {
        missing,
        score: within.deviance + 2.0 * CHARGE,
        gain,
    })
}

/// What a newton along and a newton metre about accelerate a wheel's contact by (m/s²).
fn scale(bench: &Bench) -> [f64; 2] {
    let [mass, inertia] = force::inertia(bench);
    [1.0 / mass, bench.model.robot.half_track_m / inertia]
}

/// The pieces of each window between the first and the last in which a force is strong.
fn active(forces: &[Vec<[f64; 2]>], scale: [f64; 2]) -> Vec<Range<usize>> {
    let strength = |f: &[f64; 2]| (f[0] * scale[0]).abs().max((f[1] * scale[1]).abs());
    let most = forces.iter().flatten().map(strength).fold(0.0, f64::max);
    let strong = |f: &[f64; 2]| strength(f) > STRONG * most;
    let of = |forces: &Vec<[f64; 2]>| {
        let ends = forces.iter().position(strong);
        let ends = ends.zip(forces.iter().rposition(strong));
        ends.map_or(0..0, |(first, last)| {
            first.saturating_sub(MARGIN)..(last + 1 + MARGIN).min(forces.len())
        })
    };
    forces.iter().map(of).collect()
}

/// A force over a piece of time.
struct Piece {
    at_s: f64,
    sampled: Sampled,
    force: f64,
}

/// A force that is the same whenever the robot comes to a place.
struct Placed {
    driver: Driver,
    against: bool,
    weights: Vec<f64>,
    /// Share of the force's energy that is the same each time.
    share: f64,
}

/// The force of `pieces` as one of a place, if the robot came there again and found most of it again.
fn placed(driver: Driver, pieces: &[Piece]) -> Option<Placed> {
    let total: f64 = pieces.iter().map(|p| p.force * p.force).sum();
    let best = [false, true].map(|against| {
        let signed = |p: &Piece| p.force * if against { -p.sampled.v.signum() } else { 1.0 };
        let mut cells: Vec<Vec<(f64, f64)>> = vec![Vec::new(); driver.functions()];
        for piece in pieces {
            let near = driver
                .values(&piece.sampled, Part::Longitudinal)
                .into_iter();
            if let Some((cell, _)) = near.max_by(|a, b| a.1.total_cmp(&b.1)) {
                cells[cell].push((piece.at_s, signed(piece)));
            }
        }
        let mut again = 0.0;
        let mut weights = Vec::new();
        for cell in &cells {
            let mean = cell.iter().map(|c| c.1).sum::<f64>() / cell.len().max(1) as f64;
            let comes_back = cell.windows(2).any(|pair| pair[1].0 - pair[0].0 > APART_S);
            if comes_back {
                again += mean * mean * cell.len() as f64;
            }
            weights.push(mean);
        }
        Placed {
            driver: driver.clone(),
            against,
            weights,
            share: again / total.max(1e-300),
        }
    });
    let best = best
        .into_iter()
        .max_by(|a, b| a.share.total_cmp(&b.share))?;
    (best.share > AGAIN).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::{Piece, active, placed};
    use crate::drivers::{Driver, Sampled};

    fn sampled(t_s: f64, x_m: f64, v: f64) -> Sampled {
        Sampled {
            t_s,
            v,
            w: 0.0,
            angle: [0.0; 2],
            pose: [x_m, 0.0, 0.0],
            asked: [0.0; 2],
            rested_s: 0.0,
        }
    }

    /// To 1 m and back in 20 s; `force` of the time (s), the place (m) and the speed (m/s).
    fn pieces(force: impl Fn(f64, f64, f64) -> f64) -> (Vec<Vec<Sampled>>, Vec<Piece>) {
        let pieces = (0..200).map(|k| {
            let at_s = 0.1 * f64::from(k);
            let (x_m, v) = if at_s < 10.0 {
                (0.1 * at_s, 0.1)
            } else {
                (2.0 - 0.1 * at_s, -0.1)
            };
            Piece {
                at_s,
                sampled: sampled(at_s, x_m, v),
                force: force(at_s, x_m, v),
            }
        });
        let pieces: Vec<Piece> = pieces.collect();
        (vec![pieces.iter().map(|p| p.sampled).collect()], pieces)
    }

    #[test]
    fn what_comes_back_with_the_place_follows_it() {
        let (samples, pieces) = pieces(|_, x_m, v| {
            let on = (0.3..0.5).contains(&x_m);
            if on { -0.6 * v.signum() } else { 0.0 }
        });
        let place = placed(Driver::along(0, &samples).unwrap(), &pieces).unwrap();
        assert!(place.against && place.share > 0.8, "{}", place.share);
        let most = place.weights.iter().copied().fold(0.0, f64::max);
        assert!((most - 0.6).abs() < 1e-9, "{most}");
    }

    #[test]
    fn what_happened_once_follows_no_place() {
        let (samples, pieces) =
            pieces(|at_s, _, _| f64::from(u8::from((3.0..5.0).contains(&at_s))));
        assert!(placed(Driver::along(0, &samples).unwrap(), &pieces).is_none());
    }

    #[test]
    fn only_pieces_near_a_strong_force_are_active() {
        let mut forces = vec![vec![[0.01, 0.0]; 50]; 3];
        forces[1][20] = [1.0, 0.0];
        forces[1][24] = [0.0, 0.5];
        assert_eq!(active(&forces, [1.0, 1.0]), [0..0, 18..27, 0..0]);
    }
}
