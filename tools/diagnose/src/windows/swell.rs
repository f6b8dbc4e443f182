//! A floor in waves: the direction and the wave number after which a force along the body goes.
//!
//! The spectrum of a force that is sampled wherever a robot happens to drive, by least squares at each
//! wave vector (Lomb, 1976), in two dimensions. Such a floor pulls along the waves, whichever way the
//! robot faces.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::windows::drivers::Driver;
use crate::windows::sampled::Sampled;
use crate::windows::wander::GROUP;

/// Shortest wave that is looked for (m).
const SHORTEST_M: f64 = 0.1;
/// Wave numbers at most along either axis.
const FINEST: usize = 160;
/// Half waves over all that was visited at least: a part of one is a slope.
const FEWEST: i32 = 4;
/// Moments at least.
const MOMENTS: usize = 20;
/// How often the best wave vector is looked for between its neighbours, each time half as far.
const CLOSER: usize = 10;
/// Share of what waves in any direction explain that waves along an axis have to.
const ALIKE: f64 = 0.9;

/// A force at one place.
struct Pull {
    place_m: [f64; 2],
    faces: [f64; 2],
    force_n: f64,
}

/// The floor in waves that the force along the body, piece by piece, goes after best. `None` where
/// places are not known.
pub(crate) fn driver(samples: &[Vec<Sampled>], forces: &[Vec<[f64; 2]>]) -> Option<Driver> {
    let pulls = pulls(samples, forces);
    let extent = |i: usize| {
        let places = pulls.iter().map(|pull| pull.place_m[i]);
        places.clone().fold(f64::NEG_INFINITY, f64::max) - places.fold(f64::INFINITY, f64::min)
    };
    let extent_m = extent(0).max(extent(1));
    if pulls.len() < MOMENTS || extent_m < f64::from(FEWEST) * SHORTEST_M {
        return None;
    }
    // half a wave over all that was visited
    let step = PI / extent_m;
    let most = ((TAU / SHORTEST_M / step) as usize).min(FINEST) as i32;
    // a wave vector and its opposite are the same floor
    let rows = (0..=most).into_par_iter();
    let rows = rows.filter_map(|i| {
        let row = (-most..=most).filter(|j| i * i + j * j >= FEWEST * FEWEST && (i > 0 || *j > 0));
        let vectors = row.map(|j| [f64::from(i) * step, f64::from(j) * step]);
        best(&pulls, vectors)
    });
    let any = closer(
        &pulls,
        rows.max_by(|a, b| a.0.total_cmp(&b.0))?,
        step,
        [1.0, 1.0],
    )?;
    let axes = [[1.0, 0.0], [0.0, 1.0]].map(|axis| {
        let waves = (FEWEST..=most).map(|i| axis.map(|along| along * f64::from(i) * step));
        closer(&pulls, best(&pulls, waves)?, step, axis)
    });
    // people lay floors along their axes
    let axes = axes.into_iter().flatten();
    let along = axes.max_by(|a, b| a.0.total_cmp(&b.0));
    let (_, [x, y]) = along.filter(|along| along.0 > ALIKE * any.0).unwrap_or(any);
    Some(Driver::swell(y.atan2(x), x.hypot(y)))
}

/// The best wave vector near one that was found on a grid with this step, along `axes`.
fn closer(
    pulls: &[Pull],
    mut found: (f64, [f64; 2]),
    step: f64,
    axes: [f64; 2],
) -> Option<(f64, [f64; 2])> {
    let mut apart = axes.map(|axis| axis * step / 2.0);
    for _ in 0..CLOSER {
        let ([x, y], [far_x, far_y]) = (found.1, apart);
        let near = [-1.0, 0.0, 1.0].into_iter();
        let near = near.flat_map(|i| [-1.0, 0.0, 1.0].map(|j| [x + i * far_x, y + j * far_y]));
        found = best(pulls, near)?;
        apart = apart.map(|apart| apart / 2.0);
    }
    Some(found)
}

fn pulls(samples: &[Vec<Sampled>], forces: &[Vec<[f64; 2]>]) -> Vec<Pull> {
    let windows = samples.iter().zip(forces);
    let pulls = windows.flat_map(|(samples, forces)| {
        let pieces = samples.chunks_exact(GROUP).zip(forces);
        pieces.map(|(samples, force)| {
            let mean = |of: fn(&Sampled) -> f64| samples.iter().map(of).sum::<f64>() / GROUP as f64;
            Pull {
                place_m: [mean(|s| s.pose[0]), mean(|s| s.pose[1])],
                faces: [mean(|s| s.pose[2].cos()), mean(|s| s.pose[2].sin())],
                force_n: force[0],
            }
        })
    });
    let seen = |pull: &Pull| {
        pull.place_m
            .iter()
            .chain(&pull.faces)
            .all(|v| v.is_finite())
    };
    pulls.filter(seen).collect()
}

/// The wave vector (rad/m) that explains most, and how much (N²).
fn best(pulls: &[Pull], vectors: impl Iterator<Item = [f64; 2]>) -> Option<(f64, [f64; 2])> {
    let powers = vectors.map(|vector| (power(pulls, vector), vector));
    powers.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Sum of squares that waves of this vector explain by their best phase and height (N²).
fn power(pulls: &[Pull], [x, y]: [f64; 2]) -> f64 {
    let wave = x.hypot(y);
    let (mut ss, mut cc, mut sc, mut sf, mut cf) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for pull in pulls {
        let along = (pull.faces[0] * x + pull.faces[1] * y) / wave;
        let (sin, cos) = (pull.place_m[0] * x + pull.place_m[1] * y).sin_cos();
        let (sin, cos) = (along * sin, along * cos);
        ss += sin * sin;
        cc += cos * cos;
        sc += sin * cos;
        sf += sin * pull.force_n;
        cf += cos * pull.force_n;
    }
    let determinant = ss * cc - sc * sc;
    // too alike to be told apart: neither is
    if determinant > 1e-6 * ss * cc {
        (sf * sf * cc - 2.0 * sf * cf * sc + cf * cf * ss) / determinant
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::windows::drivers::tests::samples;
    use crate::windows::force::Part;

    /// A force that waves of this vector (rad/m) pull with, piece by piece.
    fn forces(samples: &[Vec<Sampled>], [x, y]: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
        let pull = |s: &Sampled| {
            let along = (x * s.pose[2].cos() + y * s.pose[2].sin()) / x.hypot(y);
            0.3 * along * (x * s.pose[0] + y * s.pose[1] + 0.7).sin()
        };
        let pieces = |samples: &Vec<Sampled>| {
            let pieces = samples.chunks_exact(GROUP);
            pieces
                .map(|piece| [piece.iter().map(pull).sum::<f64>() / GROUP as f64, 0.0])
                .collect()
        };
        samples.iter().map(pieces).collect()
    }

    /// A robot in a loop of 2 m by 1 m, with pieces of a centimetre or so: the waves pull as the true
    /// ones do everywhere, to some hundredths of a radian of their phase.
    #[test]
    fn waves_are_found_along_an_axis_and_across() {
        let samples = samples();
        for (vector, name) in [
            ([14.0, 0.0], "x"),
            ([0.0, 11.0], "y"),
            ([9.0, 7.0], "position"),
        ] {
            let forces = forces(&samples, vector);
            let found = driver(&samples, &forces).unwrap();
            assert_eq!(found.name, name);
            let phase = found.values(&samples[0][40], Part::Longitudinal);
            let [x, y] = vector;
            let true_ones = Driver::swell(y.atan2(x), x.hypot(y));
            let expected = true_ones.values(&samples[0][40], Part::Longitudinal);
            for (found, expected) in phase.iter().zip(expected) {
                assert!(
                    (found.1.abs() - expected.1.abs()).abs() < 0.05,
                    "{vector:?}"
                );
            }
        }
    }

    #[test]
    fn without_places_there_are_no_waves() {
        let mut samples = samples();
        let forces = forces(&samples, [14.0, 0.0]);
        samples[0].iter_mut().for_each(|s| s.pose = [f64::NAN; 3]);
        assert!(driver(&samples, &forces).is_none());
    }
}
