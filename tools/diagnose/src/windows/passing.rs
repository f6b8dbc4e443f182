//! A force that acts for a while and not else: a gust, a place that the robot comes to, or a floor to
//! which it sticks where it stands.

use std::ops::Range;

use crate::windows::bench::Bench;
use crate::windows::drivers::Driver;
use crate::windows::force::{self, CHARGE, Missing, Part};
use crate::windows::sampled::Sampled;
use crate::windows::unknown::{Likelier, PAY};
use crate::windows::wander::{EXPLAINED, GROUP, Judge, PIECE_S, Wander};

/// Share of the largest force below which it does not count as acting, and pieces more at both ends.
const STRONG: f64 = 0.15;
const MARGIN: usize = 2;
/// Share of a force's energy that has to be the same when the robot comes to a place again, and time
/// after which it does (s).
const AGAIN: f64 = 0.5;
const APART_S: f64 = 1.0;
/// Share of a force's energy that has to be spent while the robot stands or sets off where it holds the
/// robot.
const HOLDS: f64 = 0.7;

/// A force that acts for a while and not else, if that is likelier than one that always wanders.
pub(crate) fn passing(
    bench: &Bench,
    judge: &Judge,
    samples: &[Vec<Sampled>],
    forces: &[Vec<[f64; 2]>],
    wander: &Wander,
) -> Option<Likelier> {
    let scale = scale(bench);
    let active = active(forces, scale);
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
    let repeated = place.or_else(|| held(Driver::rest(samples)?, &pieces));
    let (driver, against, weights) = match repeated {
        Some(repeated) => (repeated.driver, repeated.against, repeated.weights),
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

/// A force that is the same whenever a variable is.
struct Repeated {
    driver: Driver,
    against: bool,
    weights: Vec<f64>,
    /// Share of the force's energy that speaks for it.
    share: f64,
}

/// The force of `pieces` as one of a place, if the robot came there again and found most of it again.
fn placed(driver: Driver, pieces: &[Piece]) -> Option<Repeated> {
    let best = [false, true].map(|against| {
        let cells = cells(&driver, pieces, against);
        let weights = means(&cells);
        let again = cells.iter().map(|cell| again(cell));
        Repeated {
            share: again.sum::<f64>() / energy(pieces.iter()),
            driver: driver.clone(),
            against,
            weights,
        }
    });
    let best = best
        .into_iter()
        .max_by(|a, b| a.share.total_cmp(&b.share))?;
    (best.share > AGAIN).then_some(best)
}

/// How much of the force of one cell is there at each visit: energy that a visit shares with the others.
fn again(cell: &[(f64, f64)]) -> f64 {
    let total: f64 = cell.iter().map(|(_, force)| force).sum();
    let visits = cell.chunk_by(|(a_s, _), (b_s, _)| b_s - a_s < APART_S);
    let shared = visits.map(|visit| {
        let count = visit.len() as f64;
        let own: f64 = visit.iter().map(|(_, force)| force).sum();
        let others = (total - own) / (cell.len() as f64 - count).max(1.0);
        let own = own / count;
        count * (own * others).clamp(0.0, own * own)
    });
    shared.sum()
}

/// The force of `pieces` as one that holds the robot where it stands, if most of it acts then.
fn held(driver: Driver, pieces: &[Piece]) -> Option<Repeated> {
    let stands = pieces.iter().filter(|piece| piece.sampled.rested_s > 0.0);
    let share = energy(stands) / energy(pieces.iter());
    let weights = means(&cells(&driver, pieces, false));
    (share > HOLDS).then_some(Repeated {
        driver,
        against: false,
        weights,
        share,
    })
}

fn energy<'a>(pieces: impl Iterator<Item = &'a Piece>) -> f64 {
    pieces
        .map(|piece| piece.force.powi(2))
        .sum::<f64>()
        .max(1e-300)
}

/// When (s) and how large the force is at each function of `driver`; or how large it is against the
/// motion.
fn cells(driver: &Driver, pieces: &[Piece], against: bool) -> Vec<Vec<(f64, f64)>> {
    let mut cells: Vec<Vec<(f64, f64)>> = vec![Vec::new(); driver.functions()];
    for piece in pieces {
        let values = driver.values(&piece.sampled, Part::Longitudinal);
        let nearest = values.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((cell, _)) = nearest {
            let sign = if against {
                -piece.sampled.v.signum()
            } else {
                1.0
            };
            cells[cell].push((piece.at_s, piece.force * sign));
        }
    }
    cells
}

fn means(cells: &[Vec<(f64, f64)>]) -> Vec<f64> {
    let cells = cells.iter();
    let means = cells.map(|cell| cell.iter().map(|c| c.1).sum::<f64>() / cell.len().max(1) as f64);
    means.collect()
}

#[cfg(test)]
mod tests {
    use super::{Piece, active, held, placed};
    use crate::windows::drivers::Driver;
    use crate::windows::sampled::Sampled;

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
        let gust = |at_s: f64, _: f64, _: f64| f64::from(u8::from((3.0..5.0).contains(&at_s)));
        let (samples, mut pieces) = pieces(gust);
        let driver = Driver::along(0, &samples).unwrap();
        assert!(placed(driver.clone(), &pieces).is_none());
        // nor where the robot comes back for a fourth of the time only
        let mut kept = 0;
        pieces.retain(|piece| {
            kept += 1;
            piece.at_s < 10.0 || kept % 4 == 0
        });
        assert!(placed(driver, &pieces).is_none());
    }

    /// At rest for the third and fourth of every six seconds, and pulled then, or at another time.
    #[test]
    fn what_acts_while_the_robot_stands_holds_it() {
        let rest = |at_s: f64| at_s.rem_euclid(6.0) - 2.0;
        let stands = |at_s: f64| (0.0..2.0).contains(&rest(at_s));
        let begun = |force: &dyn Fn(f64) -> f64| {
            let (mut samples, mut pieces) = pieces(|at_s, _, _| force(at_s));
            for (sampled, piece) in samples[0].iter_mut().zip(&mut pieces) {
                sampled.rested_s = if stands(piece.at_s) {
                    rest(piece.at_s)
                } else {
                    0.0
                };
                piece.sampled = *sampled;
            }
            held(Driver::rest(&samples).unwrap(), &pieces)
        };
        let holding = begun(&|at_s| if stands(at_s) { -0.3 * rest(at_s) } else { 0.0 }).unwrap();
        let last = *holding.weights.last().unwrap();
        assert!((last + 0.57).abs() < 0.04, "{:?}", holding.weights);
        assert!(begun(&|at_s| f64::from(u8::from(at_s > 7.0))).is_none());
    }

    #[test]
    fn only_pieces_near_a_strong_force_are_active() {
        let mut forces = vec![vec![[0.01, 0.0]; 50]; 3];
        forces[1][20] = [1.0, 0.0];
        forces[1][24] = [0.0, 0.5];
        assert_eq!(active(&forces, [1.0, 1.0]), [0..0, 18..27, 0..0]);
    }
}
