//! Runs of one machine beside runs of it from before.
//!
//! Both are filtered together. Parameters of the machine are those from before; what changed since is
//! added to them in the runs of today. So what both share cancels, and how well the runs from before know
//! a parameter counts in every test of its change.
//!
//! In a vector of parameters the changes stand first, where the parameters of a machine stand that is
//! compared with nothing; what both share stands at its end.

use crate::data::wheel_path::Turned;
use crate::estimate::blocks::Blocks;

/// Which runs are from before, and how these differ among themselves.
#[derive(Debug, Clone, Default)]
pub(crate) struct Before {
    /// The first so many runs are from before; 0 where nothing is compared.
    pub(crate) runs: usize,
    /// Number of robots given before those of today.
    pub(crate) robots: usize,
    /// Deviations of the logarithms of scale and track among them, where they differ.
    pub(crate) spread: [Option<f64>; 2],
    /// The cluster of each block, where every run of today drives the course of one from before and was
    /// measured at the same moments.
    pub(crate) clusters: Option<Vec<usize>>,
    /// How much later (s) and faster than before each reference was stamped against the wheels, or the wheels
    /// against the commands, by their rows.
    pub(crate) stamped: [[f64; 2]; SHARES],
}

/// Index of the parameters that say how much two recordings of one course have in common: of poses (or
/// of wheels under commands), and of the gyro.
pub(crate) const SHARES: usize = 2;

impl Before {
    /// Whether there are runs from before.
    pub(crate) fn any(&self) -> bool {
        self.runs > 0
    }

    /// Whether a run is from before.
    pub(crate) fn has(&self, run: usize) -> bool {
        run < self.runs
    }

    /// Whether every run of today is compared row by row with the one from before of the same number.
    pub(crate) fn is_paired(&self) -> bool {
        self.clusters.is_some()
    }

    /// Whether enough runs of both kinds, of `runs` in all, show how runs differ.
    pub(crate) fn shows_spread(&self, runs: usize, least: usize) -> bool {
        !self.any() || self.runs >= least && runs - self.runs >= least
    }
}

/// The first `count` parameters of a run: of `at`, or what is shared from `shared` on, with the change of
/// a run of today.
pub(super) fn of_machine(at: &[f64], count: usize, shared: usize, is_before: bool) -> Vec<f64> {
    let base = at[shared..shared + count].iter();
    if is_before {
        return base.copied().collect();
    }
    base.zip(at).map(|(own, change)| own + change).collect()
}

/// Where these parameters stand in the vector: pairs of the run's own number and the place.
pub(super) fn places(count: usize, shared: usize, is_before: bool) -> Vec<(usize, usize)> {
    let base = (0..count).map(|i| (i, shared + i));
    if is_before {
        return base.collect();
    }
    base.chain((0..count).map(|i| (i, i))).collect()
}

/// Of the `places` of a run those that are `free`: the run's own numbers without repetition, and pairs of
/// the place in that list and the place among the free ones.
pub(super) fn lanes(
    places: impl Iterator<Item = (usize, usize)>,
    free: &[usize],
) -> (Vec<usize>, Vec<(usize, usize)>) {
    let mut own: Vec<usize> = Vec::new();
    let mut pairs = Vec::new();
    for (local, index) in places {
        let Some(to) = free.iter().position(|f| *f == index) else {
            continue;
        };
        let lane = own.iter().position(|l| *l == local).unwrap_or_else(|| {
            own.push(local);
            own.len() - 1
        });
        pairs.push((lane, to));
    }
    (own, pairs)
}

/// Pieces into which a course is cut to be compared.
const PIECES: u32 = 200;
/// Cosine between the pieces from which on two courses are one.
const SAME_COURSE: f64 = 0.98;

/// How both wheels turned, piece by piece (rad), between two times (s).
pub(super) fn course(wheels: &dyn Turned<f64>, [from_s, to_s]: [f64; 2]) -> Vec<f64> {
    let mut hint = 0;
    let at = |k: u32| from_s + (to_s - from_s) * f64::from(k) / f64::from(PIECES);
    let angles: Vec<[f64; 2]> = (0..=PIECES)
        .map(|k| wheels.angles_at(at(k), &mut hint))
        .collect();
    let pieces = angles.windows(2);
    pieces
        .flat_map(|pair| [0, 1].map(|i| pair[1][i] - pair[0][i]))
        .collect()
}

/// Whether two courses are one, but for a factor.
pub(super) fn is_same(a: &[f64], b: &[f64]) -> bool {
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let both = (dot(a, a) * dot(b, b)).sqrt();
    both > 0.0 && dot(a, b) > SAME_COURSE * both
}

/// Clusters of blocks where every run of today drives the course of one from before: what goes wrong on
/// it goes wrong in both. `runs` are blocks and course of each.
pub(super) fn clusters(before: usize, runs: &[(Blocks, Vec<f64>)]) -> Option<Vec<usize>> {
    let (then, now) = runs.split_at_checked(before)?;
    let pairs = || then.iter().zip(now);
    let alike = pairs().all(|((a, one), (b, other))| a.count == b.count && is_same(one, other));
    if before == 0 || then.len() != now.len() || !alike {
        return None;
    }
    let first = now.first()?.0.first;
    let total = now.last()?.0.end();
    Some((0..total).map(|block| block % first).collect())
}
